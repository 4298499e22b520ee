"""Who follows whom: arms, the same places on the floor for star and chain, changes of shape."""

from math import dist, hypot, pi, sqrt

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from control.cascade import Parents, ShapeChange, chain, pair_places, pair_shapes, star
from control.errors import ControlError
from control.formation import Formation, Pair
from control.geometry import Pose2D, compose, wrap_angle
from control.relative import relative_state
from control.shapes import SHAPES, Places, circle, column, line, named_shape, place_of, wedge
from control.shapes import given as listed

D = 0.05  # camera offset [m]
POINT = st.tuples(st.floats(-2, 2), st.floats(-2, 2))


@st.composite
def any_places(draw: st.DrawFn) -> Places:
    """A named shape, or a list of places that are apart from one another."""
    if draw(st.booleans()):
        return named_shape(draw(st.sampled_from(SHAPES)))(draw(st.integers(1, 9)), 0.2)
    points = draw(st.lists(POINT, min_size=1, max_size=6))
    gaps = [dist(p, q) for k, p in enumerate(points) for q in [(0.0, 0.0), *points[:k]]]
    assume(min(gaps) > 0.1)
    return listed(points)


def on_the_floor(leader: Pose2D, places: Places, parents: Parents) -> list[Pose2D]:
    """Poses of followers that head like the leader, each placed about the one it follows."""
    about = pair_places(places, parents, D)
    poses: dict[int, Pose2D] = {}
    while len(poses) < len(places):
        for k, parent in enumerate(parents):
            if k not in poses and (parent is None or parent in poses):
                frame = leader if parent is None else poses[parent]
                poses[k] = compose(frame, Pose2D(about[k][0] - D, about[k][1], 0.0))
    return [poses[k] for k in range(len(places))]


@given(any_places(), st.builds(Pose2D, st.floats(-2, 2), st.floats(-2, 2), st.floats(-3, 3)))
def test_chain_and_star_give_the_same_places_on_the_floor(places: Places, leader: Pose2D) -> None:
    chained = on_the_floor(leader, places, chain(places))
    for one, other in zip(on_the_floor(leader, places, star(places)), chained, strict=True):
        assert hypot(one.x - other.x, one.y - other.y) < 1e-9
    # and (6), (7) of every pair there are what the pair is told
    shapes = pair_shapes(places, (), chain(places), D)
    for follower, parent, shape in zip(chained, chain(places), shapes, strict=True):
        followed = leader if parent is None else chained[parent]
        seen, wanted = relative_state(followed, follower, D), shape.at(0.0)
        told = place_of((wanted.distance, wanted.bearing))
        assert dist(place_of((seen.distance, seen.bearing)), told) < 1e-9


@given(any_places())
def test_a_chain_leads_to_the_leader(places: Places) -> None:
    shapes = pair_shapes(places, (), chain(places), D)
    names = ["leader", *range(len(places))]
    pairs = [
        Pair("leader" if parent is None else parent, k, shape)
        for k, (parent, shape) in enumerate(zip(chain(places), shapes, strict=True))
    ]
    formation = Formation(tuple(pairs))
    assert formation.root == "leader"
    assert sorted(map(str, formation.robots)) == sorted(map(str, names))


@given(st.integers(1, 20), st.floats(0.3, 2.8), st.floats(0.05, 1.0))
def test_a_chain_follows_the_arms(count: int, half_angle: float, spacing: float) -> None:
    arms = tuple(None if k < 2 else k - 2 for k in range(count))
    assert chain(line(count, spacing)) == arms
    assert chain(wedge(count, spacing, half_angle)) == arms
    assert chain(circle(count, spacing, "rim")) == arms
    assert chain(column(count, spacing)) == (None, *range(count - 1))
    assert chain(circle(count, spacing)) == star(circle(count, spacing)) == (None,) * count


def test_of_equally_near_ones_a_chain_takes_the_leader_then_the_first() -> None:
    off = 1e-12  # m, as rounding leaves
    assert chain(((-0.3, 0.1), (-0.3, -0.1), (-0.5, -off))) == (None, None, 0)
    aside = 0.3 - sqrt(0.3**2 - 0.2**2)  # 0.3 m from the other, which is 0.3 m from the leader
    assert chain(((0.2 - off, aside), (0.0, 0.3))) == (None, None)


def test_a_chained_robot_measures_from_the_axle_of_the_one_ahead() -> None:
    places = column(3, 0.2)
    about = pair_places(places, chain(places), D)
    assert about[0] == pytest.approx((-0.2, 0.0))
    assert about[2] == pytest.approx((-0.15, 0.0))  # 0.2 m behind a camera point 0.05 m ahead


@given(any_places(), st.data())
def test_a_change_begins_and_ends_at_its_places_by_way_of_a_spiral(
    before: Places, data: st.DataObject
) -> None:
    after = named_shape(data.draw(st.sampled_from(SHAPES)))(len(before), 0.3)
    shapes = pair_shapes(before, [ShapeChange(2.0, after, 1.5)], star(before), D)
    for shape, old, new in zip(shapes, before, after, strict=True):
        course = [shape.at(2.0 + 1.5 * s) for s in (-0.1, 0.0, 0.3, 1.0, 1.1)]
        spots = [place_of((h.distance, h.bearing)) for h in course]
        for spot, place in zip(spots, (old, old, None, new, new), strict=True):
            assert place is None or dist(spot, place) < 1e-9
        l0, l1 = course[1].distance, course[3].distance
        turned = course[3].bearing - course[1].bearing
        assert abs(turned) <= pi + 1e-9
        share = 0.16308  # of the quintic at 0.3
        assert course[2].distance == pytest.approx(l0 + share * (l1 - l0), abs=1e-9)
        assert course[2].bearing == pytest.approx(course[1].bearing + share * turned, abs=1e-9)
        assert set(shape.changes) <= {2.0}


def test_a_mirrored_pair_stays_mirrored_through_a_change() -> None:
    change = ShapeChange(1.0, line(2, 0.4), 2.0)
    left, right = pair_shapes(wedge(2, 0.2), [change], (None, None), D)
    for t in (1.0, 1.7, 2.5, 4.0):
        one, other = left.at(t), right.at(t)
        assert one.distance == pytest.approx(other.distance)
        assert one.bearing == pytest.approx(-other.bearing)
        assert one.bearing_rate == pytest.approx(-other.bearing_rate)
    assert left.changes == (1.0,)


def test_an_arc_keeps_its_distance_and_two_changes_follow_each_other() -> None:
    quarter = place_of((0.3, -3.0)), place_of((0.3, 3.0))
    changes = [ShapeChange(1.0, (quarter[0],), 1.0), ShapeChange(3.0, (quarter[1],), 0.5)]
    (shape,) = pair_shapes(((-0.3, 0.0),), changes, (None,), D)
    assert shape.changes == (1.0, 3.0)
    for t in (1.3, 2.5, 3.2, 5.0):
        reference = shape.at(t)
        assert reference.distance == pytest.approx(0.3)
        assert abs(wrap_angle(reference.bearing - pi)) < 0.15  # by way of straight behind


def test_what_is_refused() -> None:
    places = column(2, 0.2)
    for parents, offset, message in (
        ((None,), D, "2 places need as many parents, got 1"),
        ((None, 2), D, "place 1 follows place 2, there are 0 to 1"),
        ((None, -1), D, "place 1 follows place -1"),
        ((None, 0), float("nan"), "camera offset: not finite"),
        ((None, 0), 0.2, "place 1 is .* mm from the axle of the robot it follows"),
    ):
        with pytest.raises(ControlError, match=message):
            pair_places(places, parents, offset)
    with pytest.raises(ControlError, match="3 places need as many parents, got 2"):
        pair_shapes(places, [ShapeChange(1.0, line(3, 0.2), 1.0)], star(places), D)
    twice = [ShapeChange(1.0, line(2, 0.2), 2.0), ShapeChange(2.0, places, 1.0)]
    with pytest.raises(ControlError, match="at 2 s begins before the one at 1 s"):
        pair_shapes(places, twice, star(places), D)
