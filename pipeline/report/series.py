"""A session as arrays: what the figures draw. Pictures are not kept, but one."""

from array import array
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from control.command import RobotId
from datasets.cycle import Moment, RobotState, SafetyEvent
from datasets.scores import Motions, follower_errors
from pipeline.setup import Setup
from vision.frame import Frame
from vision.scene import Scene

Floats = NDArray[np.float64]

_STATE, _TWIST, _FRAME = 5, 2, 7  # numbers kept of each


@dataclass(frozen=True, slots=True)
class Series:
    """One session in arrays; N ticks, R robots, P pairs, F frames; NaN where unknown.

    Attributes:
        robots: ids, leaders before their followers.
        followers: of each pair, the index of its follower among the robots.
        times: mission clock at the ticks, shape (N,); from the first tick if it never started [s].
        ahead: mission clock when the commands take effect, shape (N,) [s].
        started: whether there was a mission.
        obstacles: believed places of robots that are obstacles at `ahead`, shape (N, W, 2) [m].
        planned: the leader's places at `ahead`, shape (N, 2) [m].
        true: true states at `times`, shape (N, R, 5) [m, m, rad, m/s, rad/s].
        believed: predicted states at `ahead`, shape (N, R, 5) [m, m, rad, m/s, rad/s].
        commands: shape (N, R, 2) [m/s, rad/s].
        true_errors: h^d - h at `times`, shape (P, N, 2) [m, rad].
        believed_errors: h^d - h at `ahead`, shape (P, N, 2) [m, rad].
        frames: shape (F, 7): mission clock of capture [s], robots found, candidates rejected,
            vision [s], whole step [s], frame to command [s], capture to wheels [s].
        phases: mission clock and name of every phase entered.
        events: what the safety rules did; their times are of the capture clock.
        notes: what else the run told.
        picture: a frame with the most robots found, and what was found in it.
    """

    robots: tuple[RobotId, ...]
    followers: tuple[int, ...]
    times: Floats
    ahead: Floats
    started: bool
    obstacles: Floats
    planned: Floats
    true: Floats
    believed: Floats
    commands: Floats
    true_errors: Floats
    believed_errors: Floats
    frames: Floats
    phases: tuple[tuple[float, str], ...]
    events: tuple[SafetyEvent, ...]
    notes: tuple[str, ...]
    picture: tuple[Frame, Scene] | None

    @property
    def has_truth(self) -> bool:
        """Whether any true state is known."""
        return bool(np.isfinite(self.true).any())


def _numbers() -> "array[float]":
    return array("d")


@dataclass
class Collector:
    """Gathers series moment by moment, eight bytes a number.

    Attributes:
        setup: of the run.
    """

    setup: Setup
    _clock: "array[float]" = field(default_factory=_numbers)
    _planned: "array[float]" = field(default_factory=_numbers)
    _obstacles: "array[float]" = field(default_factory=_numbers)
    _true: "array[float]" = field(default_factory=_numbers)
    _believed: "array[float]" = field(default_factory=_numbers)
    _commands: "array[float]" = field(default_factory=_numbers)
    _pairs: "array[float]" = field(default_factory=_numbers)
    _frames: "array[float]" = field(default_factory=_numbers)
    _start: float | None = None
    _phases: list[tuple[float, str]] = field(default_factory=list)
    _events: list[SafetyEvent] = field(default_factory=list)
    _notes: list[str] = field(default_factory=list)
    _picture: tuple[Frame, Scene] | None = None
    _first: float | None = None

    def observe(self, moment: Moment) -> None:
        """Take note of one cycle.

        Args:
            moment: its inputs, outcome, truth and cost.
        """
        cycle, robots = moment.cycle, self.setup.formation.robots
        self._clock.extend((moment.tick.t, cycle.t_effective))
        place = cycle.planned and cycle.planned.state
        self._planned.extend((place.x, place.y) if place else (np.nan, np.nan))
        self._obstacles.extend(_places(cycle.robots, tuple(self.setup.worn)))
        self._true.extend(_states(moment.truth, robots))
        self._believed.extend(_states(cycle.robots, robots))
        sent = {command.robot_id: command.twist for command in cycle.commands}
        for robot_id in robots:
            twist = sent.get(robot_id)
            self._commands.extend((twist.v, twist.omega) if twist else (np.nan, np.nan))
        self._take_pairs(moment)
        self._take_frame(moment)
        self._start = cycle.t_start if self._start is None else self._start
        if not self._phases or self._phases[-1][1] != cycle.phase:
            self._phases.append((cycle.t, cycle.phase))
        self._events += cycle.events
        self._notes += cycle.notes

    def close(self) -> None:
        """Release nothing. Safe to call twice."""

    def series(self) -> Series:
        """All that was gathered.

        Returns:
            The arrays.
        """
        robots, pairs = self.setup.formation.robots, self.setup.formation.pairs
        now, ahead = _table(self._clock, 2).T
        start = self._start if self._start is not None else (now[0] if len(now) else 0.0)
        true = _table(self._true, _STATE * len(robots)).reshape(-1, len(robots), _STATE)
        frames = _table(self._frames, _FRAME)
        frames[:, 0] -= start
        begun = (now >= start) & (self._start is not None)
        mission = np.where(begun, now - start, np.nan)
        motions = Motions(robots, now, mission, true)
        offset = self.setup.follower.camera_offset
        return Series(
            robots=robots,
            followers=tuple(robots.index(pair.follower) for pair in pairs),
            times=now - start,
            ahead=ahead - start,
            started=self._start is not None,
            obstacles=np.array(self._obstacles).reshape(len(now), len(self.setup.worn), 2),
            planned=_table(self._planned, 2),
            true=true,
            believed=_table(self._believed, _STATE * len(robots)).reshape(true.shape),
            commands=_table(self._commands, _TWIST * len(robots)).reshape(-1, len(robots), _TWIST),
            true_errors=np.array([follower_errors(motions, pair, offset) for pair in pairs]),
            believed_errors=_table(self._pairs, 2 * len(pairs))
            .reshape(-1, len(pairs), 2)
            .transpose(1, 0, 2),
            frames=frames,
            phases=tuple((t - start, phase) for t, phase in self._phases),
            events=tuple(self._events),
            notes=tuple(self._notes),
            picture=self._picture,
        )

    def _take_pairs(self, moment: Moment) -> None:
        """Predicted errors, (11), of every pair of the formation."""
        known = {(pair.leader, pair.follower): pair.error for pair in moment.cycle.pairs}
        for one in self.setup.formation.pairs:
            self._pairs.extend(known.get((one.leader, one.follower), (np.nan, np.nan)))

    def _take_frame(self, moment: Moment) -> None:
        scene, timing, frame = moment.cycle.scene, moment.timing, moment.tick.frame
        if scene is None:
            return
        found, rejected = len(scene.detections), len(scene.rejected)
        age = moment.cycle.t_effective - scene.t_capture
        cost = (timing.vision, timing.step, timing.frame_to_command, age)
        self._frames.extend((scene.t_capture, found, rejected, *cost))
        if frame is not None and self._is_better(frame, found):
            self._picture = frame, scene

    def _is_better(self, frame: Frame, found: int) -> bool:
        """More robots; or as many, and twice as late: so the picture comes from the midst."""
        self._first = frame.t_capture if self._first is None else self._first
        if self._picture is None:
            return True
        then, most = self._picture[0].t_capture, len(self._picture[1].detections)
        late = frame.t_capture - self._first >= max(2.0 * (then - self._first), 0.25)
        return found > most or (found == most and late)


def _states(robots: tuple[RobotState, ...], ids: tuple[RobotId, ...]) -> "array[float]":
    """States of some robots, NaN where unknown."""
    states = {robot.robot_id: robot.state for robot in robots}
    row = _numbers()
    for robot_id in ids:
        s = states.get(robot_id)
        row.extend((s.x, s.y, s.theta, s.v, s.omega) if s else (np.nan,) * _STATE)
    return row


def _places(robots: tuple[RobotState, ...], ids: tuple[RobotId, ...]) -> "array[float]":
    """x and y of some robots, NaN where unknown."""
    places = {robot.robot_id: (robot.state.x, robot.state.y) for robot in robots}
    return array("d", (one for robot in ids for one in places.get(robot, (np.nan, np.nan))))


def _table(numbers: "array[float]", columns: int) -> Floats:
    """Rows of numbers, shape (N, columns)."""
    return np.array(numbers, dtype=np.float64).reshape(-1, columns)
