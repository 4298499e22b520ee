"""Receding horizon: a new plan goes on from the old one, and only when it must."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from control.geometry import Pose2D
from control.obstacles import Obstacle
from control.planner import plan, replan
from control.spline_plan import SplinePlan
from tests.control.plan_scenes import (
    BLOCKED,
    CROSSED,
    HAIRPIN,
    IN_THE_WAY,
    Array,
    least_clearance,
    motions,
    times,
)

SCENES = {"blocked": replace(BLOCKED, t_start=3.0), "crossed": CROSSED, "hairpin": HAIRPIN}


@cache
def planned(name: str) -> SplinePlan:
    return plan(SCENES[name])


def kinematics(found: SplinePlan, t: float) -> Array:
    """Position, velocity and acceleration on the floor, and the heading."""
    x, y, theta, v, omega, v_rate, _ = motions(found, np.array([t]))[:, 0]
    c, s = np.cos(theta), np.sin(theta)
    a, b = v_rate, v * omega
    return np.array([x, y, v * c, v * s, a * c - b * s, a * s + b * c, theta])


@settings(max_examples=15)
@given(
    st.sampled_from(sorted(SCENES)),
    st.floats(0.0, 0.9) | st.floats(0.0, 1e-6),
    st.floats(-0.02, 0.02),
)
def test_position_velocity_and_acceleration_go_on(name: str, share: float, shift: float) -> None:
    old, request = planned(name), SCENES[name]
    since = share * old.law.duration
    t = old.t_start + since
    now = tuple(
        replace(o, x=o.x + since * o.vx + shift, y=o.y + since * o.vy) for o in request.obstacles
    )
    new = replan(old, t, replace(request, obstacles=now, clearance=0.3, duration=None))
    assert new.t_start == t
    np.testing.assert_allclose(kinematics(new, t), kinematics(old, t), atol=1e-9)
    end = new.at(new.t_end).state
    assert np.hypot(end.x - request.goal.x, end.y - request.goal.y) < 1e-6  # m
    if now:
        later = replace(request, obstacles=now)
        assert least_clearance(new, later, times(new)) >= 0.3 - 1e-4  # m


@pytest.mark.parametrize("share", [0.0, 0.2, 0.5, 0.8])
def test_without_news_the_old_way_is_kept(share: float) -> None:
    old = planned("blocked")
    t = old.t_start + share * old.law.duration
    new = replan(old, t, replace(BLOCKED, duration=None))
    assert new.t_end == pytest.approx(old.t_end)
    at = times(new, 100)
    off = motions(new, at)[:2] - motions(old, at)[:2]
    assert np.hypot(*off).max() < 0.03  # m: the spline's knots are others


def test_what_comes_into_the_way_is_seen_and_avoided() -> None:
    old, t = planned("blocked"), 4.0
    ahead = old.at(5.5).state  # s: where it would be in 1.5 s
    news = (Obstacle(ahead.x, ahead.y - 0.3, 0.1),)
    assert old.clearance(t, (IN_THE_WAY,)) >= BLOCKED.clearance
    assert old.clearance(t, news) < BLOCKED.clearance
    request = replace(BLOCKED, obstacles=news, duration=None)
    new = replan(old, t, request)
    assert new.clearance(t, news) >= BLOCKED.clearance
    assert least_clearance(new, request, times(new)) >= BLOCKED.clearance - 1e-4


def test_it_stays_on_its_side_of_an_obstacle() -> None:
    old = planned("blocked")
    assert motions(old, times(old))[1].min() < -0.3  # m: on the right
    request = replace(BLOCKED, obstacles=(replace(IN_THE_WAY, y=-0.1),), duration=None)
    kept, free = replan(old, 3.6, request), plan(request)
    assert motions(kept, times(kept))[1].min() < -0.5
    assert motions(free, times(free))[1].max() > 0.3  # shorter, from the start


def test_it_takes_longer_if_it_must() -> None:
    old = plan(replace(BLOCKED, obstacles=(), duration=3.5))
    request = replace(BLOCKED, obstacles=(Obstacle(1.2, 0.02, 0.2),), duration=None)
    new = replan(old, 0.5, request)
    assert new.law.duration > old.law.duration - 0.5 + 0.1  # s
    given_time = replan(old, 0.5, replace(request, duration=6.0))
    assert given_time.law.duration == 6.0


def test_moving_obstacles_are_judged_from_now_on() -> None:
    old = planned("crossed")
    (obstacle,) = CROSSED.obstacles
    at_two = replace(obstacle, y=obstacle.y + 2.0 * obstacle.vy)
    assert old.clearance(0.0, (obstacle,)) >= CROSSED.clearance - 1e-4
    assert old.clearance(2.0, (at_two,)) >= CROSSED.clearance - 1e-4
    met = replace(obstacle, y=old.at(5.0).state.y - 3.0 * obstacle.vy, x=old.at(5.0).state.x)
    assert old.clearance(2.0, (met,)) < CROSSED.clearance  # 3 s later
    assert old.clearance(9.0, (obstacle,)) >= CROSSED.clearance
    past = old.at(9.0).state
    assert old.clearance(9.0, (Obstacle(past.x, past.y, 0.1),)) < 0.0


@given(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0), st.floats(0.0, 9.0), st.floats(-9.0, 9.0))
def test_an_obstacle_moves_on_as_it_does(vx: float, vy: float, t: float, since: float) -> None:
    o, here, at = Obstacle(0.3, -0.2, 0.1, vx, vy), np.array([[0.5], [0.1]]), np.array([since])
    later, same = o.after(t).apart(here, at), o.apart(here, at + t)
    np.testing.assert_allclose(later, same, atol=1e-9)


def test_at_the_goal_the_old_plan_stays_and_another_goal_gets_a_plan() -> None:
    old = planned("crossed")
    for t in (old.law.duration - 1e-4, old.law.duration, old.law.duration + 2.0):
        assert replan(old, t, CROSSED) is old
    elsewhere = replace(CROSSED, goal=Pose2D(4.5, 0.5, 0.0), obstacles=(), duration=None)
    new = replan(old, 8.0, elsewhere)
    np.testing.assert_allclose(kinematics(new, 8.0), kinematics(old, 8.0), atol=1e-9)
    assert new.at(new.t_end).state.x == pytest.approx(4.5)


def test_a_goal_that_moves_is_followed() -> None:
    old = planned("blocked")
    request = replace(BLOCKED, goal=Pose2D(2.3, 0.2, 0.2), goal_speed=0.3, duration=None)
    new = replan(old, 4.5, request)
    np.testing.assert_allclose(kinematics(new, 4.5), kinematics(old, 4.5), atol=1e-9)
    end = new.at(new.t_end).state
    assert (end.x, end.y, end.v) == pytest.approx((2.3, 0.2, 0.3))
