"""Who is who: every candidate at most one robot, every robot and every place at most once."""

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from vision.compiled import compiled

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
Flags = NDArray[np.bool_]

REPEATED, NOBODY = -1, -2
"""What stands for the tag of a candidate that repeats a better one; of one that is nobody."""

_LEAST = 1e-12  # of a score, so that its logarithm is finite


def settle(
    scores: Floats, good: Flags, order: Indices, places: Floats, taken: Floats, nearest: float
) -> Indices:
    """Pair candidates and tags so that the product of their scores is largest.

    Args:
        scores: shape (N, T), probabilities.
        good: shape (N,), which candidates can be somebody.
        order: shape (N,), candidates, the best fitting first: of overlapping ones it counts.
        places: shape (N, 2), x, y [m].
        taken: shape (M, 2), places of robots already found [m].
        nearest: least distance of two robots [m].

    Returns:
        Index of the tag of every candidate, `REPEATED` or `NOBODY`, shape (N,).
    """
    tags = np.full(len(scores), NOBODY)
    _drop_repeated(order, places, taken, nearest, tags)
    rows = np.flatnonzero(good & (tags == NOBODY))
    best = scores[rows].argmax(axis=1)
    if len(set(best.tolist())) == len(rows):  # nobody wants what another wants
        tags[rows] = best
    else:
        chosen, columns = linear_sum_assignment(-np.log(np.maximum(scores[rows], _LEAST)))
        tags[rows[chosen]] = columns
    return tags


@compiled
def _drop_repeated(
    order: Indices, places: Floats, taken: Floats, nearest: float, tags: Indices
) -> None:
    """Mark candidates that overlap a better one, or a robot already found."""
    for rank in range(len(order)):
        n = order[rank]
        for x, y in taken:
            if np.hypot(places[n, 0] - x, places[n, 1] - y) < nearest:
                tags[n] = REPEATED
        for before in order[:rank]:
            away = np.hypot(places[n, 0] - places[before, 0], places[n, 1] - places[before, 1])
            if tags[before] != REPEATED and away < nearest:
                tags[n] = REPEATED
