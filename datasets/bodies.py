"""Distances between robot bodies: squares of known side, turned as the robots are."""

from collections.abc import Iterable, Sequence
from itertools import combinations
from math import hypot, inf, sqrt

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_CORNERS = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])


def square_gaps(first: Floats, second: Floats, sides: Floats) -> Floats:
    """Separation of two turned squares, for many moments or pairs at once.

    Args:
        first: shape (..., 3), poses of the first body [m, m, rad].
        second: shape (..., 3), poses of the second body [m, m, rad].
        sides: shape (..., 2) or (2,), sides of both bodies [m].

    Returns:
        Distance between the bodies, shape (...); negative where they overlap: minus the shortest
        way that would part them [m].
    """
    halves = np.broadcast_to(0.5 * np.asarray(sides), (*first.shape[:-1], 2))
    ahead = _seen_from(second, halves[..., 1], first)
    back = _seen_from(first, halves[..., 0], second)
    gap, reach = _gap_and_reach(ahead, halves[..., 0])
    other_gap, other_reach = _gap_and_reach(back, halves[..., 1])
    separation = np.maximum(gap, other_gap)  # > 0 on some axis: apart
    distance: Floats = np.where(separation > 0.0, np.minimum(reach, other_reach), separation)
    return distance


def pair_gaps(poses: Floats, sides: Floats) -> Floats:
    """Separation of every pair of robots.

    Args:
        poses: shape (..., R, 3), poses of R robots [m, m, rad].
        sides: shape (R,), sides of their square bodies [m].

    Returns:
        Distances, shape (..., R (R - 1) / 2), in the order of `pair_indices`; negative where
        bodies overlap [m].
    """
    first, second = pair_indices(len(sides))
    both = np.column_stack((sides[first], sides[second]))
    return square_gaps(poses[..., first, :], poses[..., second, :], both)


def least_gap(states: Iterable[Sequence[float]], side: float, below: float = inf) -> float:
    """Least separation of equal bodies at one moment, where it is less than was known.

    Args:
        states: of R bodies, x, y, theta and more of each, NaN where unknown [m, m, rad].
        side: of the square bodies [m].
        below: the least so far [m].

    Returns:
        The distance, `below` if none is less; most bodies are too far apart to look closely [m].
    """
    reach = below + sqrt(2.0) * side
    near = [
        (one[:3], other[:3])
        for one, other in combinations(states, 2)
        if hypot(one[0] - other[0], one[1] - other[1]) < reach
    ]
    if not near:
        return below
    first, second = np.array(near).transpose(1, 0, 2)
    return min(below, float(square_gaps(first, second, np.full(2, side)).min()))


def pair_indices(count: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The pairs of a number of robots.

    Args:
        count: number of robots.

    Returns:
        Indices of the first and of the second robot of every pair, two arrays (P,).
    """
    first, second = np.triu_indices(count, k=1)
    return first, second


def _seen_from(body: Floats, half: Floats, frame: Floats) -> Floats:
    """Corners of a body in another body's frame, shape (..., 4, 2)."""
    turn = body[..., 2] - frame[..., 2]
    c, s = np.cos(turn), np.sin(turn)
    cf, sf = np.cos(frame[..., 2]), np.sin(frame[..., 2])
    dx, dy = body[..., 0] - frame[..., 0], body[..., 1] - frame[..., 1]
    corners = np.broadcast_to(_CORNERS, (*half.shape, 4, 2)) * half[..., None, None]
    x, y = corners[..., 0], corners[..., 1]
    return np.stack(
        (
            (cf * dx + sf * dy)[..., None] + c[..., None] * x - s[..., None] * y,
            (cf * dy - sf * dx)[..., None] + s[..., None] * x + c[..., None] * y,
        ),
        axis=-1,
    )


def _gap_and_reach(corners: Floats, half: Floats) -> tuple[Floats, Floats]:
    """Largest gap along the axes of a box, and least distance of corners (..., 4, 2) to it."""
    low, high = corners.min(axis=-2), corners.max(axis=-2)
    gaps = np.maximum(low, -high) - half[..., None]
    outside = np.maximum(np.abs(corners) - half[..., None, None], 0.0)
    reach = np.hypot(outside[..., 0], outside[..., 1]).min(axis=-1)
    return gaps.max(axis=-1), reach
