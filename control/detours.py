"""First guesses for the planner: ways by arcs and straight lines, and round what is on them."""

from itertools import product
from math import atan2, cos, hypot, pi, sin

import numpy as np

from control.geometry import Pose2D
from control.motion_model import Array
from control.obstacles import Obstacle
from control.plan import PathSegment, PlannedPath

_CLOSED = 1e-6  # turns short of a whole one by less are none [rad]


def arc_ways(start: Pose2D, goal: Pose2D, radius: float) -> list[PlannedPath]:
    """Ways of an arc, a straight line and an arc (Dubins), at 1 m/s.

    Args:
        start: pose at the start [m, m, rad].
        goal: pose at the end [m, m, rad].
        radius: of the arcs, > 0 [m].

    Returns:
        Two to four ways, the shortest first.
    """
    turns = product((1.0, -1.0), repeat=2)
    ways = [_arc_way(start, goal, radius, *pair) for pair in turns]
    return sorted((way for way in ways if way is not None), key=length)


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
    states = [way.at(share).state for share in (length(way) * shares).tolist()]
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
    return PlannedPath(start, segments, 1.0, 1.0)


def detours(way: Array, t: Array, obstacles: tuple[Obstacle, ...], most: int = 3) -> list[Array]:
    """Ways that pass every obstacle in the way on its left or on its right.

    Args:
        way: (2, n) that minds no obstacle [m].
        t: (n,) times along it [s].
        obstacles: inflated by the clearance.
        most: obstacles that are minded, the deepest in the way first.

    Returns:
        (2, n) each; the way itself if it is free.
    """
    depths = [o.radius - float(np.hypot(*o.apart(way, t)).min()) for o in obstacles]
    if most == 0 or max(depths, default=0.0) <= 0.0:
        return [way]
    block = obstacles[depths.index(max(depths))]
    others = tuple(o for o in obstacles if o is not block)
    asides = (_aside(way, t, block, side) for side in (1.0, -1.0))
    return [found for aside in asides for found in detours(aside, t, others, most - 1)]


def _aside(way: Array, t: Array, block: Obstacle, side: float) -> Array:
    """A way pushed to one side of an obstacle, as the obstacle sees it pass; +1 to the left."""
    apart = block.apart(way, t)
    nearest = int(np.hypot(*apart).argmin())
    before, after = max(nearest - 1, 0), min(nearest + 1, len(t) - 1)
    drift = (apart[:, after] - apart[:, before]) / (t[after] - t[before])
    speed = max(float(np.hypot(*drift)), 1e-9)
    normal = side * np.array([-drift[1], drift[0]]) / speed
    push = 1.1 * block.radius - float(normal @ apart[:, nearest])
    bump = np.exp(-0.5 * ((t - t[nearest]) * speed / block.radius) ** 2)
    pushed: Array = way + push * bump * normal[:, None]
    return pushed
