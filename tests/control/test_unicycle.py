"""Laws of the unicycle: wheels, arcs, lag, limits."""

from math import cos, exp, isclose, pi, sin

import pytest
from hypothesis import given
from hypothesis import strategies as st

from control.errors import ControlError
from control.geometry import Pose2D, cos_of_turn, sin_of_turn, sine_ratio
from control.unicycle import (
    SpeedLimits,
    Twist,
    UnicycleState,
    WheelSpeeds,
    advance_lagged,
    advance_pose,
    twist_from_wheels,
    wheels_from_twist,
)

SPEED = st.floats(-3.0, 3.0)
TURN = st.floats(-20.0, 20.0)
POSE = st.builds(Pose2D, SPEED, SPEED, st.floats(-pi, pi))


@given(SPEED, TURN, st.floats(0.02, 0.5))
def test_wheels_and_twist_are_inverse(v: float, omega: float, track: float) -> None:
    back = twist_from_wheels(wheels_from_twist(Twist(v, omega), track), track)
    assert isclose(back.v, v, abs_tol=1e-12)
    assert isclose(back.omega, omega, abs_tol=1e-9)


def test_right_wheel_is_faster_in_a_left_turn() -> None:
    assert wheels_from_twist(Twist(0.5, 2.0), 0.1) == WheelSpeeds(0.4, 0.6)


@given(POSE, SPEED, TURN, st.floats(0.0, 0.5), st.floats(0.0, 0.5))
def test_an_arc_in_two_pieces_is_the_arc(
    pose: Pose2D, v: float, w: float, a: float, b: float
) -> None:
    twist = Twist(v, w)
    whole = advance_pose(pose, twist, a + b)
    pieces = advance_pose(advance_pose(pose, twist, a), twist, b)
    assert abs(whole.x - pieces.x) < 1e-12
    assert abs(whole.y - pieces.y) < 1e-12
    assert abs(whole.theta - pieces.theta) < 1e-12


@pytest.mark.parametrize("omega", [1e-3, 0.04, 0.0401, 1.0, 7.0])
def test_an_arc_lies_on_its_circle(omega: float) -> None:
    end = advance_pose(Pose2D(0.0, 0.0, 0.3), Twist(0.5, omega), 0.005)
    radius = 0.5 / omega
    assert abs(end.x - radius * (sin(0.3 + 0.005 * omega) - sin(0.3))) < 1e-13 * radius + 1e-15
    assert abs(end.y - radius * (cos(0.3) - cos(0.3 + 0.005 * omega))) < 1e-13 * radius + 1e-15


@given(SPEED, TURN, SPEED, TURN, st.floats(1e-3, 0.2), st.floats(0.01, 0.3))
def test_lagged_velocities_are_exponential(
    v: float, w: float, cv: float, cw: float, dt: float, lag: float
) -> None:
    state = UnicycleState(0.0, 0.0, 0.0, v, w)
    end = advance_lagged(state, Twist(cv, cw), dt, lag)
    assert isclose(end.v, cv + (v - cv) * exp(-dt / lag), abs_tol=1e-12)
    assert isclose(end.omega, cw + (w - cw) * exp(-dt / lag), abs_tol=1e-12)


def test_a_lagged_step_of_5_ms_agrees_with_fine_steps() -> None:
    state, command = UnicycleState(0.1, -0.2, 0.4, 0.3, -8.0), Twist(0.9, 10.0)
    coarse = advance_lagged(state, command, 0.005, 0.05)
    fine = state
    for _ in range(1000):
        fine = advance_lagged(fine, command, 5e-6, 0.05)
    assert abs(coarse.x - fine.x) < 3e-6  # 3 micrometres at a change of 18 rad/s
    assert abs(coarse.y - fine.y) < 3e-6
    assert isclose(coarse.theta, fine.theta, abs_tol=1e-12)
    assert isclose(coarse.v, fine.v, abs_tol=1e-12)


@given(SPEED, TURN)
def test_saturation_keeps_limits_and_what_is_within(v: float, omega: float) -> None:
    kept = SpeedLimits(0.8, 5.0).saturate(Twist(v, omega))
    assert abs(kept.v) <= 0.8
    assert abs(kept.omega) <= 5.0
    assert abs(v) > 0.8 or kept.v == v
    assert abs(omega) > 5.0 or kept.omega == omega


@pytest.mark.parametrize("limits", [(0.0, 1.0), (1.0, -1.0), (float("nan"), 1.0)])
def test_limits_must_be_positive(limits: tuple[float, float]) -> None:
    with pytest.raises(ControlError, match="speed limits"):
        SpeedLimits(*limits)


@given(st.floats(-0.2, 0.2))
def test_series_of_small_turns_are_sine_and_cosine_to_the_last_bit(angle: float) -> None:
    assert cos_of_turn(angle) == pytest.approx(cos(angle), rel=2.3e-16, abs=0.0)
    assert sin_of_turn(angle) == pytest.approx(sin(angle), rel=4.5e-16, abs=0.0)
    assert sine_ratio(0.0) == 1.0
