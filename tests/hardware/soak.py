"""The whole ring for minutes: does anything grow, drift, stop or come late?

    python -m tests.hardware.soak --minutes 10 --view soak.rrd

A streamed picture, `echelon live`, three Miabots on ptys, the paper's formation round and round.
Ends with a table. `--busy 2` lets two processes spin beside it; `--set` changes the scenario of
world and program, e.g. `--set radio.link_bytes_per_s=4000` for commands at 100 Hz.
"""

import argparse
import json
import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from math import degrees
from pathlib import Path
from tempfile import TemporaryDirectory
from time import monotonic, sleep
from typing import Any

import numpy as np

from tests.hardware.formed import WANTED, errors
from tests.hardware.memory import Growth, Memory
from tests.hardware.ring import ROOT, Ring, Truth, lateness, ring
from tests.pipeline.commands import ECHELON

RADIUS, SPEED = 0.5, 0.3  # of the leader's circle, about the middle of the picture [m, m/s]
SETTLING = 10.0  # from the first command: the change of size comes at 5.5 s [s]
HARMLESS = {"kept-apart"}
SPINNING = "while True: pass"

Rows = Sequence[tuple[str, str]]


@dataclass(frozen=True, slots=True)
class Soaked:
    """What came of it.

    Attributes:
        result: the program's JSON.
        truth: the world's.
        program: memory of the program.
        viewer: memory of its viewer, None without one.
        status: of the program's exit.
        load: average of the last minute at the end.
    """

    result: dict[str, Any]
    truth: Truth
    program: Growth
    viewer: Growth | None
    status: int
    load: float


def circle(minutes: float) -> tuple[str, ...]:
    """What to change in `paper` so that it fills some minutes inside the picture.

    Args:
        minutes: of the mission.

    Returns:
        As `--set` takes them.
    """
    turn = degrees(SPEED / RADIUS * 60.0 * (minutes + 1.0))
    return (
        f"camera.center_m=[0.0, {RADIUS}]", f"leader.speed_mps={SPEED}", "camera.latency_s=0.0035",
        f"leader.segments=[{{ radius_m = {RADIUS}, turn_deg = {turn:.0f} }}]",
        f"duration_s={60.0 * minutes}",
    )  # fmt: skip


def soak(minutes: float, view: str = "none", busy: int = 0, changes: Sequence[str] = ()) -> Soaked:
    """Run it.

    Args:
        minutes: of the mission.
        view: as `echelon live --view` takes it.
        busy: processes that spin meanwhile.
        changes: of the scenario, as `--set` takes them.

    Returns:
        What came of it.
    """
    changes = (*circle(minutes), *changes)
    with ExitStack() as stack:
        folder = Path(stack.enter_context(TemporaryDirectory()))
        stack.enter_context(spinning(busy))
        outside = stack.enter_context(
            ring(folder, duration=60.0 * minutes + 120.0, changes=changes)
        )
        process = _start(outside, view, changes)
        program, viewer = Memory(process.pid), Memory.of_child(process.pid)
        while process.poll() is None:
            program.look()
            viewer.look()
            sleep(1.0)
        said = process.communicate()[0]
        truth = outside.finish()
    view_memory = viewer.growth if view != "none" else None
    result = json.loads(said) if said else {}
    load = os.getloadavg()[0]
    return Soaked(result, truth, program.growth, view_memory, process.returncode, load)


@contextmanager
def spinning(count: int) -> Iterator[None]:
    """Keep cores busy with processes that do nothing.

    Args:
        count: of them.

    Yields:
        While they spin.
    """
    with ExitStack() as stack:
        for _ in range(count):
            spinner = subprocess.Popen((sys.executable, "-c", SPINNING))
            stack.callback(spinner.wait)
            stack.callback(spinner.kill)
        yield


def rows(soaked: Soaked) -> Rows:
    """The table.

    Args:
        soaked: what came of it.

    Returns:
        What, and how much of it in its unit.
    """
    return (*_of_the_program(soaked), *_of_the_world(soaked.truth))


def _start(outside: Ring, view: str, changes: Sequence[str]) -> "subprocess.Popen[str]":
    options = [part for change in changes for part in ("--set", change)]
    command = (*ECHELON, "live", "paper", "--camera", outside.url, "--radio", outside.radio)
    return subprocess.Popen(
        (*command, *options, "--view", view, "--json"), cwd=ROOT, stdout=subprocess.PIPE, text=True
    )


def _of_the_program(soaked: Soaked) -> Iterator[tuple[str, str]]:
    r, load = soaked.result, f"{soaked.load:.2f}"
    yield "exit status of the program, load average of the last minute", f"{soaked.status}, {load}"
    yield (
        "duration s, frames, commands",
        f"{r['duration_s']:.1f}, {r['frames']}, {r['commands_sent']}",
    )
    yield "memory of the program: after 1 min, at the end MB; growth MB/min", str(soaked.program)
    if soaked.viewer is not None:
        yield "memory of its viewer: after 1 min, at the end MB; growth MB/min", str(soaked.viewer)
    latency = r["latency_ms"]
    middle, high = latency["frame_to_command_p50"], latency["frame_to_command_p99"]
    yield "frame to command, computing: median, 99 % ms", f"{middle:.2f}, {high:.2f}"
    for row in r["cadence"]:
        figures = ", ".join(f"{row[key]:.2f}" for key in ("median_ms", "p99_ms", "most_ms"))
        yield f"{row['what']}: median, 99 %, most ms", figures
    for link in r["links"]:
        rates = f"{link['asked_per_s']:.1f}, {link['carried_per_s']:.1f}"
        yield f"robot {link['robot_id']}: commands asked, carried 1/s", rates
    kinds = [event["kind"] for event in r["safety_events"]]
    apart = sum(kind in HARMLESS for kind in kinds)
    bad = ", ".join(kind for kind in kinds if kind not in HARMLESS)
    yield "kept apart, times; other safety events", f"{apart}; {bad or 'none'}"


def _of_the_world(truth: Truth) -> Iterator[tuple[str, str]]:
    told = [command[0] for robot in truth["robots"] for command in robot["commands"]]
    begin, end = min(told, default=0.0) + SETTLING, max(told, default=0.0) - 0.5
    driven = [frame for frame in truth["frames"] if begin <= frame["t"] <= end]
    for follower in WANTED if driven else ():
        error = np.abs(errors(driven, follower))
        distance, bearing = 1e3 * error[:, 0], np.degrees(error[:, 1])
        yield (
            f"robot {follower}, true errors once settled: rms, worst mm; rms, worst deg",
            f"{_rms(distance):.2f}, {distance.max():.2f}; {_rms(bearing):.2f}, {bearing.max():.2f}",
        )
    least = min(frame["clearance_m"] for frame in truth["frames"])
    yield "least clearance between bodies mm", f"{1e3 * least:.1f}"
    timeouts = ", ".join(str(robot["timeouts"]) for robot in truth["robots"])
    yield "stops by the robots' own timeouts, by robot", timeouts
    yield "the world itself late by at most ms", f"{1e3 * lateness(truth):.1f}"


def _rms(values: "np.ndarray[Any, np.dtype[np.float64]]") -> float:
    return float(np.sqrt(np.mean(values**2)))


def main() -> None:
    """Soak and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--view", default="none", help="none, rerun or FILE.rrd")
    parser.add_argument("--busy", type=int, default=0, help="processes that spin meanwhile")
    parser.add_argument("--set", action="append", default=[], help="section.key=value")
    args = parser.parse_args()
    start = monotonic()
    soaked = soak(args.minutes, args.view, args.busy, args.set)
    if not soaked.result:
        sys.exit(f"the program ended with status {soaked.status} and no result")
    for name, figures in rows(soaked):
        print(f"{name:72} {figures}")  # noqa: T201 (its output)
    print(f"took {monotonic() - start:.0f} s")  # noqa: T201


if __name__ == "__main__":
    main()
