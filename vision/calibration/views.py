"""Which views of a board are worth having: spread over the image, different from each other."""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.calibration.detect import BoardView

Floats = NDArray[np.float64]

LEAST_VIEWS = 6
LEAST_HULL = 0.35  # of the image, around all corners
CROWD = 0.6  # share of all corners in one of nine regions that counts as a cluster
DIFFERENT = 0.04  # mean motion of the corners between different views, of the image's width
_ROWS = ("top", "middle", "bottom")
_COLUMNS = ("left", "centre", "right")


def region_counts(views: Sequence[BoardView], size_px: tuple[int, int]) -> NDArray[np.intp]:
    """Count corners in nine regions of the image.

    Args:
        views: what was seen.
        size_px: width and height of the image [px].

    Returns:
        Shape (3, 3), rows from the top.
    """
    counts = np.zeros((3, 3), np.intp)
    for view in views:
        cell = np.clip((view.pixels + 0.5) * 3.0 / size_px, 0, 2).astype(np.intp)
        np.add.at(counts, (cell[:, 1], cell[:, 0]), 1)
    return counts


def region_name(row: int, column: int) -> str:
    """Name one of nine regions.

    Args:
        row: 0 at the top.
        column: 0 at the left.

    Returns:
        For example "top left".
    """
    if row == 1 and column == 1:
        return "the centre"
    return f"{_ROWS[row]} {_COLUMNS[column]}"


def lacking_regions(views: Sequence[BoardView], size_px: tuple[int, int]) -> tuple[str, ...]:
    """Name the regions with hardly a corner.

    Args:
        views: what was seen.
        size_px: width and height of the image [px].

    Returns:
        Names, from the top left; a region lacks corners below a tenth of an equal share.
    """
    counts = region_counts(views, size_px)
    few = counts < max(4.0, counts.sum() / 90.0)
    return tuple(region_name(row, column) for row, column in np.argwhere(few).tolist())


def hull_share(views: Sequence[BoardView], size_px: tuple[int, int]) -> float:
    """Share of the image inside the convex hull of all corners.

    Args:
        views: what was seen, at least one.
        size_px: width and height of the image [px].

    Returns:
        0 to 1.
    """
    corners = np.vstack([view.pixels for view in views]).astype(np.float32)
    return float(cv2.contourArea(cv2.convexHull(corners))) / (size_px[0] * size_px[1])


def motion(one: BoardView, other: BoardView) -> float:
    """How far the corners moved from one view to another.

    Args:
        one: a view.
        other: of the same size.

    Returns:
        Mean distance of common corners as a share of the image's width; infinite if there are
        fewer than four.
    """
    _, a, b = np.intersect1d(one.ids, other.ids, return_indices=True)
    if len(a) < 4:
        return float("inf")
    way = np.linalg.norm(one.pixels[a] - other.pixels[b], axis=1)
    return float(way.mean()) / one.size_px[0]


def different_views(views: Sequence[BoardView]) -> tuple[BoardView, ...]:
    """Leave out views that show what an earlier one shows.

    Args:
        views: in order of preference.

    Returns:
        Those that differ from all before them.
    """
    kept: list[BoardView] = []
    for view in views:
        if all(motion(view, other) >= DIFFERENT for other in kept):
            kept.append(view)
    return tuple(kept)


def complaints(views: Sequence[BoardView], size_px: tuple[int, int]) -> list[str]:
    """Say why a set of views cannot give a lens, before anything is fitted.

    Args:
        views: what was seen.
        size_px: width and height of the image [px].

    Returns:
        Sentences with numbers and remedies; none if the set may do.
    """
    if len(views) < LEAST_VIEWS:
        return [
            f"{len(views)} views show the board, {LEAST_VIEWS} are needed and 15 are good: "
            "take more pictures"
        ]
    different = len(different_views(views))
    found = [_crowded(views, size_px), _small(views, size_px)]
    if different < LEAST_VIEWS:
        found.append(
            f"of {len(views)} views only {different} differ ({LEAST_VIEWS} needed): move and tilt "
            "the board between pictures"
        )
    return [sentence for sentence in found if sentence]


def _small(views: Sequence[BoardView], size_px: tuple[int, int]) -> str:
    """Whether the corners leave too much of the image empty."""
    share = hull_share(views, size_px)
    if share >= LEAST_HULL:
        return ""
    lacking = ", ".join(lacking_regions(views, size_px)) or "none"
    return (
        f"the board covers {100 * share:.0f} % of the image ({100 * LEAST_HULL:.0f} % needed); "
        f"regions without corners: {lacking}: show it there, or closer"
    )


def _crowded(views: Sequence[BoardView], size_px: tuple[int, int]) -> str:
    """Whether most corners are in one place."""
    counts = region_counts(views, size_px)
    if counts.max() <= CROWD * counts.sum():
        return ""
    row, column = divmod(int(counts.argmax()), 3)
    return (
        f"{100 * counts.max() / counts.sum():.0f} % of the corners are in one ninth of the image, "
        f"{region_name(row, column)}: show the board elsewhere, too"
    )
