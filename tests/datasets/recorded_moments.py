"""A run with known truth for the tests of recorder, report and viewer: the paper's, kinematically.

The followers obey the nominal error equation of the law, (1 + t) exp(-t) times the initial error.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import cos, exp, pi, sin

import cv2
import numpy as np

from control.command import Command
from control.formation import Formation, Pair, Shape
from control.geometry import Pose2D, wrap_angle
from control.plan import PathSegment, PlannedPath
from control.profile import TanhStep
from control.relative import relative_state
from control.unicycle import Twist, UnicycleState
from datasets.cycle import Cycle, Moment, PairState, RobotState, SafetyEvent, Tick, Timing
from vision.camera import CameraModel, overhead_camera
from vision.frame import Frame, as_frame
from vision.scene import Detection, Rejection, Scene

OFFSET = 0.05  # d [m]
PERIOD = 0.005  # of commands [s]
DELAY = 0.005  # of the radio [s]
LATENCY = 0.040  # of the camera [s]
FRAME = 1.0 / 30.0  # [s]
START = {1: Pose2D(0.0, 0.0, 0.0), 2: Pose2D(-0.4, 0.0, 0.0), 3: Pose2D(-0.3, 0.0, 0.0)}
COLORS = {1: (60, 60, 230), 2: (230, 120, 40), 3: (70, 200, 60)}
FORMATION = Formation(
    (
        Pair(1, 2, Shape(TanhStep(0.2, 0.15, 5.5), TanhStep.constant(3 * pi / 4))),
        Pair(1, 3, Shape(TanhStep(0.2, 0.3, 5.5), TanhStep.constant(-3 * pi / 4))),
    )
)
PATH = PlannedPath(
    START[1], (PathSegment(1.05), PathSegment(0.4 * pi, 2.5), PathSegment(2.0)), 0.5, 0.0, 1.0
)


def camera() -> CameraModel:
    """320x240 over 2.4 m, as in the scenario `paper`."""
    return overhead_camera((320, 240), 2.4, (0.5, 0.4), 2.5, 0.075)


@dataclass
class Motion:
    """True states of the three robots, stepped by command periods."""

    t: float = 0.0

    def __post_init__(self) -> None:
        self.theta = {2: 0.0, 3: 0.0}
        self.states = {k: UnicycleState(p.x, p.y, p.theta, 0.0, 0.0) for k, p in START.items()}
        self.first = {k: relative_state(START[1], START[k], OFFSET) for k in (2, 3)}

    def camera_point(self, pair: Pair, t: float) -> np.ndarray:
        """Where the nominal error puts a follower's camera point at t."""
        fade = (1 + t) * exp(-t)
        start, wanted, first = pair.shape.at(0.0), pair.shape.at(t), self.first[pair.follower]
        distance = wanted.distance + fade * (first.distance - start.distance)
        bearing = wanted.bearing + fade * wrap_angle(first.bearing - start.bearing)
        leader = PATH.at(t).state
        angle = leader.theta + bearing
        return np.array([leader.x + distance * cos(angle), leader.y + distance * sin(angle)])

    def step(self) -> None:
        """Advance by one period."""
        self.t += PERIOD
        self.states[1] = PATH.at(self.t).state
        for pair in FORMATION.pairs:
            k, th = pair.follower, self.theta[pair.follower]
            point = self.camera_point(pair, self.t)
            rate = (point - self.camera_point(pair, self.t - PERIOD)) / PERIOD
            v = rate[0] * cos(th) + rate[1] * sin(th)
            omega = (-rate[0] * sin(th) + rate[1] * cos(th)) / OFFSET
            self.theta[k] = th = th + omega * PERIOD
            self.states[k] = UnicycleState(
                point[0] - OFFSET * cos(th), point[1] - OFFSET * sin(th), th, v, omega
            )


def picture(states: dict[int, UnicycleState], noise: np.random.Generator) -> np.ndarray:
    """A plain drawing of the field with camera noise."""
    eye = camera()
    image = np.full((240, 320, 3), (88, 96, 92), np.uint8)
    for k, q in states.items():
        for color, low, high in (
            ((20, 20, 20), -0.0375, 0.0375),
            (COLORS[k], -0.032, -0.003),
            ((40, 220, 230), 0.003, 0.032),
        ):
            side = 0.0375 if low < -0.035 else 0.032
            corners = np.array([[low, -side], [high, -side], [high, side], [low, side]])
            turn = np.array([[cos(q.theta), sin(q.theta)], [-sin(q.theta), cos(q.theta)]])
            floor = np.column_stack((corners @ turn + (q.x, q.y), np.full(4, 0.075)))
            cv2.fillPoly(
                image, [np.rint(eye.project(floor) * 16).astype(np.int32)], color, cv2.LINE_AA, 4
            )
    return np.clip(image + noise.normal(0, 3, image.shape), 0, 255).astype(np.uint8)


def _scene(frame: Frame, states: dict[int, UnicycleState], noise: np.random.Generator) -> Scene:
    eye, found = camera(), []
    for k, q in states.items():
        dx, dy, dth = noise.normal(0, (0.0005, 0.0005, 0.008))
        pose = Pose2D(q.x + dx, q.y + dy, wrap_angle(q.theta + dth))
        cov = np.diag([0.0005**2, 0.0005**2, 0.008**2])
        cov.flags.writeable = False
        found.append(
            Detection(k, pose, eye.pixel_pose(pose), cov, 0.1 + 0.05 * noise.random(), 0.95)
        )
    rejected = (Rejection(270.0, 200.0, "area 12 px^2, expected 60 to 140"),)
    return Scene(frame.t_capture, tuple(found), rejected if frame.sequence % 2 else ())


def moments(duration: float = 8.0, truth: bool = True, size: float = 1.0) -> Iterator[Moment]:
    """The run as observers see it; size scales the pictures."""
    noise, motion, captured, shown = np.random.default_rng(7), Motion(), [], 0
    for i in range(round(duration / PERIOD)):
        t, frame = i * PERIOD, None
        if t >= len(captured) * FRAME - 1e-9:
            image = picture(motion.states, noise)
            if size != 1.0:
                image = cv2.resize(image, None, fx=size, fy=size, interpolation=cv2.INTER_NEAREST)
            captured.append((as_frame(image, t, len(captured), "synthetic"), dict(motion.states)))
        scene = None
        if shown < len(captured) and captured[shown][0].t_capture + LATENCY <= t + 1e-9:
            frame, then = captured[shown]
            captured[shown] = (None, None)
            shown += 1
            scene = _scene(frame, then, noise)
        yield _moment(Tick(t, frame), scene, motion, truth, noise)
        motion.step()


def _moment(
    tick: Tick, scene: Scene | None, motion: Motion, truth: bool, noise: np.random.Generator
) -> Moment:
    te = tick.t + DELAY
    wobble = {k: noise.normal(0, (0.0007, 0.0007, 0.006, 0.01, 0.1)) for k in motion.states}
    robots = tuple(
        RobotState(
            k, UnicycleState(*(np.array([q.x, q.y, q.theta, q.v, q.omega]) + wobble[k]).tolist())
        )
        for k, q in motion.states.items()
    )
    poses = {r.robot_id: r.state.pose for r in robots}
    pairs = tuple(
        PairState(
            p.leader,
            p.follower,
            relative_state(poses[p.leader], poses[p.follower], OFFSET),
            p.shape.at(te),
        )
        for p in FORMATION.pairs
    )
    commands = tuple(
        Command(k, Twist(q.v, q.omega), te, te + 0.1) for k, q in motion.states.items()
    )
    events = (
        (SafetyEvent(tick.t, "robot-lost", 3, "not seen for 0.10 s"),)
        if abs(tick.t - 4.0) < 1e-6
        else ()
    )
    cycle = Cycle(tick.t, te, "running", 0.0, scene, robots, pairs, PATH.at(te), commands, events)
    known = tuple(RobotState(k, q) for k, q in motion.states.items()) if truth else ()
    vision = abs(noise.normal(1.8e-3, 2e-4)) if tick.frame else 0.0
    step = vision + abs(noise.normal(4e-4, 5e-5))
    return Moment(tick, cycle, known, Timing(vision, step, step + 1e-5))
