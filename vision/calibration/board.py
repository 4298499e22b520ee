"""The boards that a camera is calibrated with: a chessboard, or one with markers in its squares.

Frame of a board: the origin is the lower left corner of its squares, x to the right along a row,
y up the page, z out of the page; lying on the floor, the board is a floor frame. The board is held
so that its top left square is black; boards of an even number of columns plus rows look the same
upside down, unless they have markers.
"""

from dataclasses import dataclass
from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.errors import VisionError

Floats = NDArray[np.float64]
Kind = Literal["charuco", "chessboard"]

DICTIONARIES = ("4x4_50", "4x4_100", "4x4_250", "5x5_100", "5x5_250", "6x6_250", "7x7_250")
_LEAST_SQUARES, _MOST_SQUARES, _LEAST_CORNERS = 3, 60, 6


@dataclass(frozen=True, slots=True)
class Board:
    """A flat board of black and white squares.

    Attributes:
        kind: "charuco" (markers in the white squares) or "chessboard".
        columns: squares in a row.
        rows: rows of squares.
        square: side of a square [m].
        marker: side of a marker [m]; of no meaning on a chessboard.
        dictionary: of the markers, e.g. "4x4_100"; of no meaning on a chessboard.
        legacy: whether markers lie as OpenCV printed them before version 4.6.

    Raises:
        VisionError: if there can be no such board.
    """

    kind: Kind = "charuco"
    columns: int = 8
    rows: int = 5
    square: float = 0.035
    marker: float = 0.025
    dictionary: str = "4x4_100"
    legacy: bool = False

    def __post_init__(self) -> None:
        named = f"board of {self.columns} x {self.rows} squares"
        if not _LEAST_SQUARES <= min(self.columns, self.rows) <= _MOST_SQUARES >= self.columns:
            raise VisionError(f"{named}: need {_LEAST_SQUARES} to {_MOST_SQUARES} either way")
        if (self.columns - 1) * (self.rows - 1) < _LEAST_CORNERS:
            raise VisionError(f"{named}: has fewer than {_LEAST_CORNERS} inner corners")
        if not 0.0 < self.square < 10.0:
            raise VisionError(f"{named}: a square of {1e3 * self.square:g} mm")
        if self.kind == "charuco" and not 0.0 < self.marker < self.square:
            raise VisionError(
                f"{named}: markers of {1e3 * self.marker:g} mm do not fit into squares of "
                f"{1e3 * self.square:g} mm"
            )
        self._check_dictionary()

    def _check_dictionary(self) -> None:
        if self.dictionary not in DICTIONARIES:
            known = ", ".join(DICTIONARIES)
            raise VisionError(f'board: no dictionary "{self.dictionary}"; there are: {known}')
        needed, there = self.columns * self.rows // 2, int(self.dictionary.split("_")[1])
        if self.kind == "charuco" and needed > there:
            raise VisionError(
                f"board of {self.columns} x {self.rows} squares: needs {needed} markers, "
                f"dictionary {self.dictionary} has {there}"
            )

    @property
    def size(self) -> tuple[float, float]:
        """Width and height of the squares together [m]."""
        return self.columns * self.square, self.rows * self.square

    @property
    def upside_down_twin(self) -> bool:
        """Whether the board looks the same turned by 180 degrees."""
        return self.kind == "chessboard" and (self.columns + self.rows) % 2 == 0

    @property
    def corners(self) -> Floats:
        """Inner corners, row by row from the top left, shape (N, 3), z = 0 [m]."""
        i, j = np.meshgrid(np.arange(1, self.columns), np.arange(1, self.rows))
        x, y = i.reshape(-1) * self.square, (self.rows - j.reshape(-1)) * self.square
        return np.column_stack((x, y, np.zeros(x.size)))

    def black_cells(self) -> Floats:
        """What is printed black: disjoint rectangles.

        Returns:
            Corners, counter-clockwise, shape (M, 4, 2), in the board's frame [m].
        """
        i, j = np.meshgrid(np.arange(self.columns), np.arange(self.rows))
        black = (i + j) % 2 == (self.legacy and self.rows % 2 == 0)
        low = np.column_stack((i[black], self.rows - 1 - j[black])) * self.square
        cells = [_rectangles(low, self.square)]
        if self.kind == "charuco":
            cells += self._markers()
        return np.concatenate(cells)

    def _markers(self) -> list[Floats]:
        """The black cells of every marker."""
        board, found = self.opencv_board(), []
        dictionary = board.getDictionary()
        bits = dictionary.markerSize + 2
        cell = self.marker / bits
        for marker, corners in zip(board.getIds().ravel(), board.getObjPoints(), strict=True):
            top_left = np.array((corners[0, 0], self.rows * self.square - corners[0, 1]))
            picture = cv2.aruco.generateImageMarker(dictionary, int(marker), bits)
            row, column = np.nonzero(picture == 0)
            found.append(_rectangles(top_left + np.column_stack((column, -row - 1)) * cell, cell))
        return found

    def opencv_board(self) -> Any:
        """The same board as OpenCV describes it: y down the page.

        Returns:
            A `cv2.aruco.CharucoBoard`.
        """
        name = f"DICT_{self.dictionary.upper()}"
        dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, name))
        size = (self.columns, self.rows)
        board = cv2.aruco.CharucoBoard(size, self.square, self.marker, dictionary)
        board.setLegacyPattern(self.legacy)
        return board


def _rectangles(low: Floats, side: float) -> Floats:
    """Squares from their lower left corners (M, 2), shape (M, 4, 2)."""
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    return low[:, None] + side * square
