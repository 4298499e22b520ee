"""Truth beside estimate: an observer that scores a run."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from control.command import RobotId
from control.formation import Formation, by_follower
from control.relative import Vector2
from datasets.cycle import Cycle, Moment, RobotState, SafetyEvent
from datasets.scores import (
    FollowerScore,
    LeaderScore,
    Motions,
    follower_errors,
    follower_score,
    leader_score,
    least_clearance,
    planned_before,
)
from datasets.sightings import Sighted, VisionScore, sighted, vision_score
from datasets.track import TruthTrack
from vision.camera import CameraModel
from vision.scene import Scene

Floats = NDArray[np.float64]

_UNKNOWN = (np.nan,) * 5


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
    """An observer that keeps what the scores need, and computes them at the end."""

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
        self._formation, self._offset = formation, camera_offset
        self._camera, self._side = camera, side
        self._clock: list[tuple[float, float, float]] = []  # t, t_effective, t_start
        self._planned: list[tuple[Vector2, Vector2]] = []  # the leader's places now, when effective
        self._true: list[tuple[tuple[float, ...], ...]] = []
        self._believed: list[tuple[tuple[float, ...], ...]] = []
        self._scenes: list[Scene] = []
        self._latencies: list[tuple[float, float, float]] = []
        self._ages: list[float] = []  # of the frames on their arrival [s]
        self._events: list[SafetyEvent] = []
        self._notes: list[str] = []
        self._commands = 0

    def observe(self, moment: Moment) -> None:
        """Take note of one cycle.

        Args:
            moment: its inputs, outcome, truth and cost.
        """
        cycle, timing = moment.cycle, moment.timing
        start = np.nan if cycle.t_start is None else cycle.t_start
        self._clock.append((moment.tick.t, cycle.t_effective, start))
        self._planned.append(_planned(cycle))
        self._true.append(self._states(moment.truth))
        self._believed.append(self._states(cycle.robots))
        self._commands += len(cycle.commands)
        self._events += cycle.events
        self._notes += cycle.notes
        if cycle.scene is not None:
            self._scenes.append(cycle.scene)
            self._latencies.append((timing.vision, timing.step, timing.frame_to_command))
            frame = moment.tick.frame
            if frame is not None and frame.t_arrival is not None:
                self._ages.append(frame.t_arrival - frame.t_capture)

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
        motions, known = self._motions()
        started = bool(np.isfinite(motions.mission).any())
        times = motions.times
        return RunResult(
            scenario=scenario,
            frames=len(self._scenes),
            duration_s=float(times[-1] - times[0]) if len(times) else 0.0,
            wall_s=wall,
            truth=known,
            followers=self._followers(motions),
            leader=self._leader(motions, known) if started else None,
            min_clearance_m=least_clearance(motions, self._side),
            seen=sighted(tuple(self._scenes), self._robots),
            vision=self._vision(motions) if known else None,
            latency_ms=_latencies(self._latencies),
            commands_sent=self._commands,
            safety_events=tuple(self._events),
            notes=tuple(self._notes),
            arrival=Arrival(*_quantiles(self._ages)) if self._ages else None,
        )

    def _states(self, robots: Sequence[RobotState]) -> tuple[tuple[float, ...], ...]:
        """x, y, theta, v, omega of every robot, NaN where unknown."""
        states = {robot.robot_id: robot.state for robot in robots}
        return tuple(
            (s.x, s.y, s.theta, s.v, s.omega) if (s := states.get(robot_id)) else _UNKNOWN
            for robot_id in self._robots
        )

    def _motions(self) -> tuple[Motions, bool]:
        """True motions at the ticks; without truth the believed ones at their effective times."""
        robots = self._robots
        now, effective, start = np.array(self._clock).reshape(-1, 3).T
        true = np.array(self._true).reshape(-1, len(robots), 5)
        if len(true) and np.isfinite(true).all():
            return Motions(robots, now, now - start, true), True
        believed = np.array(self._believed).reshape(true.shape)
        return Motions(robots, effective, effective - start, believed), False

    def _leader(self, motions: Motions, known: bool) -> LeaderScore | None:
        planned = np.array(self._planned)[:, 0 if known else 1]
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

    def _vision(self, motions: Motions) -> VisionScore | None:
        if not self._scenes:
            return None
        fresh = np.diff(motions.times, prepend=-np.inf) > 0.0  # two ticks may share a moment
        states = motions.states[fresh]
        states[..., 2] = np.unwrap(states[..., 2], axis=0)
        track = TruthTrack(motions.times[fresh], states)
        return vision_score(tuple(self._scenes), motions.ids, track, self._camera, self._side)


def _planned(cycle: Cycle) -> tuple[Vector2, Vector2]:
    """The leader's places at the tick and when its command takes effect; NaN without a plan."""
    if cycle.planned is None:
        return (np.nan, np.nan), (np.nan, np.nan)
    then = cycle.planned.state
    now = planned_before(then, cycle.t_effective - cycle.t)
    return (now.x, now.y), (then.x, then.y)


def _plain(score: FollowerScore) -> dict[str, Any]:
    """A follower's score without what its key says, and without a second leader it has not."""
    left_out = {"follower", *(("second_leader",) if score.second_leader is None else ())}
    return {key: value for key, value in asdict(score).items() if key not in left_out}


def _latencies(rows: list[tuple[float, float, float]]) -> Latencies | None:
    """Median and 99th percentile of times given in seconds."""
    if not rows:
        return None
    return Latencies(*(value for column in zip(*rows, strict=True) for value in _quantiles(column)))


def _quantiles(times: Sequence[float]) -> tuple[float, float]:
    """Median and 99th percentile [ms] of times in seconds."""
    middle, high = 1e3 * np.percentile(times, (50, 99))
    return float(middle), float(high)
