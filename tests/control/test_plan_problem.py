"""The planner's mathematics: flat outputs, time laws, Jacobians, against finite differences."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from control.geometry import Pose2D
from control.plan_curves import End
from control.plan_problem import FINER, problem
from control.safety import Arena
from control.spline_plan import SplinePlan
from control.time_law import ramps
from tests.control.plan_scenes import PLACES, TWO, Array, follower_motion, motions, times

REQUEST = replace(TWO, arena=Arena(-0.6, -1.2, 3.6, 1.2), t_start=2.0)
ENDS = (
    End(Pose2D(0.1, 0.2, 0.3), (0.5, 0.2), (0.0, 0.3)),
    End(Pose2D(3.0, 0.0, -0.4), (0.5,), (0.0, 0.0)),
)
TASK = problem(REQUEST, ENDS, ramps(7.0, 2.0, 0.4, 0.25, 0.0), 3.0)
FREE = TASK.linear.shape[3]
variables = st.lists(st.floats(-0.3, 0.3), min_size=FREE, max_size=FREE).map(np.array)


def plan_of(w: Array) -> SplinePlan:
    """The plan of some variables, whether it keeps anything or not."""
    best, directions = TASK.curves
    points = best + directions @ w
    return SplinePlan(points.T, TASK.law, 0.3, REQUEST.t_start)


def regular(w: Array) -> bool:
    """Differences lose their digits where a curve all but stops."""
    return bool(TASK.shares(w)[0].max() < 1.0)


@settings(max_examples=25)
@given(variables)
def test_velocities_and_accelerations_are_derivatives_of_the_pose(w: Array) -> None:
    plan, h = plan_of(w), 1e-5
    assume(regular(w))
    at = times(plan, 50)[1:-1]
    before, now, after = (motions(plan, t) for t in (at - h, at, at + h))
    rate, (_, _, theta, v, omega, v_rate, omega_rate) = (after - before) / (2.0 * h), now
    np.testing.assert_allclose(rate[0], v * np.cos(theta), atol=1e-6)  # m/s
    np.testing.assert_allclose(rate[1], v * np.sin(theta), atol=1e-6)
    np.testing.assert_allclose(rate[2], omega, rtol=1e-5, atol=1e-5)  # rad/s
    np.testing.assert_allclose(rate[3], v_rate, rtol=1e-4, atol=1e-5)  # m/s^2
    np.testing.assert_allclose(rate[4], omega_rate, rtol=1e-3, atol=1e-3)  # rad/s^2


@settings(max_examples=25)
@given(variables)
def test_jacobians_are_derivatives_of_the_shares(w: Array) -> None:
    chosen = np.arange(len(TASK.t)) % FINER == 0
    nodes, h = TASK.at(chosen), 1e-6
    assume(regular(w))
    steps = h * np.eye(FREE)
    numeric = [(nodes.shares(w + d) - nodes.shares(w - d)) / (2.0 * h) for d in steps]
    analytic = nodes.jacobian(w)
    size = 1.0 + np.abs(analytic).max(axis=(1, 2), keepdims=True)
    assert analytic.shape == (len(nodes.names()), 41, FREE)
    assert np.abs((analytic - np.stack(numeric, axis=-1)) / size).max() < 1e-6


@settings(max_examples=15)
@given(variables)
def test_shares_of_followers_are_those_of_points_rigid_in_the_leader_s_frame(w: Array) -> None:
    plan = plan_of(w)
    assume(regular(w))
    shares, at = TASK.shares(w)[:, 5:-5:7], (plan.t_start + TASK.t)[5:-5:7]
    for place in PLACES:
        name = f"wheel speed of the follower at ({place.x:g}, {place.y:g}) m"
        rows = [i for i, other in enumerate(TASK.names()) if other == name]
        speed, turn = follower_motion(plan, at, place)
        half = 0.5 * place.track_width
        expected = np.array([speed + half * turn, speed - half * turn]) / place.wheel_speed
        np.testing.assert_allclose(shares[rows], expected, rtol=1e-4, atol=1e-4)


@settings(max_examples=25)
@given(variables)
def test_every_curve_has_the_ends_that_were_asked_for(w: Array) -> None:
    start, goal = motions(plan_of(w), np.array([2.0, 9.0])).T
    v, omega, v_rate = 0.4 * 0.5, 0.4 * 0.3 / 0.5, 0.4**2 * 0.2 + 0.25 * 0.5
    assert start == pytest.approx([0.1, 0.2, 0.3, v, omega, v_rate, start[6]], abs=1e-9)
    assert goal == pytest.approx([3.0, 0.0, -0.4, 0.0, 0.0, 0.0, 0.0], abs=1e-9)


@settings(max_examples=10)
@given(variables)
def test_the_cost_is_the_integral_of_the_squared_third_derivative(w: Array) -> None:
    def cost(w: Array) -> float:
        """By the spline's own third derivative, over S."""
        plan = plan_of(w)
        s = np.linspace(0.0, TASK.law.end, 4001)
        return float((plan._curves[3](s) ** 2).sum(axis=1).mean()) * TASK.law.end

    scale = 720.0 * 3.0**2 / TASK.law.end**5
    assert (cost(w) - cost(0.0 * w)) / scale == pytest.approx(w @ w, rel=0.02, abs=1e-3)


@settings(max_examples=50)
@given(st.floats(0.0, 1.0), st.floats(-2.0, 2.0), st.floats(0.0, 1.0), st.floats(0.5, 20.0))
def test_time_laws_stay_within_0_and_1_and_go_on_as_they_were(
    first: float, slope: float, last: float, duration: float
) -> None:
    if not 0.02 < first < 0.98:
        slope = 0.0
    law = ramps(duration, 0.3 * duration, first, slope, last)
    t = np.linspace(0.0, duration, 301)
    s, pace, rate = law.at(t)
    assert pace.min() > -1e-12
    assert pace.max() < 1.0 + 1e-12
    assert (pace[0], rate[0], pace[-1], rate[-1]) == pytest.approx((first, slope, last, 0.0))
    np.testing.assert_allclose(np.diff(s), (pace[1:] + pace[:-1]) / 2 * t[1], atol=0.01 * t[1])
    for left in (0.1, 0.5, 0.9):
        at = left * duration
        rest, on = law.rest(at), np.linspace(0.0, duration - at, 50)
        assert rest.duration == pytest.approx(duration - at)
        np.testing.assert_allclose(
            rest.at(on)[1:3], law.at(at + on)[1:3], atol=1e-9 * (1 + abs(slope))
        )
