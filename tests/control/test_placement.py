"""Where followers should stand: the place that gives the wanted output, found again from it."""

from math import cos, hypot, pi, sin

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from control.formation import ShapeReference
from control.geometry import Pose2D, wrap_angle
from control.placement import wanted_pose
from control.relative import relative_state

D = 0.05
ANGLE, METRE = st.floats(-pi, pi), st.floats(-1, 1)
POSE = st.builds(Pose2D, METRE, METRE, ANGLE)


def point_of(pose: Pose2D) -> tuple[float, float]:
    """A robot's camera point [m, m]."""
    return pose.x + D * cos(pose.theta), pose.y + D * sin(pose.theta)


@given(POSE, st.floats(0.05, 1), ANGLE, ANGLE)
def test_one_leader(leader: Pose2D, distance: float, bearing: float, heading: float) -> None:
    place = wanted_pose([leader], [ShapeReference(distance, bearing)], Pose2D(9.0, 9.0, heading), D)
    seen = relative_state(leader, place, D)
    assert seen.distance == pytest.approx(distance, abs=1e-9)
    assert wrap_angle(seen.bearing - bearing) == pytest.approx(0.0, abs=1e-9)
    assert place.theta == heading


@given(POSE, POSE, POSE)
def test_two_leaders_on_the_side_where_the_follower_is(
    one: Pose2D, two: Pose2D, follower: Pose2D
) -> None:
    x, y = point_of(follower)
    cross = (two.x - one.x) * (y - one.y) - (two.y - one.y) * (x - one.x)
    assume(abs(cross) > 1e-3)
    distances = [hypot(x - leader.x, y - leader.y) for leader in (one, two)]
    place = wanted_pose([one, two], [ShapeReference(r, 0.0) for r in distances], follower, D)
    assert point_of(place) == pytest.approx((x, y), abs=1e-6)


def test_circles_that_do_not_meet_and_leaders_in_one_place() -> None:
    one, two, follower = Pose2D(0.0, 0.0, 0.0), Pose2D(1.0, 0.0, 0.0), Pose2D(0.4, 0.3, 0.0)
    near = wanted_pose([one, two], [ShapeReference(0.2, 0.0)] * 2, follower, D)
    assert point_of(near) == pytest.approx((0.5, 0.0))
    same = wanted_pose([one, one], [ShapeReference(0.2, 0.0)] * 2, follower, D)
    assert (same.x, same.y) == pytest.approx((0.4, 0.3))
