"""Named shapes: spacing, symmetry, order, and places as distance and bearing."""

from itertools import combinations
from math import cos, dist, hypot, pi, sin

import numpy as np
import pytest
from hypothesis import given as for_all
from hypothesis import strategies as st

from control.errors import ControlError
from control.geometry import Pose2D
from control.relative import relative_state
from control.shapes import (
    SHAPES,
    Places,
    circle,
    column,
    given,
    line,
    named_shape,
    place_of,
    polar_of,
    wedge,
)

LEADER = (0.0, 0.0)
COUNT, SPACING = st.integers(1, 20), st.floats(0.05, 1.0)
ANY_SHAPE = st.sampled_from(SHAPES)


def least_gap(places: Places) -> float:
    """Least distance between two robots, the leader included [m]."""
    return min(dist(one, other) for one, other in combinations([LEADER, *places], 2))


@for_all(ANY_SHAPE, COUNT, SPACING)
def test_no_two_robots_are_nearer_than_the_spacing_and_some_are_that_near(
    name: str, count: int, spacing: float
) -> None:
    places = named_shape(name)(count, spacing)
    assert len(places) == count
    assert least_gap(places) == pytest.approx(spacing)


@for_all(st.integers(1, 20), SPACING)
def test_on_the_rim_neighbours_are_a_spacing_apart_all_around(count: int, spacing: float) -> None:
    places = circle(count, spacing, leader="rim")
    around = [LEADER, *places[::2], *reversed(places[1::2])]  # down the left, up the right
    for one, other in zip(around, [*around[1:], LEADER], strict=True):
        assert dist(one, other) == pytest.approx(spacing)
    middle = np.mean(around, axis=0)
    assert np.ptp([dist(place, middle) for place in around]) < 1e-9
    assert max(x for x, _ in places) < 0.0  # the leader is the foremost


@for_all(COUNT, SPACING)
def test_about_the_leader_all_are_as_far_and_evenly_around(count: int, spacing: float) -> None:
    places = circle(count, spacing)
    polars = sorted((polar_of(place) for place in places), key=lambda polar: polar[1])
    assert np.ptp([distance for distance, _ in polars]) < 1e-9
    assert polars[0][0] >= spacing - 1e-12
    gaps = np.diff([*(bearing for _, bearing in polars), polars[0][1] + 2 * pi])
    np.testing.assert_allclose(gaps, 2 * pi / count, atol=1e-9)
    assert polar_of(places[0])[1] == pytest.approx(pi)


@for_all(COUNT, SPACING, st.floats(0.6, 2.5))
def test_arms_of_a_wedge(count: int, spacing: float, half_angle: float) -> None:
    for k, place in enumerate(wedge(count, spacing, half_angle)):
        distance, bearing = polar_of(place)
        assert distance == pytest.approx((k // 2 + 1) * spacing)
        assert bearing == pytest.approx((pi - half_angle) * (-1) ** k)  # the first on the left


@for_all(SPACING, st.integers(1, 9))
def test_left_and_right_mirror_each_other(spacing: float, ranks: int) -> None:
    count = 2 * ranks
    for places in (
        line(count, spacing),
        wedge(count, spacing, 1.0),
        circle(count, spacing, "rim"),
        circle(count + 1, spacing)[1:],
    ):
        for (x, y), (u, v) in zip(places[::2], places[1::2], strict=True):
            assert (x, y) == (u, -v)
            assert y > 0.0


def test_places_in_numbers() -> None:
    assert line(3, 0.2) == ((0.0, 0.2), (0.0, -0.2), (0.0, 0.4))
    assert column(2, 0.2) == ((-0.2, 0.0), (-0.4, 0.0))
    side = 0.2 * cos(pi / 4)
    np.testing.assert_allclose(wedge(2, 0.2), [(-side, side), (-side, -side)], atol=1e-15)
    # as the paper prints them, read in the convention of (7)
    np.testing.assert_allclose(polar_of(wedge(2, 0.2)[0]), (0.2, 3 * pi / 4))
    np.testing.assert_allclose(wedge(2, 0.2, pi / 2), line(2, 0.2), atol=1e-15)
    np.testing.assert_allclose(circle(2, 0.2), [(-0.2, 0.0), (0.2, 0.0)], atol=1e-15)
    np.testing.assert_allclose(circle(1, 0.2, "rim"), [(-0.2, 0.0)], atol=1e-15)
    radius = 0.1 / sin(pi / 12)  # twelve chords of 0.2 m
    assert hypot(*circle(12, 0.2)[5]) == pytest.approx(radius)


@for_all(st.floats(-3, 3), st.floats(-3, 3))
def test_place_to_polar_and_back(x: float, y: float) -> None:
    distance, bearing = polar_of((x, y))
    assert distance >= 0.0
    assert -pi < bearing <= pi
    assert dist(place_of((distance, bearing)), (x, y)) < 1e-12
    assert dist(place_of((distance, bearing + 4 * pi)), (x, y)) < 1e-12


def test_straight_behind_is_pi_whatever_the_sign_of_zero() -> None:
    assert polar_of((-1.0, 0.0)) == polar_of((-1.0, -0.0)) == (1.0, pi)
    assert polar_of((0.0, 2.0)) == (2.0, pytest.approx(pi / 2))


@for_all(
    st.builds(Pose2D, st.floats(-2, 2), st.floats(-2, 2), st.floats(-3, 3)),
    st.builds(Pose2D, st.floats(-2, 2), st.floats(-2, 2), st.floats(-3, 3)),
)
def test_the_convention_is_that_of_6_and_7(leader: Pose2D, follower: Pose2D) -> None:
    d = 0.05  # m
    seen = relative_state(leader, follower, d)
    ahead, left = place_of((seen.distance, seen.bearing))
    c, s = cos(leader.theta), sin(leader.theta)
    camera = follower.x + d * cos(follower.theta), follower.y + d * sin(follower.theta)
    assert dist(camera, (leader.x + c * ahead - s * left, leader.y + s * ahead + c * left)) < 1e-9


@pytest.mark.parametrize("name", SHAPES)
def test_no_shape_without_followers_or_spacing(name: str) -> None:
    for count, spacing, message in (
        (0, 0.2, "at least 1 follower, got 0"),
        (3, 0.0, "at least 0.001 m, got 0 m"),
        (3, -0.2, "got -0.2 m"),
        (3, float("nan"), "got nan m"),
        (3, float("inf"), "got inf m"),
    ):
        with pytest.raises(ControlError, match=message):
            named_shape(name)(count, spacing)


def test_what_else_is_refused() -> None:
    for places, message in (
        ([], "at least one place"),
        ([(0.1, float("nan"))], "not finite: 0.1, nan"),
        ([(0.3, 0.0), (0.0, 0.0)], r"place 1 at \(0, 0\) m coincides with the leader"),
        ([(0.3, 0.1), (1.0, 0.0), (0.3, 0.1005)], "place 2 at .* coincides with place 0"),
    ):
        with pytest.raises(ControlError, match=message):
            given(places)
    for angle in (0.0, pi, -1.0, float("nan")):
        with pytest.raises(ControlError, match=r"in \(0, pi\) rad, got"):
            wedge(2, 0.2, angle)
    with pytest.raises(ControlError, match=r"place 1 at .* coincides with place 0"):
        wedge(2, 0.2, 1e-3)
    with pytest.raises(ControlError, match="got 'middle'"):
        circle(2, 0.2, "middle")  # type: ignore[arg-type]
    with pytest.raises(ControlError, match="no shape 'square'; there are: line, column"):
        named_shape("square")
