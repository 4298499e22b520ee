"""`echelon live` in a ring while things happen to it, and how fast its robots stood."""

import os
import signal
import subprocess
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from math import inf
from pathlib import Path
from time import monotonic, sleep
from typing import Any

from tests.hardware.ring import ROOT, Ring, Truth, lateness, ring
from tests.pipeline.commands import ECHELON

UNDER_WAY = 1.2  # from the first command to the first event [s]
LATE, TRIES = 0.1, 3  # of the world's frames: then the machine was at fault [s]
STANDS = 0.02  # a robot that is slower stands [m/s]
LONG = ("leader.speed_mps=0.3", "duration_s=60")  # a mission that outlasts what happens


@dataclass(frozen=True)
class Way:
    """How a run is driven.

    Attributes:
        changes: of the scenario, the world's and the program's.
        stream: "mjpeg" or "udp".
        options: further ones of the program.
        environment: what the program's has besides.
    """

    changes: Sequence[str] = LONG
    stream: str = "mjpeg"
    options: Sequence[object] = ()
    environment: Mapping[str, str] = field(default_factory=dict)


USUAL = Way()


class Driven:
    """A run under way, and what its robots were told."""

    def __init__(self, outside: Ring, way: Way) -> None:
        self.outside = outside
        command = (*ECHELON, "live", "paper", "--camera", outside.url, "--radio", outside.radio)
        changes = (part for change in way.changes for part in ("--set", change))
        self.process = subprocess.Popen(
            (*command, *map(str, way.options), *changes, "--duration", "60", "--json"),
            cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
            env={**os.environ, "PYTHONUNBUFFERED": "1", **way.environment},
            preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_DFL),  # nohup ignores it
        )  # fmt: skip

    def under_way(self) -> None:
        """Wait until the robots drive."""
        end = monotonic() + 60.0
        while not any(moves(robot) for robot in self.outside.truth()["robots"]):
            assert self.process.poll() is None, self.process.communicate()[1]
            assert monotonic() < end
            sleep(0.1)
        sleep(UNDER_WAY)

    def suffer(self, order: str, for_so_long: float) -> None:
        """Let something happen, and wait."""
        self.outside.happen(order)
        sleep(for_so_long)

    def send(self, number: int) -> float:
        """Send a signal; when, on the machine's clock [s]."""
        t = monotonic()
        self.process.send_signal(number)
        return t

    def end(self, number: int) -> str:
        """End it by a signal; what it said."""
        self.process.send_signal(number)
        return self.process.communicate(timeout=30.0)[1]


def driven(folder: Path, course: Callable[[Driven], None], way: Way = USUAL) -> Truth:
    """Let a run drive, let something happen to it, and say what was true at the end."""
    with ring(folder, stream=way.stream, changes=way.changes) as outside:
        run = Driven(outside, way)
        try:
            run.under_way()
            course(run)
        finally:
            run.process.kill()
            run.process.wait(10.0)
        return outside.finish()


def held(
    folder: Path, course: Callable[[Driven], None], check: Callable[[Truth], None], way: Way = USUAL
) -> None:
    """Let a run drive and check what was true; again if it fails and the world itself was late."""
    for attempt in range(1, TRIES + 1):
        place = folder / str(attempt)
        place.mkdir()
        truth = driven(place, course, way)
        try:
            return check(truth)
        except AssertionError:
            if lateness(truth) < LATE or attempt == TRIES:
                raise
    return None


def moves(robot: Truth) -> list[float]:
    """When a robot was told to move."""
    return [t for t, left, right in robot["commands"] if (left, right) != (0, 0)]


@dataclass(frozen=True)
class Episode:
    """What a robot did between an event and its end.

    Attributes:
        order: the event.
        robot: its id.
        begin: when the event began [s].
        end: when it was over [s].
        told: from the event to the last command to move before its end; 0 if there was none [s].
        stood: from the event until the robot stood till its end; infinite if it did not [s].
        again: from the end of the event to the next command to move; infinite if none came [s].
    """

    order: str
    robot: int
    begin: float
    end: float
    told: float
    stood: float
    again: float

    def __str__(self) -> str:
        return (
            f"{self.order}: robot {self.robot} told to move until {self.told:.3f} s, "
            f"stood after {self.stood:.3f} s, told again {self.again:.3f} s after the end"
        )


def episodes(truth: Truth) -> Iterator[Episode]:
    """Every robot's part in everything that happened; events come in pairs of begin and end.

    Args:
        truth: see `Outside.truth`.

    Yields:
        Events in their order, in each the robots in theirs.
    """
    events = truth["events"]
    for begin, end in zip(events[::2], events[1::2], strict=True):
        for robot in truth["robots"]:
            yield episode(truth, robot, begin["order"].strip(), (begin["t"], end["t"]))


def episode(truth: Truth, robot: Truth, order: str, span: tuple[float, float]) -> Episode:
    """A robot's part in one event.

    Args:
        truth: see `Outside.truth`.
        robot: the robot's part of it.
        order: name of the event.
        span: when it began and ended [s].

    Returns:
        What the robot did.
    """
    begin, end = span
    told = [t - begin for t in moves(robot) if begin < t < end]
    again = [t - end for t in moves(robot) if t >= end]
    return Episode(
        order, robot["id"], begin, end, max(told, default=0.0),
        _stood(truth, robot["id"], begin, end), min(again, default=inf),
    )  # fmt: skip


def _stood(truth: Truth, robot: int, begin: float, end: float) -> float:
    frames = [frame for frame in truth["frames"] if begin <= frame["t"] < end]
    fast = [abs(_of(frame, robot)["v_mps"]) >= STANDS for frame in frames]
    if fast[-1]:
        return inf
    last = max((n for n, (a, b) in enumerate(pairwise(fast)) if a and not b), default=-1)
    return float(frames[last + 1]["t"]) - begin


def _of(frame: Truth, robot: int) -> dict[str, Any]:
    return next(r for r in frame["robots"] if r["id"] == robot)
