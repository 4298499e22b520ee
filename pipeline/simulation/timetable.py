"""When frames arrive in a run, and what mission and safety rules make of that.

All robots are in every frame, so neither depends on how the robots drive: the rules themselves
(`pipeline/guard.py`, `pipeline/supervisor.py`) decide before the machine code starts.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from math import floor

import numpy as np

from control.command import RobotId
from control.estimation import Estimate
from datasets.cycle import SafetyEvent, Tick
from datasets.simulation.inputs import Floats, Integers
from pipeline.filming import make_delivery
from pipeline.guard import GuardMemory, watch_over
from pipeline.memory import Mission, Track
from pipeline.simulation.experiment import Experiment
from pipeline.supervisor import DRIVING, ENDS, supervise
from pipeline.watching import watch
from vision.frame import as_frame
from vision.scene import Scene

_SLACK = 1e-9  # a frame is not missed for the rounding of its time [s]
_PICTURE = as_frame(np.zeros((1, 1, 3), np.uint8), 0.0, 0)

Glimpses = Callable[[int], Scene | None]


@dataclass(frozen=True, slots=True)
class HandedFrames:
    """The frames that the loop looks at.

    Attributes:
        ticks: (F,) at which they come.
        taken: (F,) when their pictures were really taken [s].
        stamps: (F,) when they say they were [s].
    """

    ticks: Integers
    taken: Floats
    stamps: Floats

    def __len__(self) -> int:
        """How many."""
        return len(self.ticks)


@dataclass(frozen=True, slots=True)
class Timetable:
    """The course of a run of T ticks.

    Attributes:
        frames: that the loop looks at.
        phases: of the mission, one a tick.
        mission: (T,) tick on the mission's clock, -1 before the start.
        shares: (T,) of its speed that every robot may drive.
        driving: first tick with commands, and the one behind the last.
        end: the mission at the end; it remembers what was watched before its start.
        events: what the safety rules did.
    """

    frames: HandedFrames
    phases: tuple[str, ...]
    mission: Integers
    shares: Floats
    driving: tuple[int, int]
    end: Mission
    events: tuple[SafetyEvent, ...]

    @property
    def ticks(self) -> int:
        """Number of ticks."""
        return len(self.phases)


def handed_frames(experiment: Experiment, seed: int) -> HandedFrames:
    """The frames that the loop looks at, as `cameras.rendered` would hand them out.

    Args:
        experiment: camera and ticks.
        seed: of what is lost, repeated and wrongly stamped.

    Returns:
        The frames; a picture that comes again, bit for bit, counts as none.
    """
    camera, period = experiment.scenario.camera, experiment.setup.period
    delivery = make_delivery(camera, seed)
    rows = list[tuple[int, float, float]]()
    following, last = 0, -1
    for tick in range(experiment.ticks):
        newest = floor((tick * period - camera.latency_s + _SLACK) * camera.fps)
        arrived = [n for n in range(following, newest + 1) if delivery.arrives(n)]
        following = max(following, newest + 1)
        picture = delivery.shown(arrived[-1]) if arrived else last
        if picture != last:
            n, last = arrived[-1], picture
            stamp = delivery.stamp(n, n / camera.fps, 1.0 / camera.fps)
            rows.append((tick, picture / camera.fps, stamp))
    ticks, taken, stamps = np.array(rows).reshape(-1, 3).T.copy()
    return HandedFrames(ticks.astype(int), taken, stamps)


def make_timetable(experiment: Experiment, frames: HandedFrames, glimpses: Glimpses) -> Timetable:
    """Let the rules run over all ticks.

    Args:
        experiment: rules and mission.
        frames: that the loop looks at.
        glimpses: what the frame of a number shows, for a mission that watches first; else None.

    Returns:
        The timetable; it ends with the mission, or with the experiment's ticks.
    """
    setup, period = experiment.setup, experiment.setup.period
    handed = {tick: number for number, tick in enumerate(frames.ticks.tolist())}
    guard, mission, seen = GuardMemory(), Mission(), dict[RobotId, float]()
    phases, rows, events = list[str](), list[tuple[int, float]](), list[SafetyEvent]()
    for number in range(experiment.ticks):
        tick, scene = Tick(number * period), None
        if number in handed:
            tick, scene = replace(tick, frame=_PICTURE), glimpses(handed[number])
            seen = dict.fromkeys(setup.formation.robots, float(frames.stamps[handed[number]]))
        guard, shares, told = watch_over(setup.rules, guard, setup.formation, seen, tick)
        mission = watch(setup, mission, scene)
        mission, shares, _ = supervise(setup, mission, _tracks(seen), shares, tick, period)
        phases.append(mission.phase)
        rows.append((_mission_tick(mission, tick.t, period), shares[setup.formation.root]))
        events += told
        if mission.phase in ENDS:
            break
    return _timetable(frames, phases, rows, mission, events)


def _timetable(
    frames: HandedFrames,
    phases: Sequence[str],
    rows: Sequence[tuple[int, float]],
    end: Mission,
    events: Sequence[SafetyEvent],
) -> Timetable:
    looked_at = frames.ticks < len(rows)
    kept = HandedFrames(frames.ticks[looked_at], frames.taken[looked_at], frames.stamps[looked_at])
    driven = [tick for tick, phase in enumerate(phases) if phase in DRIVING]
    driving = (driven[0], driven[-1] + 1) if driven else (len(rows), len(rows))
    mission, shares = (np.array(column) for column in zip(*rows, strict=True))
    return Timetable(kept, tuple(phases), mission, shares, driving, end, tuple(events))


def _tracks(seen: Mapping[RobotId, float]) -> Mapping[RobotId, Track]:
    """Tracks that tell the mission when robots were seen, and no more."""
    return {robot: _track(t) for robot, t in seen.items()}


@lru_cache(maxsize=4)
def _track(t: float) -> Track:
    estimate = Estimate(t, np.zeros(7), np.zeros((7, 7)))
    return Track(estimate, estimate.state, t)


def _mission_tick(mission: Mission, t: float, period: float) -> int:
    return -1 if mission.t_start is None else round((t - mission.t_start) / period)
