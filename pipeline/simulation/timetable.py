"""When frames arrive in a run, and what mission and safety rules make of that.

All robots are in every frame, so neither depends on how the robots drive: the rules themselves
(`pipeline/guard.py`, `pipeline/mission.py`) decide before the machine code starts.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from math import floor

import numpy as np

from control.command import RobotId
from control.estimation import Estimate
from datasets.cycle import SafetyEvent, Tick
from pipeline.filming import make_delivery
from pipeline.guard import GuardMemory, watch_over
from pipeline.live import ENDS
from pipeline.memory import Mission, Track
from pipeline.mission import advance, watch
from pipeline.simulation.experiment import Experiment
from vision.frame import as_frame
from vision.scene import Scene

DRIVING = ("running", "holding")
"""Phases in which commands are sent."""

_SLACK = 1e-9  # a frame is not missed for the rounding of its time [s]
_PICTURE = as_frame(np.zeros((1, 1, 3), np.uint8), 0.0, 0)

Glimpses = Callable[[int], Scene | None]


@dataclass(frozen=True, slots=True)
class HandedFrame:
    """A frame as the loop gets it.

    Attributes:
        tick: at which.
        taken: when its picture was really taken [s].
        stamp: when it says it was [s].
    """

    tick: int
    taken: float
    stamp: float


@dataclass(frozen=True, slots=True)
class Row:
    """One tick.

    Attributes:
        phase: of the mission.
        mission: tick on the mission's clock, -1 before the start.
        share: of its speed that every robot may drive.
    """

    phase: str
    mission: int
    share: float


@dataclass(frozen=True, slots=True)
class Timetable:
    """The course of a run.

    Attributes:
        frames: that the loop looks at, in the order of their ticks.
        rows: one a tick.
        mission: at the end; it remembers what was watched before its start.
        events: what the safety rules did.
    """

    frames: tuple[HandedFrame, ...]
    rows: tuple[Row, ...]
    mission: Mission
    events: tuple[SafetyEvent, ...]

    @property
    def driving(self) -> tuple[int, int]:
        """First tick with commands, and the one behind the last."""
        ticks = [tick for tick, row in enumerate(self.rows) if row.phase in DRIVING]
        return (ticks[0], ticks[-1] + 1) if ticks else (len(self.rows), len(self.rows))


def handed_frames(experiment: Experiment, seed: int) -> tuple[HandedFrame, ...]:
    """The frames that the loop looks at, as `cameras.rendered` would hand them out.

    Args:
        experiment: camera and ticks.
        seed: of what is lost, repeated and wrongly stamped.

    Returns:
        The frames; a picture that comes again, bit for bit, counts as none.
    """
    camera, period = experiment.scenario.camera, experiment.setup.period
    delivery = make_delivery(camera, seed)
    frames: list[HandedFrame] = []
    following, last = 0, -1
    for tick in range(experiment.ticks):
        newest = floor((tick * period - camera.latency_s + _SLACK) * camera.fps)
        arrived = [n for n in range(following, newest + 1) if delivery.arrives(n)]
        following = max(following, newest + 1)
        picture = delivery.shown(arrived[-1]) if arrived else last
        if picture != last:
            n, last = arrived[-1], picture
            stamp = delivery.stamp(n, n / camera.fps, 1.0 / camera.fps)
            frames.append(HandedFrame(tick, picture / camera.fps, stamp))
    return tuple(frames)


def make_timetable(
    experiment: Experiment, frames: tuple[HandedFrame, ...], glimpses: Glimpses
) -> Timetable:
    """Let the rules run over all ticks.

    Args:
        experiment: rules and mission.
        frames: that the loop looks at.
        glimpses: what the frame of a number shows, for a mission that watches first; else None.

    Returns:
        The timetable; it ends with the mission, or with the experiment's ticks.
    """
    setup, handed = experiment.setup, {frame.tick: n for n, frame in enumerate(frames)}
    guard, mission, rows, events = GuardMemory(), Mission(), [], []
    seen: dict[RobotId, float] = {}
    for number in range(experiment.ticks):
        tick, scene = Tick(number * setup.period), None
        if number in handed:
            stamp = frames[handed[number]].stamp
            tick, scene = replace(tick, frame=_PICTURE), glimpses(handed[number])
            seen = dict.fromkeys(setup.formation.robots, stamp)
        guard, shares, told = watch_over(setup.rules, guard, setup.formation, seen, tick)
        mission = watch(setup, mission, scene)
        mission = advance(setup, mission, _tracks(seen), shares, tick, setup.period)
        share = shares[setup.formation.root]
        rows.append(Row(mission.phase, _mission_tick(mission, tick.t, setup.period), share))
        events += told
        if mission.phase in ENDS:
            break
    looked_at = tuple(frame for frame in frames if frame.tick < len(rows))
    return Timetable(looked_at, tuple(rows), mission, tuple(events))


def _tracks(seen: Mapping[RobotId, float]) -> Mapping[RobotId, Track]:
    """Tracks that tell the mission when robots were seen, and no more."""
    return {robot: _track(t) for robot, t in seen.items()}


@lru_cache(maxsize=4)
def _track(t: float) -> Track:
    estimate = Estimate(t, np.zeros(7), np.zeros((7, 7)))
    return Track(estimate, estimate.state, t)


def _mission_tick(mission: Mission, t: float, period: float) -> int:
    return -1 if mission.t_start is None else round((t - mission.t_start) / period)
