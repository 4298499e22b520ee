"""A world without pixels for closed-loop tests: lagged robots, a noisy late camera, a late radio.

It drives the modules of control/ the way the pipeline does: frames correct the filters at capture
time, every tick rolls them on to the moment its commands take effect.
"""

from dataclasses import dataclass, field
from math import pi

import numpy as np

from control.actuation import Actuation, DriveGain
from control.command import RobotId
from control.estimation import (
    Estimate,
    MotionModel,
    SentCommands,
    correct,
    initial_estimate,
    predict,
    roll,
)
from control.follower import FollowerMemory, FollowerModel, FollowerSample, SlidingGains
from control.formation import Formation, Pair, Shape
from control.geometry import Pose2D, wrap_angle
from control.laws import law_named
from control.leader import LeaderGains, LeaderMemory, begin_leader, leader_step
from control.motion_model import UNCOMMANDED
from control.output import LeaderMotion, pair_output, wanted_output
from control.plan import PathSegment, Plan, PlannedPath
from control.profile import TanhStep
from control.relative import relative_state
from control.sliding import begin, follower_step
from control.twisting import TwistingGains
from control.unicycle import Twist, UnicycleState, advance_lagged

CAMERA_OFFSET = 0.05


@dataclass(frozen=True)
class Case:
    """One closed-loop run; times in seconds, noise in metres and radians."""

    formation: Formation
    path: Plan
    start: dict[RobotId, Pose2D]
    seconds: float = 8.0
    fps: float = 30.0
    tick: float = 0.005
    latency: float = 0.04
    radio: float = 0.005
    lag: float = 0.05
    assumed_lag: float = 0.05
    gain_errors: tuple[float, float] = (0.1, -0.1)
    leader_gain_errors: tuple[float, float] = (0.0, 0.0)
    noise: tuple[float, float] = (0.0005, 0.008)
    drop: float = 0.0
    gains: SlidingGains = field(default_factory=SlidingGains)
    leader_gains: LeaderGains = field(default_factory=LeaderGains)
    leader_model: MotionModel = field(default_factory=MotionModel)
    follower_model: MotionModel = field(default_factory=MotionModel)
    feed_forward: bool = False
    foreign_leader: bool = False  # drives its path exactly, its commands unknown to the host
    seed: int = 0


@dataclass(frozen=True)
class Trace:
    """What happened, sampled every 10 ms: times (n,), then one column per pair or robot."""

    t: np.ndarray
    distance_errors: np.ndarray
    bearing_errors: np.ndarray
    speeds: np.ndarray
    leader_errors: np.ndarray

    def rms(self, errors: np.ndarray, t0: float, t1: float = 1e9) -> np.ndarray:
        """Root mean square of each column between two times."""
        rows = (self.t >= t0) & (self.t <= t1)
        squares: np.ndarray = np.mean(errors[rows] ** 2, axis=0)
        return squares**0.5


def paper_case(**changes: object) -> Case:
    """The experiment of the paper, design/control.md section 6."""
    quarter = 3.0 * pi / 4.0
    left = Shape(TanhStep(0.2, 0.15, 5.5, 10.0), TanhStep.constant(quarter))
    right = Shape(TanhStep(0.2, 0.3, 5.5, 10.0), TanhStep.constant(-quarter))
    arc = PathSegment(pi * 0.4, 1.0 / 0.4)
    path = PlannedPath(
        Pose2D(0.0, 0.0, 0.0), (PathSegment(1.05), arc, PathSegment(9.0)), 0.5, 0.0, 1.0
    )
    start = {1: Pose2D(0, 0, 0), 2: Pose2D(-0.4, 0, 0), 3: Pose2D(-0.3, 0, 0)}
    pairs = (Pair(1, 2, left), Pair(1, 3, right))
    return Case(Formation(pairs), path, start, **changes)  # type: ignore[arg-type]


def gains(horizon: float = 0.05, law: str = "implicit-twisting") -> SlidingGains:
    """The paper's gains with a horizon."""
    return SlidingGains(law=law_named(law), twisting=TwistingGains(20.0, 4.0, horizon))


class SmallWorld:
    """World and host of one case; ``run`` gives the trace of the truth."""

    def __init__(self, case: Case) -> None:
        self.case = case
        self.rng = np.random.default_rng(case.seed)
        self.truth = {r: UnicycleState(p.x, p.y, p.theta, 0, 0) for r, p in case.start.items()}
        self.sent = {robot: SentCommands() for robot in case.start}
        self.estimates: dict[RobotId, Estimate] = {}
        self.ahead: dict[RobotId, UnicycleState] = {}
        self.t_ahead = 0.0
        self.frames: list[tuple[float, dict[RobotId, Pose2D]]] = []
        self.followers: dict[RobotId, FollowerMemory] = {}
        self.leader: LeaderMemory | None = None
        self.actuation = Actuation(lag=case.assumed_lag)
        self.follower = FollowerModel(CAMERA_OFFSET, self.actuation)

    def run(self) -> Trace:
        """Run the case to its end."""
        rows, per_tick, capture = [], round(self.case.tick * 1000), 0
        for i in range(round(self.case.seconds * 1000)):
            t = i / 1000
            if t >= capture / self.case.fps - 1e-9:
                self.capture(t)
                capture += 1
            while self.frames and self.frames[0][0] + self.case.latency <= t + 1e-9:
                self.see(*self.frames.pop(0))
            if i % per_tick == 0 and self.estimates:
                self.tick(t)
            if i % 10 == 0:
                rows.append(self.row(t))
            self.advance(t, 0.001)
        return Trace(*(np.array(column) for column in zip(*rows, strict=True)))

    def capture(self, t: float) -> None:
        """A frame: noisy poses, kept until the latency has passed."""
        xy, angle = self.case.noise
        noise = {r: self.rng.normal(size=3) * (xy, xy, angle) for r in self.truth}
        if self.rng.random() >= self.case.drop:
            poses = {
                r: Pose2D(s.x + noise[r][0], s.y + noise[r][1], s.theta + noise[r][2])
                for r, s in self.truth.items()
            }
            self.frames.append((t, poses))

    def model(self, robot: RobotId) -> MotionModel:
        """Motion model of a robot."""
        is_leader = robot == self.case.formation.root
        if is_leader and self.case.foreign_leader:
            return MotionModel(lag=UNCOMMANDED)
        return self.case.leader_model if is_leader else self.case.follower_model

    def gain(self, robot: RobotId) -> DriveGain:
        """Estimated drive gains."""
        return self.estimates[robot].gain

    def see(self, captured: float, poses: dict[RobotId, Pose2D]) -> None:
        """Correct every filter at the capture time."""
        xy, angle = self.case.noise
        covariance = np.diag([xy**2, xy**2, angle**2])
        for robot, pose in poses.items():
            model, sent = self.model(robot), self.sent[robot]
            if robot not in self.estimates:
                self.estimates[robot] = initial_estimate(pose, covariance, captured, model)
                continue
            predicted = predict(self.estimates[robot], captured, sent, model)
            self.estimates[robot] = correct(predicted, pose, covariance)
        self.ahead = {robot: e.state for robot, e in self.estimates.items()}
        self.t_ahead = captured

    def tick(self, t: float) -> None:
        """One command cycle."""
        te = t + self.case.radio
        self.ahead = {
            r: roll(s, self.t_ahead, te, self.sent[r], self.model(r), self.gain(r))
            for r, s in self.ahead.items()
        }
        self.t_ahead = te
        self.command_leader(te)
        for pair in self.case.formation.pairs:
            self.command_follower(pair, te)

    def command_leader(self, te: float) -> None:
        """The leader's law."""
        case, root = self.case, self.case.formation.root
        if case.foreign_leader:
            return
        planned, state = case.path.at(te), self.ahead[root]
        memory = self.leader or begin_leader(state, planned, case.leader_gains)
        self.leader, command = leader_step(
            memory, state, planned, case.tick, case.leader_gains, self.actuation, self.gain(root)
        )
        self.sent[root] = self.sent[root].append(te, command)

    def command_follower(self, pair: Pair, te: float) -> None:
        """One follower's law."""
        own, leader = self.ahead[pair.follower], self.ahead[pair.leader]
        relative = relative_state(leader.pose, own.pose, CAMERA_OFFSET)
        known = (0.0, 0.0)
        if self.case.feed_forward:
            law = self.followers.get(pair.leader, self.leader)
            known = law.acceleration if law else known
        motion = LeaderMotion(leader.twist, known)
        output = pair_output(relative, own.twist, motion, CAMERA_OFFSET)
        wanted = wanted_output([pair.shape.at(te)])
        gains = self.case.gains
        memory = self.followers.get(pair.follower) or begin(output, wanted, (0.0, 0.0), gains)
        sample = FollowerSample(output, wanted, own.twist, self.gain(pair.follower))
        self.followers[pair.follower], command = follower_step(
            memory, sample, self.case.tick, gains, self.follower
        )
        self.sent[pair.follower] = self.sent[pair.follower].append(te, command)

    def advance(self, t: float, dt: float) -> None:
        """Move the true robots; followers answer commands with wrong gains."""
        for robot, state in self.truth.items():
            errors = self.case.gain_errors
            if robot == self.case.formation.root:
                errors = self.case.leader_gain_errors
            command = self.sent[robot].in_force(t + 1e-6)
            driven = Twist(command.v * (1 + errors[0]), command.omega * (1 + errors[1]))
            self.truth[robot] = advance_lagged(state, driven, dt, self.case.lag)
        if self.case.foreign_leader:
            self.truth[self.case.formation.root] = self.case.path.at(t + dt).state

    def row(self, t: float) -> tuple[object, ...]:
        """True errors and speeds."""
        distances, bearings = [], []
        for pair in self.case.formation.pairs:
            states = self.truth[pair.leader], self.truth[pair.follower]
            relative = relative_state(states[0].pose, states[1].pose, CAMERA_OFFSET)
            wanted = pair.shape.at(t)
            distances.append(wanted.distance - relative.distance)
            bearings.append(wrap_angle(wanted.bearing - relative.bearing))
        speeds = [self.truth[robot].v for robot in self.case.formation.robots]
        p, q = self.truth[self.case.formation.root], self.case.path.at(t).state
        off = (p.x - q.x, p.y - q.y, wrap_angle(p.theta - q.theta))
        return t, distances, bearings, speeds, off
