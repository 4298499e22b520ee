"""Hours of faults.

    python -m tests.faults --hours 2 --seed 0 --jobs 2

drives formations through rendered pictures as fast as it goes, lets everything of docs/safety.md
happen to them at random times, and says what became of it; exit status 1 if a promise was broken.
"""

import argparse
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from math import inf

from pipeline.cli.output import Output
from pipeline.progress import ShareLine
from tests.faults.missions import Mission, run_mission
from tests.faults.schedule import KINDS
from tests.faults.watch import Record

AT_A_TIME = 2  # missions that a process is given
SHOWN = 30  # broken promises that are told
HEADER = (
    "fault", "injected", "survived", "stood after s", "drove again after s", "in formation after s",
    "least gap mm",
)  # fmt: skip


def main() -> int:
    """Run the missions.

    Returns:
        The exit status.
    """
    asked = _arguments()
    line, done = ShareLine("missions"), list[Mission]()
    task = partial(run_mission, duration=asked.mission, scenario=asked.scenario)
    seed, seconds, wanted = asked.seed, 0.0, 3600.0 * asked.hours
    with ProcessPoolExecutor(asked.jobs) as pool:
        while seconds < wanted:
            some = range(seed, seed + asked.jobs * AT_A_TIME)
            for mission in pool.map(task, some):
                done.append(mission)
                seconds += mission.lasted
                line.show(min(seconds / wanted, 1.0))
            seed = some.stop
    line.close()
    return tell(done, Output(as_json=False))


def tell(missions: Sequence[Mission], output: Output) -> int:
    """Say what became of missions.

    Args:
        missions: all of them.
        output: where.

    Returns:
        The exit status: 1 if a promise was broken.
    """
    broken = [(mission.seed, what) for mission in missions for what in mission.broken]
    guilty = {seed for seed, _ in broken}
    rows = [_row(kind, missions, guilty) for kind in KINDS]
    output.table("Faults (worst times)", HEADER, [row for row in rows if row[1] != "0"])
    hours = sum(mission.lasted for mission in missions) / 3600.0
    ends = [mission.ended for mission in missions]
    told = ", ".join(f"{ends.count(end)} {end}" for end in sorted(set(ends)))
    output.say(f"{hours:.2f} h of missions; they ended: {told}")
    for seed, what in broken[:SHOWN]:
        output.say(f"BROKEN, seed {seed}: {what}")
    output.say(f"{len(broken)} promises broken in {len(guilty)} of {len(missions)} missions")
    return 1 if broken else 0


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--hours", type=float, default=2.0, help="simulated time [h]")
    parser.add_argument("--seed", type=int, default=0, help="of the first mission")
    parser.add_argument("--jobs", type=int, default=2, help="missions side by side")
    parser.add_argument("--mission", type=float, default=120.0, help="how long one lasts [s]")
    parser.add_argument("--scenario", default="paper", help="whose robots, camera and laws")
    return parser.parse_args()


def _row(kind: str, missions: Sequence[Mission], guilty: set[int]) -> tuple[str, ...]:
    found = [(m.seed, r) for m in missions for r in m.records if r.fault.kind == kind]
    records = [record for _, record in found]
    survived = sum(seed not in guilty for seed, _ in found)
    return (
        kind, str(len(found)), str(survived), _worst(records, lambda r: r.stood),
        _worst(records, lambda r: r.ran), _worst(records, lambda r: r.formed),
        f"{1e3 * min((r.gap for r in records), default=inf):.1f}",
    )  # fmt: skip


def _worst(records: Sequence[Record], of: Callable[[Record], float | None]) -> str:
    times = [time for record in records if (time := of(record)) is not None]
    return f"{max(times):.2f}" if times else "-"


if __name__ == "__main__":
    sys.exit(main())
