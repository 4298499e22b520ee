"""A board in a picture: its corners to a fraction of a pixel, and how sharp they are."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.calibration.board import Board
from vision.calibration.corner import fit_corners

Floats = NDArray[np.float64]
Grey = NDArray[np.uint8]

_LEAST_CORNERS = 6
_LEAST_SEEN = 4  # corners that must be read before the others are looked for
_SMALL_MARKER_PX = 24.0  # below this the marker search looks at an enlarged picture
_CHECK = cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_ACCURACY
_PROFILE = 25  # samples across an edge
_REACH = 0.4  # of a profile to either side, in squares


@dataclass(frozen=True, slots=True)
class BoardView:
    """One picture of a board.

    Attributes:
        name: of the picture, for messages.
        size_px: width and height of the picture [px].
        ids: shape (N,), which of the board's corners were found, ascending, read-only.
        pixels: shape (N, 2), where they are [px], read-only.
        blur_px: how wide the edges between squares are, from 12 % to 88 % [px].
    """

    name: str
    size_px: tuple[int, int]
    ids: NDArray[np.intp]
    pixels: Floats
    blur_px: float

    def points(self, board: Board) -> Floats:
        """The corners on the board.

        Args:
            board: that was seen.

        Returns:
            Shape (N, 3), in the board's frame [m].
        """
        return board.corners[self.ids]

    def at(self, kept: NDArray[np.bool_]) -> "BoardView":
        """The same picture with some of its corners.

        Args:
            kept: shape (N,), which corners stay.

        Returns:
            The smaller view.
        """
        return make_view(self.name, self.size_px, self.ids[kept], self.pixels[kept], self.blur_px)


def make_view(
    name: str, size_px: tuple[int, int], ids: NDArray[np.intp], pixels: Floats, blur_px: float
) -> BoardView:
    """Put a view together, its arrays copied and read-only.

    Args:
        name: of the picture.
        size_px: width and height of the picture [px].
        ids: shape (N,), which corners.
        pixels: shape (N, 2), where they are [px].
        blur_px: width of the edges [px].

    Returns:
        The view.
    """
    order = np.argsort(ids, kind="stable")
    ids, pixels = np.array(ids[order], np.intp), np.array(pixels[order], np.float64)
    ids.flags.writeable = pixels.flags.writeable = False
    return BoardView(name, size_px, ids, pixels, blur_px)


def find_board(
    image: NDArray[np.uint8], board: Board, name: str = "picture", thorough: bool = True
) -> BoardView | str:
    """Look for a board.

    Args:
        image: shape (H, W, 3), BGR.
        board: to look for.
        name: of the picture, for messages.
        thorough: take the time that a chessboard in a difficult picture needs.

    Returns:
        Its corners; or, where it is not found, one sentence that says what is there instead.
    """
    grey: Grey = np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), np.uint8)
    search = _find_markers if board.kind == "charuco" else _find_squares
    found = search(grey, board, thorough)
    if isinstance(found, str):
        return found
    ids, pixels = found
    size = grey.shape[1], grey.shape[0]
    inside = (np.abs(pixels / np.subtract(size, 1) - 0.5) < 0.5).all(axis=1)
    ids, pixels = ids[inside], pixels[inside]
    ids, pixels = _refined(grey, board, ids, pixels)
    if len(ids) < _LEAST_CORNERS or _on_one_line(board.corners[ids, :2]):
        return f"{len(ids)} corners of the board are seen, too few or on one line"
    return make_view(name, size, ids, pixels, _edge_width(grey, board, ids, pixels))


def _on_one_line(points: Floats) -> bool:
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(spread[1] < 1e-6 * max(spread[0], 1e-12))


def _find_squares(
    grey: Grey, board: Board, thorough: bool
) -> tuple[NDArray[np.intp], Floats] | str:
    """All corners of a chessboard, the first one beside the black square at the top left."""
    shape = (board.columns - 1, board.rows - 1)
    flags = _CHECK | (cv2.CALIB_CB_EXHAUSTIVE if thorough else 0)
    found, corners = cv2.findChessboardCornersSB(grey, shape, flags=flags)
    if not found:
        return f"no chessboard of {board.columns} x {board.rows} squares is seen whole"
    grid = np.asarray(corners, np.float64).reshape(shape[1], shape[0], 2)
    across, down = grid[0, -1] - grid[0, 0], grid[-1, 0] - grid[0, 0]
    if across[0] * down[1] - across[1] * down[0] < 0.0:
        grid = grid[:, ::-1]
    if _first_square_is_white(grey, grid):
        grid = grid[::-1, ::-1]
    return np.arange(board.columns * board.rows)[: shape[0] * shape[1]], grid.reshape(-1, 2)


def _first_square_is_white(grey: Grey, grid: Floats) -> bool:
    """Whether the square between the first four corners is brighter than its neighbour."""
    middles = [grid[:2, i : i + 2].mean(axis=(0, 1)) for i in (0, 1)]
    x, y = np.rint(np.transpose(middles)).astype(int)
    own, next_one = grey[y, x]
    return bool(own > next_one)


def _find_markers(grey: Grey, board: Board, _: bool) -> tuple[NDArray[np.intp], Floats] | str:
    """Corners between markers that were read; smaller markers are looked for enlarged."""
    best: tuple[NDArray[np.intp], Floats] | None = None
    markers, side = _detected(grey, board, 1)
    if markers:
        best = markers
    if side < _SMALL_MARKER_PX:
        larger, more = _detected(grey, board, 2)
        side = max(side, more)
        if larger and (best is None or len(larger[0]) > len(best[0])):
            best = larger
    if best is not None:
        return best
    if side > 0.0:
        return (
            f"markers are seen, but not as a board of {board.columns} x {board.rows} squares with "
            f"dictionary {board.dictionary} has them"
        )
    return f"no marker of dictionary {board.dictionary} is seen"


def _detected(
    grey: Grey, board: Board, zoom: int
) -> tuple[tuple[NDArray[np.intp], Floats] | None, float]:
    """Corners in the enlarged picture, in pixels of the picture; and the markers' median side."""
    large = cv2.resize(grey, None, fx=zoom, fy=zoom, interpolation=cv2.INTER_CUBIC)
    parameters = cv2.aruco.DetectorParameters()
    parameters.minMarkerPerimeterRate = 0.01
    detector = cv2.aruco.CharucoDetector(
        board.opencv_board(), detectorParams=parameters, charucoParams=_any_marker()
    )
    corners, ids, markers, _ = detector.detectBoard(large)
    sides = [float(np.ptp(m.reshape(4, 2), axis=0).mean()) for m in markers or ()]
    side = float(np.median(sides)) / zoom if sides else 0.0
    if ids is None or len(ids) == 0:
        return None, side
    pixels = (np.asarray(corners, np.float64).reshape(-1, 2) + 0.5) / zoom - 0.5
    return (np.asarray(ids, np.intp).ravel(), pixels), side


def _any_marker() -> cv2.aruco.CharucoParameters:
    """A corner counts when one of its two markers was read: boards reach out of the picture."""
    parameters = cv2.aruco.CharucoParameters()
    parameters.minMarkers = 1
    return parameters


def _refined(
    grey: Grey, board: Board, ids: NDArray[np.intp], pixels: Floats
) -> tuple[NDArray[np.intp], Floats]:
    """Corners fitted to the pixels; those that the edges do not support are dropped.

    Corners whose markers could not be read are looked for where the others put them.
    """
    gap = 0.5 * (board.square - board.marker) / board.square if board.kind == "charuco" else 1.0
    every = np.arange(len(board.corners))
    for missing in (every[:0], np.setdiff1d(every, ids)):
        if len(ids) < _LEAST_SEEN or _on_one_line(board.corners[ids, :2]):
            return ids[:0], pixels[:0]
        matrix = np.asarray(cv2.findHomography(board.corners[ids, :2], pixels)[0], np.float64)
        ids = np.concatenate((ids, missing))
        guesses, slopes = _predicted(matrix, board.corners[ids, :2])
        guesses[: len(pixels)] = pixels
        near = (np.abs(guesses / (grey.shape[1], grey.shape[0]) - 0.5) < 0.5).all(axis=1)
        ids, guesses, slopes = ids[near], guesses[near], slopes[near]
        pixels, good = fit_corners(grey, guesses, board.square * slopes, gap)
        ids, pixels = ids[good], pixels[good]
    return ids, pixels


def _predicted(matrix: Floats, points: Floats) -> tuple[Floats, Floats]:
    """Pixels of a homography at points (N, 2), and derivatives (N, 2, 2) along x and down y."""
    lifted = np.column_stack((points, np.ones(len(points)))) @ matrix.T
    pixel = lifted[:, :2] / lifted[:, 2:]
    slope = (matrix[:2, :2] - pixel[:, :, None] * matrix[2, :2]) / lifted[:, 2:, None]
    return pixel, slope * (1.0, -1.0)


def _neighbours(
    board: Board, ids: NDArray[np.intp]
) -> tuple[tuple[NDArray[np.intp], NDArray[np.intp]], ...]:
    """Pairs of corners next to each other along rows and along columns, as indices into ids."""
    width = board.columns - 1
    place = np.full(width * (board.rows - 1), -1, np.intp)
    place[ids] = np.arange(len(ids))
    grid = place.reshape(board.rows - 1, width)
    pairs = (grid[:, :-1], grid[:, 1:]), (grid[:-1], grid[1:])
    both = [(a[(a >= 0) & (b >= 0)], b[(a >= 0) & (b >= 0)]) for a, b in pairs]
    return both[0], both[1]


def _edge_width(grey: Grey, board: Board, ids: NDArray[np.intp], pixels: Floats) -> float:
    """Contrast of the edges between corners by their steepest slope, the worse direction [px]."""
    widths = [
        _profile_width(grey, pixels[a], pixels[b])
        for a, b in _neighbours(board, ids)
        if len(a) >= 2
    ]
    return max(widths, default=float("inf"))


def _profile_width(grey: Grey, first: Floats, second: Floats) -> float:
    """Median width of the edges from first to second corners, (N, 2) each [px]."""
    way = second - first
    across = np.column_stack((-way[:, 1], way[:, 0]))
    along = np.linspace(-_REACH, _REACH, _PROFILE)
    places = 0.5 * (first + second)[:, None] + along[None, :, None] * across[:, None]
    places = places.astype(np.float32)
    values = cv2.remap(grey, places[..., 0], places[..., 1], cv2.INTER_LINEAR).astype(np.float64)
    step = np.linalg.norm(way, axis=1) * (along[1] - along[0])
    contrast = np.ptp(np.median(values, axis=1, keepdims=True) - values, axis=1)
    slope = np.abs(np.diff(values, axis=1)).max(axis=1) / step
    return float(np.median(contrast / np.maximum(slope, 1e-9)))
