"""From pixels to blobs: connected regions of one colour, with sub-pixel centres, in one pass."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.compiled import compiled, compiled_part

Floats = NDArray[np.float64]
Bytes = NDArray[np.uint8]
Indices = NDArray[np.intp]


@dataclass(frozen=True, slots=True)
class Blobs:
    """Connected regions of one colour class.

    Attributes:
        classes: shape (B,), colour class.
        centers: shape (B, 2), x, y [px].
        areas: shape (B,) [px].
        dropped: how many more there were, all smaller, beyond the limit.
    """

    classes: NDArray[np.intp]
    centers: Floats
    areas: Floats
    dropped: int = 0

    def __len__(self) -> int:
        return len(self.areas)


def find_blobs(classes: Bytes, min_area: float, limit: int) -> Blobs:
    """Find the connected regions of every colour class.

    Args:
        classes: shape (H, W), 0 for nothing, contiguous.
        min_area: smaller blobs are left out [px].
        limit: at most so many blobs, the largest.

    Returns:
        The blobs, largest first.
    """
    flat = classes.reshape(-1)
    words = flat[: len(flat) // 8 * 8].view(np.uint64)
    most = int(np.count_nonzero(classes)) + 1
    sums, kinds = np.empty((most, 3)), np.empty(most, np.uint8)
    count = _label(classes, words, min_area, sums, kinds)
    largest = np.argsort(-sums[:count, 0], kind="stable")[:limit]
    kept, kind = sums[largest], kinds[largest].astype(np.intp)
    return Blobs(kind, kept[:, 1:] / kept[:, :1], kept[:, 0], count - len(kept))


@compiled
def _label(
    classes: Bytes, words: NDArray[np.uint64], min_area: float, sums: Floats, kinds: Bytes
) -> int:
    """Join runs of equal pixels with those above; returns the number of regions large enough.

    Regions that turn out to be one are joined by union-find: parent[label] <= label. Where there is
    nothing, 8 pixels are passed at a time.
    """
    rows, columns = classes.shape
    flat, parent = classes.reshape(-1), np.empty(len(kinds), np.int32)
    above, count = np.zeros(columns, np.int32), 0
    for row in range(rows):
        start = row * columns
        at, end = start, start + columns
        while at < end:
            if at % 8 == 0 and at + 8 <= end and words[at >> 3] == 0:
                at += 8
                continue
            kind, first, label = flat[at], at, -1
            if kind == 0:
                at += 1
                continue
            while at < end and flat[at] == kind:
                same = row > 0 and flat[at - columns] == kind
                if same and (at == first or flat[at - columns - 1] != kind):
                    other = _root(parent, above[at - start])
                    label = other if label < 0 else _joined(parent, label, other)
                at += 1
            if label < 0:
                label, parent[count], kinds[count] = count, count, kind
                sums[count, 0] = sums[count, 1] = sums[count, 2] = 0.0
                count += 1
            length = at - first
            above[first - start : at - start] = label
            sums[label, 0] += length
            sums[label, 1] += 0.5 * length * (first + at - 1 - 2 * start)
            sums[label, 2] += length * row
    return _compact(parent, min_area, sums, kinds, count)


@compiled_part
def _joined(parent: NDArray[np.int32], one: int, other: int) -> int:
    """Make one region of two; returns its label."""
    one = _root(parent, one)
    first, last = min(one, other), max(one, other)
    parent[last] = first
    return first


@compiled_part
def _root(parent: NDArray[np.int32], label: int) -> int:
    """Smallest label of a region; shortens the way to it."""
    root = label
    while parent[root] != root:
        root = parent[root]
    while parent[label] != root:
        parent[label], label = root, parent[label]
    return root


@compiled_part
def _compact(
    parent: NDArray[np.int32], min_area: float, sums: Floats, kinds: Bytes, count: int
) -> int:
    """Add up what belongs to one region, drop small ones; returns the number of the others."""
    for label in range(count):
        root = _root(parent, label)
        if root != label:
            for j in range(3):
                sums[root, j] += sums[label, j]
    regions = 0
    for label in range(count):
        if parent[label] == label and sums[label, 0] >= min_area:
            kinds[regions] = kinds[label]
            for j in range(3):
                sums[regions, j] = sums[label, j]
            regions += 1
    return regions
