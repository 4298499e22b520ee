"""Plans of the formation's leader: what they keep, where they go, what is refused, and why."""

from dataclasses import replace
from functools import cache
from math import hypot, pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from control.geometry import Pose2D
from control.planner import plan
from control.safety import Arena
from control.spline_plan import SplinePlan
from control.unicycle import UnicycleState
from tests.control.plan_scenes import (
    BEHIND,
    BLOCKED,
    CROSSED,
    HAIRPIN,
    IN_THE_WAY,
    LIMITS,
    PLACES,
    TWO,
    least_clearance,
    motions,
    moved,
    placed,
    random_request,
    times,
    wheels,
)

SCENES = {
    "blocked": BLOCKED,
    "crossed": CROSSED,
    "two": TWO,
    "hairpin": HAIRPIN,
    "behind": BEHIND,
    "turning": replace(BLOCKED, start=UnicycleState(0.0, 0.0, 0.2, 0.3, 0.5), duration=6.0),
    "hurried": replace(BLOCKED, duration=None),
    "late": replace(CROSSED, t_start=100.0),
    "long": replace(BLOCKED, duration=40.0),
}
every_scene = pytest.mark.parametrize("name", SCENES)


@cache
def planned(name: str) -> SplinePlan:
    return plan(SCENES[name])


@every_scene
def test_limits_of_the_leader_are_kept_also_between_the_nodes(name: str) -> None:
    found = planned(name)
    _, _, _, v, omega, v_rate, omega_rate = motions(found, times(found, 410))
    one = 1.0 + 1e-4  # times that the planner itself has not looked at
    assert v.min() >= 0.0
    assert v.max() <= LIMITS.v * one
    assert np.abs(omega).max() <= LIMITS.omega * one
    assert np.abs(v_rate).max() <= LIMITS.v_rate * one
    assert np.abs(omega_rate).max() <= LIMITS.omega_rate * one


@every_scene
def test_followers_can_keep_their_places(name: str) -> None:
    found = planned(name)
    for place in PLACES:
        rims = wheels(found, times(found, 410)[1:-1], place)
        assert rims.max() <= place.wheel_speed * 1.001


@pytest.mark.parametrize(
    "name", ["blocked", "crossed", "two", "turning", "hurried", "late", "long"]
)
def test_obstacles_keep_their_distance(name: str) -> None:
    found, request = planned(name), SCENES[name]
    seen = least_clearance(found, request, times(found, 4100))
    assert seen >= request.clearance - 1e-4  # m
    assert found.clearance(found.t_start, request.obstacles) == pytest.approx(seen, abs=1e-4)


def test_the_arena_is_not_left() -> None:
    found = plan(replace(BLOCKED, arena=Arena(-0.5, -0.5, 2.5, 1.1)))
    x, y, *_ = motions(found, times(found))
    assert y.max() <= 1.1 - BLOCKED.clearance + 1e-4  # m: now it must pass on the left
    assert y.min() >= -0.5 + BLOCKED.clearance - 1e-4
    assert x.min() >= -0.5 + BLOCKED.clearance - 1e-4


@settings(max_examples=20)
@given(st.integers(0, 10**6))
def test_what_is_found_keeps_everything(seed: int) -> None:
    request = random_request(np.random.default_rng(seed))
    found = plan(request)
    at = times(found, 137)
    _, _, _, v, omega, v_rate, omega_rate = motions(found, at)
    shares = (
        v / LIMITS.v,
        omega / LIMITS.omega,
        v_rate / LIMITS.v_rate,
        omega_rate / LIMITS.omega_rate,
    )
    assert np.abs(shares).max() <= 1.0 + 5e-4
    assert least_clearance(found, request, at) >= request.clearance  # m
    for place in PLACES:
        assert wheels(found, at[1:-1], place).max() <= place.wheel_speed * 1.001


@every_scene
def test_start_and_goal_are_met(name: str) -> None:
    found, request = planned(name), SCENES[name]
    first, last = found.at(found.t_start), found.at(found.t_end)
    s, g, start, goal = first.state, last.state, request.start, request.goal
    assert hypot(s.x - start.x, s.y - start.y) < 1e-9
    assert hypot(g.x - goal.x, g.y - goal.y) < 1e-6  # m
    assert (s.theta, s.v, s.omega) == pytest.approx((start.theta, start.v, start.omega), abs=1e-9)
    assert np.cos(g.theta - goal.theta) == pytest.approx(1.0, abs=1e-12)
    assert (g.v, g.omega, last.v_rate) == pytest.approx((request.goal_speed, 0.0, 0.0), abs=1e-9)


@every_scene
def test_the_heading_is_continuous(name: str) -> None:
    found = planned(name)
    theta = motions(found, times(found, 2000))[2]
    assert np.abs(np.diff(theta)).max() < 0.05  # rad


def test_before_its_start_a_plan_waits_and_at_its_goal_it_stands() -> None:
    found = planned("blocked")
    assert found.at(-1.0) == found.at(0.0)
    end, after = found.at(5.0), found.at(9.0)
    assert after.state.pose == end.state.pose
    assert (after.state.v, after.state.omega, after.v_rate, after.omega_rate) == (0, 0, 0, 0)


def test_behind_a_goal_with_a_speed_it_goes_straight_on() -> None:
    found = planned("crossed")
    after = found.at(8.0).state  # 2 s later at 0.4 m/s
    assert (after.x, after.y) == pytest.approx((2.4 + 0.8 * np.cos(0.4), 0.3 + 0.8 * np.sin(0.4)))
    assert (after.theta, after.v, after.omega) == pytest.approx((0.4, 0.4, 0.0))


def test_it_takes_the_shorter_side_of_what_is_in_the_straight_way() -> None:
    free = plan(replace(BLOCKED, obstacles=()))
    assert np.abs(motions(free, times(free))[1]).max() < 1e-6  # m: straight
    assert least_clearance(free, BLOCKED, times(free)) < 0.0
    for side in (1.0, -1.0):
        obstacle = replace(IN_THE_WAY, y=side * IN_THE_WAY.y)
        y = motions(plan(replace(BLOCKED, obstacles=(obstacle,))), times(free))[1]
        assert (side * y).min() < -0.3  # m
        assert (side * y).max() < 0.01


def test_a_moving_obstacle_is_where_it_will_be_not_where_it_was() -> None:
    standing = tuple(replace(o, vx=0.0, vy=0.0) for o in CROSSED.obstacles)
    careless = plan(replace(CROSSED, obstacles=standing))
    assert least_clearance(careless, CROSSED, times(careless)) < CROSSED.clearance - 0.05  # m


def test_without_a_duration_it_hurries_as_its_followers_allow() -> None:
    hurried = planned("hurried")
    assert hurried.law.duration < BLOCKED.duration
    slow = tuple(replace(place, wheel_speed=0.6) for place in PLACES)
    assert plan(replace(BLOCKED, duration=None, places=slow)).law.duration > hurried.law.duration


def test_followers_without_authority_would_be_lost() -> None:
    """The same turn planned for the leader alone asks more of a follower's wheels."""
    slow = tuple(replace(place, wheel_speed=0.6) for place in PLACES)
    alone, careful = (plan(replace(HAIRPIN, places=who, duration=3.5)) for who in ((), slow))
    worst = [
        max(wheels(found, times(found)[1:-1], place).max() for place in PLACES)
        for found in (alone, careful)
    ]
    assert worst[0] > 0.6 * 1.05  # m/s
    assert worst[1] <= 0.6 * 1.001


@settings(max_examples=20)
@given(
    st.sampled_from(["blocked", "crossed", "two"]),
    st.floats(-3.0, 3.0),
    st.floats(-3.0, 3.0),
    st.floats(-pi, pi),
    st.sampled_from([1.0, -1.0]),
)
def test_the_plan_moves_with_its_scene(
    name: str, x: float, y: float, angle: float, mirror: float
) -> None:
    frame = Pose2D(x, y, angle)
    there = plan(moved(SCENES[name], frame, mirror))
    at = times(there, 50)
    for t in at.tolist():
        here, far = planned(name).at(t).state, there.at(t).state
        expected = placed(here.pose, frame, mirror)
        assert hypot(far.x - expected.x, far.y - expected.y) < 1e-4  # m
        assert np.cos(far.theta - expected.theta) > 1.0 - 1e-6


def test_same_request_same_bits() -> None:
    again = plan(BLOCKED)
    assert again.control_points.tobytes() == planned("blocked").control_points.tobytes()
    assert not again.control_points.flags.writeable
