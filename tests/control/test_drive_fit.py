"""The fit of a drive: robots of another simulator, laws of time and place, and refusals."""

from dataclasses import replace
from math import cos, hypot, pi, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from control.drive_fit import DriveFit, SeenPose, fit_drive
from control.errors import ControlError
from control.geometry import Pose2D
from control.history import SentCommands
from control.unicycle import Twist, UnicycleState
from datasets.world import RobotPlant, World
from pipeline.calibration.pattern import DRIVING, TURNING, Pattern

NOISE = (0.0003, 0.0003, 0.005)  # of seen poses, three times the rendered camera's [m, m, rad]
COVARIANCE = np.diag(np.square(NOISE))
CENTRED = Pose2D(0.0, 0.0, 0.0)
few = settings(max_examples=6, deadline=None)


def sent_as(pattern: Pattern, begin: float = 0.7) -> SentCommands:
    """The changes of a pattern, sent on the beat."""
    ends = np.cumsum([0.0, *(stretch.duration for stretch in pattern.stretches)])
    return SentCommands(
        tuple((begin + ends[:-1]).tolist()), tuple(stretch.twist for stretch in pattern.stretches)
    )


def seen_of(
    sent: SentCommands,
    plant: RobotPlant,
    delay: float,
    fps: float = 30.0,
    mount: Pose2D = CENTRED,
    seed: int | None = None,
    rest: float = 0.5,
    alike: int = 1,
) -> tuple[SeenPose, ...]:
    """Poses of a robot of `datasets.world`, which shares no line with the fit."""
    world = World((plant,))
    rng = np.random.default_rng(seed)
    for t, twist in zip(sent.times, sent.twists, strict=True):
        world.command(plant.robot_id, twist, t + delay)
    poses = []
    off = np.zeros(3)
    for number, t in enumerate(np.arange(0.5, sent.times[-1] + rest, 1.0 / fps).tolist()):
        world.advance(t)
        s = world.truth()[0].state
        x = s.x + cos(s.theta) * mount.x - sin(s.theta) * mount.y
        y = s.y + sin(s.theta) * mount.x + cos(s.theta) * mount.y
        if seed is not None and number % alike == 0:  # so many poses are off by the same
            off = rng.normal(0.0, NOISE)
        pose = Pose2D(x + off[0], y + off[1], s.theta + mount.theta + off[2])
        poses.append(SeenPose(t, pose, COVARIANCE))
    return tuple(poses)


def plant_of(v: float = 1.1, omega: float = 0.93, lag: float = 0.06) -> RobotPlant:
    """A robot with gains and a lag, somewhere on the floor."""
    start = UnicycleState(0.4, -0.2, 2.5, 0.0, 0.0)
    return RobotPlant(1, start, lag, v - 1.0, omega - 1.0)


def drive_of(fit: DriveFit) -> tuple[float, float, float, float]:
    """What is looked for."""
    return fit.gain.v, fit.gain.omega, fit.lag, fit.delay


@few
@given(
    v=st.floats(0.5, 1.95), omega=st.floats(0.5, 1.95), lag=st.floats(0.03, 0.15),
    delay=st.floats(0.0, 0.12), fps=st.floats(15.0, 60.0),
    x=st.floats(-0.02, 0.02), y=st.floats(-0.02, 0.02), turned=st.floats(-0.2, 0.2),
)  # fmt: skip
def test_what_was_hidden_is_found(
    v: float, omega: float, lag: float, delay: float, fps: float, x: float, y: float, turned: float
) -> None:
    sent, mount = sent_as(DRIVING), Pose2D(x, y, turned)
    fit = fit_drive(sent, seen_of(sent, plant_of(v, omega, lag), delay, fps, mount))
    assert drive_of(fit) == pytest.approx((v, omega, lag, delay), abs=5e-4)
    assert (fit.mount.x, fit.mount.y) == pytest.approx((x, y), abs=1e-4)
    assert fit.mount.theta == pytest.approx(turned, abs=1e-3)
    assert fit.position_rms < 1e-4


@few
@given(st.integers(0, 10_000))
def test_three_times_the_camera_s_noise_leaves_half_of_what_is_allowed(seed: int) -> None:
    rng = np.random.default_rng(seed)
    v, ratio, lag, delay = rng.uniform((0.8, 0.9, 0.03, 0.02), (1.2, 1.1, 0.15, 0.08)).tolist()
    sent = sent_as(DRIVING)
    fit = fit_drive(sent, seen_of(sent, plant_of(v, v / ratio, lag), delay, seed=seed))
    assert fit.gain.v == pytest.approx(v, rel=0.01)
    assert fit.gain.v / fit.gain.omega == pytest.approx(ratio, rel=0.015)
    assert fit.lag == pytest.approx(lag, rel=0.1)
    assert fit.delay == pytest.approx(delay, abs=0.0025)
    assert fit.position_rms == pytest.approx(2**0.5 * NOISE[0], rel=0.2)


@pytest.mark.parametrize("alike", [1, 6])
def test_standard_errors_are_those_of_repeated_drives(alike: int) -> None:
    sent, truth, off = sent_as(DRIVING), (1.1, 0.93, 0.06, 0.03), []
    for seed in range(16):
        fit = fit_drive(sent, seen_of(sent, plant_of(), 0.03, seed=seed, alike=alike))
        off.append((np.array(drive_of(fit)) - truth) / fit.std)
    rms = np.sqrt(np.mean(np.square(off), axis=0))
    assert np.all((rms > 0.5) & (rms < 1.8)), rms


@few
@given(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), st.floats(-pi, pi), st.floats(-0.03, 0.05))
def test_place_means_nothing_and_later_pictures_mean_delay(
    x: float, y: float, turn: float, later: float
) -> None:
    sent = sent_as(DRIVING)
    seen = seen_of(sent, plant_of(), 0.03, seed=1)
    c, s = cos(turn), sin(turn)
    rotation = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    moved = [
        SeenPose(
            p.t + later,
            Pose2D(
                x + c * p.pose.x - s * p.pose.y,
                y + s * p.pose.x + c * p.pose.y,
                p.pose.theta + turn,
            ),
            rotation @ p.covariance @ rotation.T,
        )
        for p in seen
    ]
    one, other = fit_drive(sent, seen), fit_drive(sent, moved)
    *others, delay = drive_of(one)
    assert drive_of(other) == pytest.approx((*others, delay + later), abs=2e-4)


def test_some_wrong_poses_do_little() -> None:
    sent = sent_as(DRIVING)
    seen = list(seen_of(sent, plant_of(), 0.03, seed=2))
    for number in range(5, len(seen), 40):
        pose = seen[number].pose
        seen[number] = replace(seen[number], pose=Pose2D(pose.x + 0.03, pose.y, pose.theta + 0.3))
    fit = fit_drive(sent, seen)
    assert fit.gain.v == pytest.approx(1.1, rel=0.01)
    assert fit.gain.v / fit.gain.omega == pytest.approx(1.1 / 0.93, rel=0.015)
    assert fit.delay == pytest.approx(0.03, abs=0.0025)


def test_what_was_not_driven_is_not_told() -> None:
    sent = sent_as(TURNING)
    with pytest.raises(ControlError, match="does not tell its forward gain"):
        fit_drive(sent, seen_of(sent, plant_of(), 0.03, seed=0))


def test_a_robot_that_stands_is_refused() -> None:
    sent = sent_as(DRIVING)
    nothing = SentCommands(sent.times, tuple(Twist(0.0, 0.0) for _ in sent.times))
    with pytest.raises(ControlError, match="hardly moved"):
        fit_drive(sent, seen_of(nothing, plant_of(), 0.03, seed=0))


def test_too_few_poses_are_refused() -> None:
    sent = sent_as(DRIVING)
    with pytest.raises(ControlError, match="19 poses, 20 needed"):
        fit_drive(sent, seen_of(sent, plant_of(), 0.03)[:19])


def test_the_pattern_ends_where_it_began_whatever_the_drive() -> None:
    for v, omega, lag in ((1.0, 1.0, 0.05), (1.9, 0.6, 0.15), (0.5, 1.9, 0.03)):
        seen = seen_of(sent_as(DRIVING), plant_of(v, omega, lag), 0.03, rest=1.5)
        first, last = seen[0].pose, seen[-1].pose
        assert hypot(last.x - first.x, last.y - first.y) < 0.001
        assert abs(last.theta - first.theta) < 0.001
        away = max(hypot(p.pose.x - first.x, p.pose.y - first.y) for p in seen)
        assert 0.01 < away < DRIVING.reach()
