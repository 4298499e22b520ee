"""From the class image to blobs: connected regions of one colour, with sub-pixel centres."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Classes = NDArray[np.uint8]
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


def find_blobs(classes: Classes, min_area: float, limit: int) -> Blobs:
    """Find the connected regions of every colour class.

    Args:
        classes: shape (H, W), 0 for nothing.
        min_area: smaller blobs are left out [px].
        limit: at most so many blobs, the largest.

    Returns:
        The blobs, largest first.
    """
    at = nonzero_indices(classes)
    if len(at) == 0:
        return Blobs(np.zeros(0, np.intp), np.zeros((0, 2)), np.zeros(0))
    labels = _labels(classes, at).ravel()[at].astype(np.intp)
    y, x = np.divmod(at, classes.shape[1])
    areas = np.bincount(labels).astype(np.float64)
    areas[0] = 0.0  # pixels between two colours, left out by _labels
    keep = np.flatnonzero(areas >= min_area)
    keep = keep[np.argsort(-areas[keep], kind="stable")]
    kept = keep[:limit]
    sums = np.column_stack((np.bincount(labels, x), np.bincount(labels, y)))
    class_of = np.zeros(len(areas), np.intp)
    class_of[labels] = classes.ravel()[at]
    centers = sums[kept] / areas[kept, None]
    return Blobs(class_of[kept], centers, areas[kept], len(keep) - len(kept))


def nonzero_indices(classes: Classes) -> Indices:
    """List the pixels that have a class, quickly where they are few.

    Args:
        classes: shape (H, W), contiguous.

    Returns:
        Flat indices in ascending order, shape (N,).
    """
    flat = classes.reshape(-1)
    whole = len(flat) // 8 * 8
    words = np.flatnonzero(flat[:whole].view(np.uint64)) * 8
    at = (words[:, None] + np.arange(8)).reshape(-1)
    at = np.concatenate((at, np.arange(whole, len(flat))))
    found: Indices = at[flat[at] != 0]
    return found


def _labels(classes: Classes, at: Indices) -> NDArray[np.integer]:
    """Label the regions in one pass: pixels that touch another colour above or left are cut out."""
    flat = classes.reshape(-1)
    own, left, above = flat[at], flat[at - 1], flat[at - classes.shape[1]]
    clash = ((left != 0) & (left != own)) | ((above != 0) & (above != own))
    cut = at[clash]
    mask = classes
    if len(cut):
        mask = classes.copy()
        mask.reshape(-1)[cut] = 0
    small = classes.size < 2**17  # a checkerboard has half as many regions as pixels
    ltype = cv2.CV_16U if small else cv2.CV_32S
    return np.asarray(cv2.connectedComponents(mask, connectivity=4, ltype=ltype)[1])
