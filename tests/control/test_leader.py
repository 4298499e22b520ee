"""The planned path in closed form, and the first-order law that tracks it."""

from dataclasses import replace
from math import hypot, nan, pi

import pytest
from hypothesis import given
from hypothesis import strategies as st

from control.actuation import Actuation, DriveGain
from control.errors import ControlError
from control.geometry import Pose2D
from control.leader import LeaderGains, begin_leader, leader_step
from control.plan import PathSegment, PlannedPath
from control.unicycle import Twist, UnicycleState, advance_lagged

ARC = PathSegment(pi * 0.4, 2.5)
PAPER = PlannedPath(Pose2D(0, 0, 0), (PathSegment(1.05), ARC, PathSegment(1.0)), 0.5, 0.0, 1.0)
GAINS, ACTUATION = LeaderGains(), Actuation()


def test_the_paper_s_path() -> None:
    joint = PAPER.at(2.6).state
    assert (joint.x, joint.y, joint.theta) == pytest.approx((1.05, 0.0, 0.0), abs=1e-12)
    turned = PAPER.at(2.6 + pi * 0.4 / 0.5).state
    assert (turned.x, turned.y, turned.theta) == pytest.approx((1.05, 0.8, pi), abs=1e-12)
    half = PAPER.at(0.5)
    assert (half.state.x, half.state.v, half.v_rate) == pytest.approx((0.0625, 0.25, 0.5))
    assert PAPER.at(3.0).state.omega == pytest.approx(1.25)
    assert PAPER.at(-1.0) == PAPER.at(0.0)


def test_the_path_goes_on_behind_its_end() -> None:
    path = PlannedPath(Pose2D(0, 0, 0), (PathSegment(0.5, 1.0),), 0.5)
    assert path.at(pi / 0.5).state.x == pytest.approx(0.0, abs=1e-12)  # half a circle of 1 m
    assert path.at(pi / 0.5).state.y == pytest.approx(2.0)


@given(st.floats(0.01, 7.9))
def test_velocities_are_the_derivative_of_the_pose(t: float) -> None:
    h = 1e-6
    a, b, motion = PAPER.at(t - h).state, PAPER.at(t + h).state, PAPER.at(t)
    if all(abs(t - joint) > 2 * h for joint in (1.0, 2.6, 2.6 + pi * 0.8)):
        assert hypot(b.x - a.x, b.y - a.y) / (2 * h) == pytest.approx(motion.state.v, abs=1e-7)
        assert (b.theta - a.theta) / (2 * h) == pytest.approx(motion.state.omega, abs=1e-7)
        assert (b.v - a.v) / (2 * h) == pytest.approx(motion.v_rate, abs=1e-7)


@pytest.mark.parametrize(
    "make",
    [
        lambda: PlannedPath(Pose2D(0, 0, 0), (), 0.5),
        lambda: PlannedPath(Pose2D(0, 0, 0), (PathSegment(0.0),), 0.5),
        lambda: PlannedPath(Pose2D(0, 0, 0), (PathSegment(1.0),), 0.5, 0.0, -1.0),
        lambda: LeaderGains(reaching=0.0),
    ],
)
def test_what_is_refused(make: object) -> None:
    with pytest.raises(ControlError):
        make()  # type: ignore[operator]


@pytest.mark.parametrize("t", [0.5, 2.0, 3.5, 7.0])
def test_on_its_plan_the_leader_accelerates_as_planned(t: float) -> None:
    planned = PAPER.at(t)
    memory = begin_leader(planned.state, planned, GAINS)
    after, _ = leader_step(memory, planned.state, planned, 0.005, GAINS, ACTUATION)
    assert after.acceleration == pytest.approx((planned.v_rate, planned.omega_rate), abs=1e-9)


def track(start: UnicycleState, gain: DriveGain, tick: float) -> list[tuple[float, float, float]]:
    """Ideal measurements: time, position error [m] and greatest |s| [m/s]."""
    state, rows = start, []
    memory = begin_leader(state, PAPER.at(0.0), GAINS)
    for i in range(round(8.0 / tick)):
        planned = PAPER.at(i * tick)
        memory, command = leader_step(memory, state, planned, tick, GAINS, ACTUATION, gain)
        off = hypot(planned.state.x - state.x, planned.state.y - state.y)
        rows.append((i * tick, off, max(map(abs, memory.sliding))))
        driven = Twist(1.1 * gain.v * command.v, 0.9 * gain.omega * command.omega)
        state = advance_lagged(state, driven, tick, ACTUATION.lag)
    return rows


@pytest.mark.parametrize("gain", [DriveGain(), DriveGain(0.8, 1.2)])
def test_an_off_start_is_tracked_in_despite_wrong_gains(gain: DriveGain) -> None:
    rows = track(UnicycleState(-0.05, 0.05, 0.2, 0.0, 0.0), gain, 0.005)
    assert rows[0][2] < 1e-12  # s(0) = 0, equation (17)
    late = [off for t, off, _ in rows if t > 2.0]
    assert max(late) < 0.015  # m
    assert (sum(off**2 for off in late) / len(late)) ** 0.5 < 0.006


def test_limits_hold_and_s_starts_at_zero_for_any_start() -> None:
    far = UnicycleState(3.0, -2.0, 2.0, 1.0, -4.0)
    memory = begin_leader(far, PAPER.at(3.0), GAINS)
    memory, command = leader_step(memory, far, PAPER.at(3.0), 0.06, GAINS, ACTUATION)
    assert max(map(abs, memory.sliding)) < 1e-12
    assert abs(command.v) <= ACTUATION.limits.v
    assert abs(command.omega) <= ACTUATION.limits.omega


def test_non_finite_input_is_refused_before_the_law() -> None:
    state = UnicycleState(0.0, 0.0, 0.0, 0.0, 0.0)
    memory = begin_leader(state, PAPER.at(0.0), GAINS)
    with pytest.raises(ControlError, match="leader's state"):
        leader_step(memory, replace(state, v=nan), PAPER.at(0.0), 0.005, GAINS, ACTUATION)
    with pytest.raises(ControlError, match="dt > 0"):
        leader_step(memory, state, PAPER.at(0.0), 0.0, GAINS, ACTUATION)
