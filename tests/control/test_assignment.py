"""Assignment: least squares against brute force, no meeting, ties by order, bound robots."""

from itertools import combinations, permutations
from math import cos, dist, sin, sqrt
from random import Random

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from control.assignment import assigned, crossings, positions_about, rearranged
from control.command import RobotId
from control.errors import ControlError
from control.geometry import Pose2D
from control.relative import Vector2
from control.shapes import Places, line, wedge

COORDINATE = st.floats(-2.0, 2.0)
POINT = st.tuples(COORDINATE, COORDINATE)
GRID = st.tuples(st.integers(-1, 1), st.integers(-1, 1))  # full of ties


@st.composite
def tasks(draw: st.DrawFn, points: st.SearchStrategy[Vector2], most: int) -> tuple[Places, Places]:
    """As many positions as places."""
    n = draw(st.integers(1, most))
    lists = st.lists(points, min_size=n, max_size=n)
    return tuple(draw(lists)), tuple(draw(lists))


def taken(robots: tuple[RobotId, ...]) -> list[int]:
    """Place of each robot 0, 1, 2, ..."""
    return [robots.index(k) for k in range(len(robots))]


def squares(starts: Places, ends: Places) -> float:
    """Sum of squared ways [m^2]."""
    return sum(dist(p, q) ** 2 for p, q in zip(starts, ends, strict=True))


@given(tasks(st.one_of(POINT, GRID), 6))
def test_no_other_assignment_has_shorter_squared_ways(task: tuple[Places, Places]) -> None:
    starts, places = task
    chosen = squares(starts, rearranged(starts, places))
    assert chosen <= min(squares(starts, order) for order in permutations(places)) + 2e-9


@given(tasks(GRID, 5))
def test_of_equal_ones_the_first_in_order(task: tuple[Places, Places]) -> None:
    starts, places = task
    orders = list(permutations(range(len(places))))
    costs = [round(squares(starts, [places[k] for k in order])) for order in orders]
    first = orders[costs.index(min(costs))]  # permutations come in lexical order
    assert taken(assigned(dict(enumerate(starts)), places)) == list(first)


@given(tasks(st.one_of(POINT, GRID), 8), st.randoms(use_true_random=False))
def test_the_order_in_which_robots_are_given_does_not_matter(
    task: tuple[Places, Places], random: Random
) -> None:
    starts, places = task
    names = [3, "b", 1, "a", 10, "c", 2, "10"]
    robots = list(zip(names, starts, strict=False))
    shuffled = list(robots)
    random.shuffle(shuffled)
    assert assigned(dict(robots), places) == assigned(dict(shuffled), places)


@given(tasks(st.one_of(POINT, GRID), 9))
def test_robots_that_drive_straight_never_meet(task: tuple[Places, Places]) -> None:
    starts, places = task
    ends = rearranged(starts, places)
    assert crossings(starts, ends) == 0
    s = np.linspace(0.0, 1.0, 101)[:, None, None]
    ways = (1.0 - s) * np.array(starts) + s * np.array(ends)
    for i, j in combinations(range(len(starts)), 2):
        gap = min(dist(starts[i], starts[j]), dist(ends[i], ends[j]))
        nearest = np.hypot(*(ways[:, i] - ways[:, j]).T).min()
        assert nearest >= gap / sqrt(2.0) - 1e-4  # sqrt of the tolerance of ties


@given(POINT, POINT, POINT, st.floats(0.1, 0.9))
def test_robots_that_meet_are_counted(p: Vector2, q: Vector2, other: Vector2, s: float) -> None:
    assume(dist(p, other) > 0.1)
    meeting = [(1.0 - s) * a + s * b for a, b in zip(p, q, strict=True)]
    end = tuple((m - (1.0 - s) * a) / s for m, a in zip(meeting, other, strict=True))
    assert crossings([p, other], [q, end]) == 1


def test_crossings_in_numbers() -> None:
    corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
    assert crossings(corners, corners) == 0
    assert crossings(corners, [corners[k] for k in (2, 3, 0, 1)]) == 6  # all to opposite corners
    assert crossings(corners, [corners[k] for k in (1, 0, 2, 3)]) == 1
    # the same spot of the floor, but one is there at 0.9 of its way and the other at 0.1
    assert crossings([(0.0, 0.0), (0.83, -0.05)], [(1.0, 0.0), (1.53, 0.45)]) == 0
    assert crossings([], []) == 0


def test_a_row_takes_its_places_side_by_side() -> None:
    row = tuple((-0.3, y) for y in (0.45, 0.15, -0.15, -0.45))
    assert rearranged(row, line(4, 0.2)) == ((0.0, 0.4), (0.0, 0.2), (0.0, -0.2), (0.0, -0.4))


@given(tasks(POINT, 7), st.data())
def test_bound_robots_keep_their_places_and_the_others_share_the_rest(
    task: tuple[Places, Places], data: st.DataObject
) -> None:
    starts, places = task
    n = len(places)
    robots = data.draw(st.lists(st.integers(0, n - 1), unique=True))
    held = data.draw(st.permutations(range(n)))[: len(robots)]
    bound = dict(zip(robots, held, strict=True))
    positions = {k: p for k, p in enumerate(starts) if k not in bound or k % 2}
    result = assigned(positions, places, bound)
    assert sorted(result, key=int) == list(range(n))
    assert all(result[place] == robot for robot, place in bound.items())
    free = [k for k in range(n) if k not in bound]
    rest = tuple(places[k] for k in range(n) if k not in held)
    alone = rearranged(tuple(starts[k] for k in free), rest)
    assert [places[result.index(k)] for k in free] == list(alone)


@given(st.builds(Pose2D, COORDINATE, COORDINATE, st.floats(-3, 3)), POINT, st.floats(-3, 3))
def test_positions_are_camera_points_in_the_leader_s_frame(
    leader: Pose2D, axle: Vector2, theta: float
) -> None:
    seen = positions_about(leader, {7: Pose2D(*axle, theta)}, 0.05)
    x, y = axle[0] + 0.05 * cos(theta) - leader.x, axle[1] + 0.05 * sin(theta) - leader.y
    c, s = cos(leader.theta), sin(leader.theta)
    assert dist(seen[7], (c * x + s * y, c * y - s * x)) < 1e-9


def test_what_is_refused() -> None:
    places, at = wedge(2, 0.2), {1: (0.0, 0.1), 2: (0.0, -0.1)}
    for positions, bound, message in (
        ({1: (0.0, 0.1)}, {}, "2 places for 1 followers, 0 of them bound"),
        (at, {3: 0}, "2 places for 3 followers, 1 of them bound"),
        (at, {1: 2}, r"bound to places \[2\], there are 0 to 1"),
        (at, {1: -1}, r"bound to places \[-1\]"),
        ({}, {1: 0, 2: 0}, r"more than one robot: \[0\]"),
        ({1: (0.0, float("nan")), 2: (0.0, 0.0)}, {}, "positions and places: not finite: 0, nan"),
    ):
        with pytest.raises(ControlError, match=message):
            assigned(positions, places, bound)
    with pytest.raises(ControlError, match="as many ends as starts, got 1 and 2"):
        crossings([(0.0, 0.0), (1.0, 0.0)], [(0.0, 0.0)])
