"""Printed square markers (ArUco, AprilTag) as tags: white and black polygons from a dictionary."""

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from control.command import RobotId
from vision.errors import VisionError
from vision.tags import Part, Tag, TagSet, polygon_array

Cells = NDArray[np.bool_]

WHITE, BLACK = "white", "black"
_PREFIX = "DICT_"
_NUMBERS = {
    name.removeprefix(_PREFIX).lower(): getattr(cv2.aruco, name)
    for name in dir(cv2.aruco)
    if name.startswith(_PREFIX)
}


@dataclass(frozen=True, slots=True)
class MarkerSet:
    """Which marker of one dictionary each robot wears.

    Attributes:
        dictionary: e.g. "4x4_50" or "apriltag_36h11".
        side: of the black square [m].
        worn: pairs of a robot and the number of its marker.

    Raises:
        VisionError: if the dictionary or a number is unknown, or two robots wear the same marker.
    """

    dictionary: str
    side: float
    worn: tuple[tuple[RobotId, int], ...]

    def __post_init__(self) -> None:
        robots: dict[int, RobotId] = {}
        for robot_id, number in self.worn:
            marker_cells(self.dictionary, number)  # refuses unknown ones
            if number in robots:
                raise VisionError(
                    f"robots {robots[number]} and {robot_id} cannot be told apart: "
                    f"both wear marker {number}"
                )
            robots[number] = robot_id

    @property
    def tags(self) -> TagSet:
        """The markers as tags."""
        return _marker_tags(self.dictionary, self.side, self.worn)


def marker_dictionary(name: str) -> cv2.aruco.Dictionary:
    """Find a dictionary of markers.

    Args:
        name: e.g. "4x4_50" or "apriltag_36h11".

    Returns:
        OpenCV's dictionary.

    Raises:
        VisionError: if there is none of the name.
    """
    if name.lower() not in _NUMBERS:
        raise VisionError(
            f'no marker dictionary "{name}"; there are: {", ".join(sorted(_NUMBERS))}'
        )
    return cv2.aruco.getPredefinedDictionary(_NUMBERS[name.lower()])


def marker_cells(dictionary: str, number: int) -> Cells:
    """What a marker looks like.

    Args:
        dictionary: its name.
        number: of the marker.

    Returns:
        Shape (n, n), True where a cell is white, the black border of one cell included; the first
        row is the front.

    Raises:
        VisionError: if the dictionary or the number is unknown.
    """
    known = marker_dictionary(dictionary)
    count = len(known.bytesList)
    if not 0 <= number < count:
        raise VisionError(f"marker {number}: {dictionary} has markers 0 to {count - 1}")
    picture = known.generateImageMarker(number, known.markerSize + 2)
    return np.asarray(picture > 0)


def fitting_side(dictionary: str, plate: float) -> float:
    """How large a marker can be on a plate, with a white rim of one cell around it.

    Args:
        dictionary: its name.
        plate: side of the plate [m].

    Returns:
        Side of the black square [m].

    Raises:
        VisionError: if the dictionary is unknown.
    """
    cells = marker_dictionary(dictionary).markerSize + 2
    return plate * cells / (cells + 2)


@lru_cache(maxsize=8)
def _marker_tags(dictionary: str, side: float, worn: tuple[tuple[RobotId, int], ...]) -> TagSet:
    """Tags of markers; a marker is never read mirrored."""
    tags = (Tag(robot, _parts(marker_cells(dictionary, n), side)) for robot, n in worn)
    return TagSet(tuple(tags), (BLACK,), mirror_twins=True)


def _parts(cells: Cells, side: float) -> tuple[Part, ...]:
    """A white rim of one cell, the black square, and runs of white cells; forward is up."""
    count = len(cells)
    cell = side / count
    parts = [
        _part("rim", (-1, -1, count + 1, count + 1), WHITE, cell, count),
        _part("square", (0, 0, count, count), BLACK, cell, count),
    ]
    for row, line in enumerate(cells):
        edges = np.flatnonzero(np.diff(np.concatenate(((0,), line.astype(np.int8), (0,)))))
        parts += [
            _part(f"row {row} from {first}", (row, first, row + 1, end), WHITE, cell, count)
            for first, end in edges.reshape(-1, 2).tolist()
        ]
    return tuple(parts)


def _part(name: str, box: tuple[int, int, int, int], color: str, cell: float, count: int) -> Part:
    """A rectangle of cells from a row and a column to others."""
    top, left, bottom, right = box
    x0, x1, y0, y1 = (0.5 * count - edge for edge in (bottom, top, right, left))
    corners = cell * np.array([[x1, y1], [x0, y1], [x0, y0], [x1, y0]])
    return Part(name, polygon_array(corners), color)
