"""First guesses for the planner: ways by arcs and straight lines, and round what is on them."""

from itertools import product
from math import atan2, cos, hypot, pi, sin

import numpy as np

from control.geometry import Pose2D
from control.motion_model import Array
from control.plan import PathSegment, PlannedPath
from control.plan_limits import Room

MOST_DETOURS = 3
"""A guess is led round at most so many obstacles, on either side of each."""

_CLOSED = 1e-6  # turns short of a whole one by less are none [rad]


def arc_ways(start: Pose2D, goal: Pose2D, radius: float) -> tuple[PlannedPath, ...]:
    """Ways of an arc, a straight line and an arc (Dubins), at 1 m/s.

    Args:
        start: pose at the start [m, m, rad].
        goal: pose at the end [m, m, rad].
        radius: of the arcs, > 0 [m].

    Returns:
        Up to four ways, the shortest first.
    """
    ways = (
        _arc_way(start, goal, radius, first, last) for first, last in product((1.0, -1.0), repeat=2)
    )
    return tuple(sorted((way for way in ways if way is not None), key=length))


def length(way: PlannedPath) -> float:
    """Length of all segments.

    Args:
        way: a path.

    Returns:
        Its length [m].
    """
    return sum(segment.length for segment in way.segments)


def driven(way: PlannedPath, shares: Array) -> Array:
    """Positions on a way that is driven at 1 m/s.

    Args:
        way: a path.
        shares: (n,) of its length [1].

    Returns:
        (2, n) positions [m].
    """
    states = [way.at(share * length(way)).state for share in shares.tolist()]
    return np.array([(state.x, state.y) for state in states]).T


def _arc_way(
    start: Pose2D, goal: Pose2D, radius: float, first: float, last: float
) -> PlannedPath | None:
    """The way with given turns, +1 to the left; None if the circles are too close."""
    dx = goal.x - start.x - radius * (last * sin(goal.theta) - first * sin(start.theta))
    dy = goal.y - start.y + radius * (last * cos(goal.theta) - first * cos(start.theta))
    across = radius * (first - last)  # 0, or 2 r to the side of the first turn
    apart = hypot(dx, dy)
    if apart < abs(across):
        return None
    straight = (apart**2 - across**2) ** 0.5
    middle = atan2(dy, dx) + atan2(across, straight)
    turns = first * (middle - start.theta), last * (goal.theta - middle)
    arc, end = (radius * ((turn + _CLOSED) % (2.0 * pi) - _CLOSED) for turn in turns)
    pieces = ((arc, first / radius), (straight, 0.0), (end, last / radius))
    segments = tuple(PathSegment(way, bend) for way, bend in pieces if way > 0.0)
    return PlannedPath(start, segments, 1.0, 1.0) if segments else None


def detours(points: Array, t: Array, around: Room) -> list[Array]:
    """Ways that pass every obstacle in the way on its left or on its right.

    Args:
        points: (2, n) a way that minds no obstacle [m].
        t: (n,) times along it [s].
        around: obstacles, inflated.

    Returns:
        (2, n) each; the way itself if it is free.
    """
    done: list[Array] = []
    open_ways: list[tuple[Array, frozenset[int]]] = [(points, frozenset())]
    while open_ways:
        way, passed = open_ways.pop()
        block = _deepest(way, t, around, passed) if len(passed) < MOST_DETOURS else None
        if block is None:
            done.append(way)
        else:
            aside = [_aside(way, t, around, block, side) for side in (1.0, -1.0)]
            open_ways += [(other, passed | {block}) for other in aside]
    return done


def _deepest(way: Array, t: Array, around: Room, passed: frozenset[int]) -> int | None:
    """The obstacle that a way cuts into deepest, without those already led round."""
    depth = around.reaches - np.hypot(*around.apart(way, t).transpose(1, 0, 2)).min(axis=1)
    depth[list(passed)] = -1.0
    return int(depth.argmax()) if (depth > 0.0).any() else None


def _aside(way: Array, t: Array, around: Room, block: int, side: float) -> Array:
    """A way pushed to one side of an obstacle, as seen from the obstacle; +1 to the left of it."""
    apart, reach = around.apart(way, t)[block], around.reaches[block]
    nearest = int(np.hypot(*apart).argmin())
    before, after = max(nearest - 1, 0), min(nearest + 1, len(t) - 1)
    drift = (apart[:, after] - apart[:, before]) / (t[after] - t[before])
    speed = float(np.hypot(*drift))
    normal = side * np.array([-drift[1], drift[0]]) / max(speed, 1e-9)
    push = 1.1 * reach - float(normal @ apart[:, nearest])
    bump = np.exp(-0.5 * ((t - t[nearest]) * speed / reach) ** 2)
    pushed: Array = way + push * bump * normal[:, None]
    return pushed
