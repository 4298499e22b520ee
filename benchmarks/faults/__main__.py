"""Random faults in simulated driving: drives for hours, and prints what was survived."""

import argparse
import sys
from time import perf_counter

from benchmarks.faults import table
from benchmarks.faults.many import Mission, mission, missions
from pipeline.progress import ShareLine


def main() -> int:
    """Drive, judge, print.

    Returns:
        Exit status: 1 if a promise was broken.
    """
    options, start = _options(), perf_counter()
    if options.mission is not None:
        driven = [mission(options.mission, options.seed)]
        print(table.story(driven[0]))
    else:
        driven = _driven(options.hours, options.seed, options.jobs)
        print(f"{table.table(driven)}\n\n{table.EXPLANATION}\n{table.summary(driven)}")
        print(f"seed {options.seed}, {perf_counter() - start:.0f} s on {options.jobs} processes")
    broken = table.failures(driven)
    print(broken or "every promise was kept")
    return 1 if broken else 0


def _driven(hours: float, seed: int, jobs: int) -> list[Mission]:
    """All missions, and how far they are."""
    line = ShareLine("faults")
    try:
        return list(missions(3600.0 * hours, seed, jobs, line.show))
    finally:
        line.close()


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.faults", description=__doc__)
    parser.add_argument("--hours", type=float, default=2.0, help="to be simulated")
    parser.add_argument("--seed", type=int, default=0, help="of all that is random")
    parser.add_argument("--jobs", type=int, default=2, help="processes at a time")
    parser.add_argument("--mission", type=int, help="drive this one only, and tell it in detail")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
