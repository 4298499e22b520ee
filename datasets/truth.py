"""Truth beside estimate: an observer that scores a run."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from control.command import RobotId
from control.formation import Formation, by_follower
from datasets.bodies import least_gap
from datasets.cycle import Cycle, Moment, RobotState, SafetyEvent
from datasets.scores import (
    FollowerScore,
    LeaderScore,
    Motions,
    follower_errors,
    follower_score,
    leader_score,
    planned_before,
)
from datasets.sightings import Sighted, Sightings, VisionScore
from datasets.thinned import Thinned
from vision.camera import CameraModel

Floats = NDArray[np.float64]

_CLOCK, _PLANNED, _STATE = 3, 4, 5  # numbers kept of each
_UNKNOWN = (np.nan,) * _STATE


@dataclass(frozen=True, slots=True)
class Latencies:
    """Computing times, median and 99th percentile.

    Attributes:
        vision_p50: finding the robots in a frame [ms].
        vision_p99: the same [ms].
        step_p50: a whole cycle with a frame [ms].
        step_p99: the same [ms].
        frame_to_command_p50: from a frame's hand-over until its commands are with the radio [ms].
        frame_to_command_p99: the same [ms].
    """

    vision_p50: float
    vision_p99: float
    step_p50: float
    step_p99: float
    frame_to_command_p50: float
    frame_to_command_p99: float


@dataclass(frozen=True, slots=True)
class Arrival:
    """How old frames were when they were at hand, median and 99th percentile.

    Attributes:
        p50: from capture to arrival [ms].
        p99: the same [ms].
    """

    p50: float
    p99: float


@dataclass(frozen=True, slots=True)
class RunResult:
    """What is said of a run.

    Attributes:
        scenario: its name.
        frames: number of frames seen.
        duration_s: from the first to the last cycle, on the capture clock [s].
        wall_s: how long it took [s].
        truth: whether errors are of the true states, or of the estimates.
        followers: leaders before their followers.
        leader: None without a mission.
        min_clearance_m: least distance between two bodies, None if unknown [m].
        seen: in how many frames each robot was recognised.
        vision: None without truth or frames.
        latency_ms: None without frames.
        commands_sent: number of commands.
        safety_events: in order of time.
        notes: what else was told, e.g. the initial rates and their spread.
        arrival: None where no source knew; for people, not in the JSON object.
    """

    scenario: str
    frames: int
    duration_s: float
    wall_s: float
    truth: bool
    followers: tuple[FollowerScore, ...]
    leader: LeaderScore | None
    min_clearance_m: float | None
    seen: tuple[Sighted, ...]
    vision: VisionScore | None
    latency_ms: Latencies | None
    commands_sent: int
    safety_events: tuple[SafetyEvent, ...]
    notes: tuple[str, ...]
    arrival: Arrival | None = None

    def to_json(self) -> dict[str, Any]:
        """The result as the command line prints it.

        Returns:
            A JSON-able object; followers by id, keys that do not apply are None, but for
            `second_leader`, which only a follower of two has.
        """
        table = asdict(self)
        del table["arrival"]
        table["followers"] = {str(f.follower): _plain(f) for f in self.followers}
        table["seen"] = {str(s.robot_id): s.frames for s in self.seen}
        table["safety_events"] = list(table["safety_events"])
        table["notes"] = list(table["notes"])
        return table


class Scores:
    """An observer that keeps what the scores need, and computes them at the end.

    Of very long runs it keeps every second cycle, every fourth, and so on; counts, the least
    clearance and the judgement of the vision mind all of them.
    """

    def __init__(
        self,
        formation: Formation,
        camera_offset: float,
        camera: CameraModel,
        side: float,
        others: Sequence[RobotId] = (),
    ) -> None:
        """Begin a run.

        Args:
            formation: who follows whom, in which shape.
            camera_offset: of the followers' camera points, d [m].
            camera: who looks.
            side: of the square bodies and tags [m].
            others: robots that wear a tag and are not of the formation.
        """
        self._robots = (*formation.robots, *others)
        self._formation, self._offset, self._side = formation, camera_offset, side
        # t, t_effective, t_start, the leader's planned places now and when effective, then states
        self._rows = Thinned(_CLOCK + _PLANNED + 2 * _STATE * len(self._robots))
        self._latencies, self._ages = Thinned(3), Thinned(1)  # ages of frames on arrival [s]
        self._sightings = Sightings(self._robots, camera, side)
        self._known, self._clearance = True, np.inf
        self._events: list[SafetyEvent] = []
        self._notes: list[str] = []
        self._commands = 0

    def observe(self, moment: Moment) -> None:
        """Take note of one cycle.

        Args:
            moment: its inputs, outcome, truth and cost.
        """
        cycle, timing, t = moment.cycle, moment.timing, moment.tick.t
        true, believed = self._states(moment.truth), self._states(cycle.robots)
        known = _UNKNOWN not in true
        self._known &= known
        start = np.nan if cycle.t_start is None else cycle.t_start
        states = chain.from_iterable((*true, *believed))
        self._rows.add((t, cycle.t_effective, start, *_planned(cycle), *states))
        self._clearance = least_gap(true if known else believed, self._side, self._clearance)
        self._sightings.take(t, true if known else None, cycle.scene)
        self._commands += len(cycle.commands)
        self._events += cycle.events
        self._notes += cycle.notes
        if cycle.scene is not None:
            self._latencies.add((timing.vision, timing.step, timing.frame_to_command))
            frame = moment.tick.frame
            if frame is not None and frame.t_arrival is not None:
                self._ages.add((frame.t_arrival - frame.t_capture,))

    def close(self) -> None:
        """Release nothing. Safe to call twice."""

    def result(self, scenario: str, wall: float) -> RunResult:
        """Score the run so far.

        Args:
            scenario: its name.
            wall: how long it took [s].

        Returns:
            The result; of true states where they are known in every cycle.
        """
        motions, planned = self._motions()
        started = bool(np.isfinite(motions.mission).any())
        times, ages = motions.times, self._ages.table()[:, 0]
        return RunResult(
            scenario=scenario,
            frames=self._sightings.frames,
            duration_s=float(times[-1] - times[0]) if len(times) else 0.0,
            wall_s=wall,
            truth=self._known and len(times) > 0,
            followers=self._followers(motions),
            leader=self._leader(motions, planned) if started else None,
            min_clearance_m=self._clearance if np.isfinite(self._clearance) else None,
            seen=self._sightings.sighted(),
            vision=self._sightings.score() if self._known else None,
            latency_ms=_latencies(self._latencies.table()),
            commands_sent=self._commands,
            safety_events=tuple(self._events),
            notes=tuple(self._notes),
            arrival=Arrival(*_quantiles(ages)) if len(ages) else None,
        )

    def _states(self, robots: Sequence[RobotState]) -> tuple[tuple[float, ...], ...]:
        """x, y, theta, v, omega of every robot, NaN where unknown."""
        states = {robot.robot_id: robot.state for robot in robots}
        return tuple(
            (s.x, s.y, s.theta, s.v, s.omega) if (s := states.get(robot_id)) else _UNKNOWN
            for robot_id in self._robots
        )

    def _motions(self) -> tuple[Motions, Floats]:
        """True motions at the ticks, without truth the believed ones when effective; the plan."""
        robots, rows = self._robots, self._rows.table()
        now, effective, start = rows[:, :_CLOCK].T
        planned = rows[:, _CLOCK : _CLOCK + _PLANNED].reshape(-1, 2, 2)
        both = rows[:, _CLOCK + _PLANNED :].reshape(-1, 2, len(robots), _STATE)
        if self._known:
            return Motions(robots, now, now - start, both[:, 0]), planned[:, 0]
        return Motions(robots, effective, effective - start, both[:, 1]), planned[:, 1]

    def _leader(self, motions: Motions, planned: Floats) -> LeaderScore | None:
        if not np.isfinite(planned).any():
            return None
        return leader_score(motions, self._formation.root, planned)

    def _followers(self, motions: Motions) -> tuple[FollowerScore, ...]:
        if not len(motions.times):
            return ()
        return tuple(
            follower_score(
                motions,
                pairs,
                np.stack([follower_errors(motions, pair, self._offset) for pair in pairs]),
            )
            for pairs in by_follower(self._formation.pairs).values()
        )


def _planned(cycle: Cycle) -> tuple[float, float, float, float]:
    """The leader's places at the tick and when its command takes effect; NaN without a plan."""
    if cycle.planned is None:
        return np.nan, np.nan, np.nan, np.nan
    then = cycle.planned.state
    now = planned_before(then, cycle.t_effective - cycle.t)
    return now.x, now.y, then.x, then.y


def _plain(score: FollowerScore) -> dict[str, Any]:
    """A follower's score without what its key says, and without a second leader it has not."""
    left_out = {"follower", *(("second_leader",) if score.second_leader is None else ())}
    return {key: value for key, value in asdict(score).items() if key not in left_out}


def _latencies(rows: Floats) -> Latencies | None:
    """Median and 99th percentile of times given in seconds."""
    if not len(rows):
        return None
    return Latencies(*(value for column in rows.T for value in _quantiles(column)))


def _quantiles(times: Floats) -> tuple[float, float]:
    """Median and 99th percentile [ms] of times in seconds."""
    middle, high = 1e3 * np.percentile(times, (50, 99))
    return float(middle), float(high)
