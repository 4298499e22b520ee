"""Printed codes as tags, so that the renderer draws them like all others: cells as polygons."""

from functools import cache
from itertools import groupby

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.field import SIDE
from vision.tags import Part, Tag, TagSet, polygon_array

ARUCO, APRILTAG = cv2.aruco.DICT_4X4_50, cv2.aruco.DICT_APRILTAG_36h11
_BITS = {ARUCO: 4, APRILTAG: 6}  # along a side; the black rim and the white one are 1 cell each


@cache
def printed(dictionary: int, count: int) -> TagSet:
    """Codes 1 to `count` on plates of 75 mm, their white rims included.

    Args:
        dictionary: `ARUCO` or `APRILTAG`.
        count: of robots.

    Returns:
        Their tags; the code's upper edge is in front.
    """
    tags = (_tag(dictionary, number) for number in range(1, count + 1))
    return TagSet(tuple(tags), mirror_twins=True)


def code_side(dictionary: int) -> float:
    """Side of the black square that detectors find.

    Args:
        dictionary: `ARUCO` or `APRILTAG`.

    Returns:
        The side [m].
    """
    cells = _BITS[dictionary] + 2
    return SIDE * cells / (cells + 2)


def _tag(dictionary: int, number: int) -> Tag:
    cells = _BITS[dictionary] + 2
    code = cv2.aruco.getPredefinedDictionary(dictionary)
    bits = np.asarray(cv2.aruco.generateImageMarker(code, number, cells), np.uint8) > 127
    half, rim = cells / 2.0 + 1.0, cells / 2.0
    parts = [_part("paper", (-half, half, -half, half), cells, "white")]
    parts += [_part("square", (-rim, rim, -rim, rim), cells, "black")]
    for row, values in enumerate(bits):
        for white, run in groupby(range(cells), key=values.__getitem__):
            first, *_, last = [*run] * 2
            if white:
                place = rim - row - 1, rim - row, rim - last - 1, rim - first
                parts.append(_part(f"{row}.{first}", place, cells, "white"))
    return Tag(number, tuple(parts))


def _part(name: str, place: tuple[float, ...], cells: int, color: str) -> Part:
    """A rectangle given as x0, x1 (forward), y0, y1 (left) in cells."""
    x0, x1, y0, y1 = np.array(place) * SIDE / (cells + 2)
    return Part(name, polygon_array([[x1, y1], [x0, y1], [x0, y0], [x1, y0]]), color)


def corners_to_poses(floor: NDArray[np.float64]) -> NDArray[np.float64]:
    """Poses of squares.

    Args:
        floor: shape (N, 4, 2), corners on the floor: front left, front right, rear right, rear
            left [m].

    Returns:
        Shape (N, 3), x, y, theta [m, m, rad].
    """
    ahead = floor[:, 0] + floor[:, 1] - floor[:, 2] - floor[:, 3]
    return np.column_stack((floor.mean(axis=1), np.arctan2(ahead[:, 1], ahead[:, 0])))
