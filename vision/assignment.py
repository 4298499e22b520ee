"""Who is who: every candidate at most one robot, every robot and every place at most once."""

import numpy as np
import scipy
from numpy.typing import NDArray

from vision.compiled import compiled, compiled_part

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
Flags = NDArray[np.bool_]

REPEATED, NOBODY = -1, -2
"""What stands for the tag of a candidate that repeats a better one; of one that is nobody."""

_LEAST = 1e-12  # of a score, so that its logarithm is finite


def settle(
    scores: Floats, good: Flags, misfits: Floats, poses: Floats, taken: Floats, nearest: float
) -> Indices:
    """Pair candidates and tags so that the product of their scores is largest.

    Args:
        scores: shape (N, T), probabilities.
        good: shape (N,), which candidates can be somebody.
        misfits: shape (N,): of overlapping candidates the one that fits best counts, good before
            others.
        poses: shape (N, 3), of which x and y count [m].
        taken: shape (M, 2), places of robots already found [m].
        nearest: least distance of two robots [m].

    Returns:
        Index of the tag of every candidate, `REPEATED` or `NOBODY`, shape (N,).
    """
    tags = np.empty(len(scores), np.intp)
    if _wish(scores, good, misfits, poses, taken, nearest, tags):
        rows = np.flatnonzero(tags >= 0)
        worth = -np.log(np.maximum(scores[rows], _LEAST))
        chosen, columns = scipy.optimize.linear_sum_assignment(worth)
        tags[rows] = NOBODY
        tags[rows[chosen]] = columns
    return tags


@compiled
def all_sure(scores: Floats, tags: Indices, confidence: float) -> bool:
    """Tell whether every candidate has a tag that it looks like.

    Args:
        scores: shape (N, T), probabilities.
        tags: shape (N,), index of the tag of every candidate, negative for none.
        confidence: least probability.

    Returns:
        Whether it has.
    """
    sure = True
    for n in range(len(tags)):
        sure = sure and tags[n] >= 0 and scores[n, tags[n]] >= confidence
    return sure


@compiled
def _wish(
    scores: Floats, good: Flags, misfits: Floats, poses: Floats, taken: Floats, nearest: float,
    tags: Indices,
) -> bool:  # fmt: skip
    """Give good candidates the tags they look like most; whether two want the same."""
    tags[:] = NOBODY
    order = np.argsort(misfits, kind="mergesort")
    _drop_repeated(
        np.concatenate((order[good[order]], order[~good[order]])), poses, taken, nearest, tags
    )
    wanted = np.zeros(scores.shape[1], np.bool_)
    contested = False
    for n in range(len(scores)):
        if good[n] and tags[n] == NOBODY:
            tags[n] = scores[n].argmax()
            contested = contested or wanted[tags[n]]
            wanted[tags[n]] = True
    return contested


@compiled_part
def _drop_repeated(
    order: Indices, poses: Floats, taken: Floats, nearest: float, tags: Indices
) -> None:
    """Mark candidates that overlap a better one, or a robot already found."""
    for rank in range(len(order)):
        n = order[rank]
        for x, y in taken:
            if np.hypot(poses[n, 0] - x, poses[n, 1] - y) < nearest:
                tags[n] = REPEATED
        for before in order[:rank]:
            away = np.hypot(poses[n, 0] - poses[before, 0], poses[n, 1] - poses[before, 1])
            if tags[before] != REPEATED and away < nearest:
                tags[n] = REPEATED
