"""Truth beside estimate: an observer that scores a run."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from control.formation import Formation, by_follower
from datasets.cycle import Cycle, Moment, RobotState, SafetyEvent
from datasets.rows import Rows
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
from datasets.sightings import STRANGER, Sighted, Sightings, VisionScore, sighted, vision_score
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
    ) -> None:
        """Begin a run.

        Args:
            formation: who follows whom, in which shape.
            camera_offset: of the followers' camera points, d [m].
            camera: who looks.
            side: of the square bodies and tags [m].
        """
        self._formation, self._offset = formation, camera_offset
        self._camera, self._side = camera, side
        count = len(formation.robots)
        self._places = {robot: n for n, robot in enumerate(formation.robots)}
        self._clock = Rows(3)  # t, t_effective, t_start
        self._planned = Rows(2, 2)  # the leader's places now, when effective
        self._true, self._believed = Rows(count, 5), Rows(count, 5)
        self._known = True  # whether the truth was known in every cycle
        self._frames, self._captures = 0, Rows()
        self._seen = Rows(5)  # frame, place, x, y, theta
        self._latencies = Rows(3)
        self._ages = Rows()  # of the frames on their arrival [s]
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
        self._believed.append(self._states(cycle.robots))
        self._known = self._known and {r.robot_id for r in moment.truth} >= self._places.keys()
        if self._known:
            self._true.append(self._states(moment.truth))
        self._commands += len(cycle.commands)
        self._events += cycle.events
        self._notes += cycle.notes
        if cycle.scene is not None:
            self._look(cycle.scene)
            self._latencies.append((timing.vision, timing.step, timing.frame_to_command))
            frame = moment.tick.frame
            if frame is not None and frame.t_arrival is not None:
                self._ages.append((frame.t_arrival - frame.t_capture,))

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
        times, ages = motions.times, self._ages.table()
        return RunResult(
            scenario=scenario,
            frames=self._frames,
            duration_s=float(times[-1] - times[0]) if len(times) else 0.0,
            wall_s=wall,
            truth=known,
            followers=self._followers(motions),
            leader=self._leader(motions, known) if started else None,
            min_clearance_m=least_clearance(motions, self._side),
            seen=sighted(self._sightings(), self._formation.robots),
            vision=self._vision(motions) if known else None,
            latency_ms=_latencies(self._latencies.table()),
            commands_sent=self._commands,
            safety_events=tuple(self._events),
            notes=tuple(self._notes),
            arrival=Arrival(*_quantiles(ages)) if len(ages) else None,
        )

    def _look(self, scene: Scene) -> None:
        self._captures.append((scene.t_capture,))
        for detection in scene.detections:
            place, pose = self._places.get(detection.robot_id, STRANGER), detection.pose
            self._seen.append((self._frames, place, pose.x, pose.y, pose.theta))
        self._frames += 1

    def _sightings(self) -> Sightings:
        seen = self._seen.table()
        frames, places = seen[:, :2].astype(np.intp).T
        return Sightings(self._captures.table(), frames, places, seen[:, 2:])

    def _states(self, robots: Sequence[RobotState]) -> Iterator[float]:
        """x, y, theta, v, omega of every robot of the formation, NaN where unknown."""
        states = {robot.robot_id: robot.state for robot in robots}
        for robot_id in self._places:
            s = states.get(robot_id)
            yield from (s.x, s.y, s.theta, s.v, s.omega) if s else _UNKNOWN

    def _motions(self) -> tuple[Motions, bool]:
        """True motions at the ticks; without truth the believed ones at their effective times."""
        robots = self._formation.robots
        now, effective, start = self._clock.table().T
        true = self._true.table()
        if self._known and len(true) and np.isfinite(true).all():
            return Motions(robots, now, now - start, true), True
        return Motions(robots, effective, effective - start, self._believed.table()), False

    def _leader(self, motions: Motions, known: bool) -> LeaderScore | None:
        planned = self._planned.table()[:, 0 if known else 1]
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
        if not self._frames:
            return None
        fresh = np.diff(motions.times, prepend=-np.inf) > 0.0  # two ticks may share a moment
        states = motions.states[fresh]
        states[..., 2] = np.unwrap(states[..., 2], axis=0)
        track = TruthTrack(motions.times[fresh], states)
        return vision_score(self._sightings(), track, self._camera, self._side)


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
