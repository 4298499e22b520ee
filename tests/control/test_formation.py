"""Shapes and their derivatives; the tree of pairs and what it refuses."""

from math import isnan, pi

import pytest
from hypothesis import given
from hypothesis import strategies as st

from control.errors import ControlError
from control.formation import Formation, Pair, Shape, by_follower
from control.profile import TanhStep

BEHIND = Shape(TanhStep.constant(0.2), TanhStep.constant(pi))


def pair(leader: int | str, follower: int | str) -> Pair:
    """A pair whose shape does not matter."""
    return Pair(leader, follower, BEHIND)


def beside(leader: int, follower: int) -> Pair:
    """A distance without a bearing."""
    return Pair(leader, follower, Shape(TanhStep.constant(0.2), None))


@given(st.floats(-2, 2), st.floats(-2, 2), st.floats(0, 10), st.floats(0.1, 20), st.floats(-1, 1))
def test_derivatives_of_a_step(
    before: float, after: float, t0: float, rate: float, off: float
) -> None:
    step, t, h = TanhStep(before, after, t0, rate), t0 + off, 1e-4 / rate
    low, middle, high = (step.at(t + k * h) for k in (-1, 0, 1))
    size = abs(after - before) + 1e-6
    assert abs((high[0] - low[0]) / (2 * h) - middle[1]) < 1e-6 * size * rate
    assert abs((high[1] - low[1]) / (2 * h) - middle[2]) < 1e-6 * size * rate**2
    assert min(before, after) - 1e-12 <= middle[0] <= max(before, after) + 1e-12


def test_the_paper_s_shape() -> None:
    shape = Shape(TanhStep(0.2, 0.15, 5.5, 10.0), TanhStep.constant(3 * pi / 4))
    assert shape.at(0.0).distance == pytest.approx(0.2, abs=1e-12)
    assert shape.at(5.5).distance == pytest.approx(0.175, abs=1e-12)  # printed in section V
    assert shape.at(5.5).distance_rate == pytest.approx(-0.25, abs=1e-12)
    assert shape.at(8.0).distance == pytest.approx(0.15, abs=1e-12)
    assert shape.at(8.0).bearing == 3 * pi / 4
    assert shape.changes == (5.5,)
    assert BEHIND.changes == ()


def test_pairs_are_ordered_leaders_first() -> None:
    formation = Formation((pair(4, 5), pair("a", 4), pair("a", 3), pair(5, 6)))
    assert formation.root == "a"
    assert formation.robots == ("a", 4, 3, 5, 6)


@given(st.permutations(range(1, 12)), st.data())
def test_any_tree_comes_out_ordered(order: list[int], data: st.DataObject) -> None:
    parents = {n: data.draw(st.integers(0, n - 1)) for n in order}
    formation = Formation(tuple(pair(parents[n], n) for n in order))
    seen = {formation.root}
    for each in formation.pairs:
        assert each.leader in seen
        seen.add(each.follower)
    assert seen == set(range(12))


@pytest.mark.parametrize(
    ("pairs", "message"),
    [
        ((), "at least one pair"),
        ((pair(1, 2), pair(3, 2)), "robot 2 follows 1, 3 and takes distances alone"),
        ((pair(1, 2), beside(1, 3)), "robot 3 follows 1 and needs a bearing"),
        ((pair(1, 2), beside(1, 3), pair(2, 3)), "robot 3 follows 1, 2 and takes distances alone"),
        ((pair(1, 2), beside(1, 3), beside(1, 3)), "robot 3 follows 1, 1: give it one leader"),
        (
            (pair(1, 2), pair(1, 3), pair(1, 4), *(beside(i, 5) for i in (2, 3, 4))),
            "robot 5 follows 2, 3, 4: give it one leader, or two",
        ),
        ((pair(1, 2), pair(3, 4)), "one leader without a leader, found: 1, 3"),
        ((pair(1, 2), pair(3, 4), pair(4, 3)), "circle: 4, 3"),
        ((pair(1, 1),), "circle: 1"),
        ((pair(1, 2), beside(2, 3), beside(4, 3), pair(3, 4)), "circle: 3, 4"),
    ],
)
def test_what_is_refused(pairs: tuple[Pair, ...], message: str) -> None:
    with pytest.raises(ControlError, match=message):
        Formation(pairs)


@given(st.permutations(range(1, 12)), st.data())
def test_any_graph_of_followers_of_one_or_two_comes_out_ordered(
    order: list[int], data: st.DataObject
) -> None:
    pairs: list[Pair] = []
    for n in order:
        leaders = data.draw(st.lists(st.integers(0, n - 1), min_size=1, max_size=2, unique=True))
        make = pair if len(leaders) == 1 else beside
        pairs += [make(leader, n) for leader in leaders]
    formation = Formation(tuple(pairs))
    placed = {formation.root}
    for follower, group in by_follower(formation.pairs).items():
        assert {each.leader for each in group} <= placed
        placed.add(follower)
    assert placed == set(formation.robots) == set(range(12))
    assert [p.follower for p in formation.pairs] == [
        follower for follower, group in by_follower(formation.pairs).items() for _ in group
    ]


def test_a_shape_without_a_bearing_wants_none() -> None:
    reference = beside(1, 2).shape.at(1.0)
    assert reference.distance == 0.2
    assert isnan(reference.bearing)
