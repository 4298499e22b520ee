"""The floor plane: from boards that lie on it, or from points at known places; and its errors."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import cos, sin

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.calibration.bundle import LENS, Fit, Problem, Seen, State, adjust, placed
from vision.calibration.lens import pose_of
from vision.camera import CameraModel

Floats = NDArray[np.float64]

_GRID = (13, 9)  # pixels at which the floor's error is worked out
_NO_LENS = np.zeros(LENS, np.bool_)


@dataclass(frozen=True, slots=True)
class FloorFrame:
    """Where the first board on the floor lies in the floor frame that is wanted.

    Attributes:
        x: of the board's origin [m].
        y: of the board's origin [m].
        turn: of the board's x axis, counter-clockwise as seen from above [rad].
        thickness: of the board: its upper face is so far above the floor [m].
    """

    x: float = 0.0
    y: float = 0.0
    turn: float = 0.0
    thickness: float = 0.0

    def points(self, on_board: Floats) -> Floats:
        """Give points of the board in the floor frame.

        Args:
            on_board: shape (N, 3) [m].

        Returns:
            Shape (N, 3) [m].
        """
        place = np.array((self.x, self.y, self.turn))
        lifted = placed(on_board, place)
        lifted[:, 2] += self.thickness
        return lifted


@dataclass(frozen=True, slots=True)
class FittedFloor:
    """The floor, and how well it is known.

    Attributes:
        pose: shape (6,), Rodrigues rotation [rad] and translation [m] of the floor frame in the
            camera's.
        covariance: shape (15, 15), of lens and pose together.
        errors: shape (N,), how far corners or points are off when they are measured with a floor
            that was fitted without them [m].
        rms_px: misfit of the views or points that gave it [px].
        views: how many views of a board gave it; 0 if points did.
    """

    pose: Floats
    covariance: Floats
    errors: Floats
    rms_px: float
    views: int


def camera_of(
    size_px: tuple[int, int], lens: Floats, floor: Floats, tag_height: float
) -> CameraModel:
    """The camera model of fitted numbers.

    Args:
        size_px: width and height of the image [px].
        lens: shape (9,), fx, fy, cx, cy [px], k1, k2, p1, p2, k3.
        floor: shape (6,), Rodrigues rotation [rad] and translation [m] of the floor frame.
        tag_height: of the tags above the floor [m].

    Returns:
        The camera.

    Raises:
        VisionError: if the numbers make no camera.
    """
    matrix = np.array([[lens[0], 0.0, lens[2]], [0.0, lens[1], lens[3]], [0.0, 0.0, 1.0]])
    rotation = np.asarray(cv2.Rodrigues(floor[:3])[0], np.float64)
    return CameraModel(size_px, matrix, lens[4:], rotation, floor[3:], tag_height)


def place_on(floor: Floats, board: Floats) -> Floats:
    """Where a board with a free pose lies, if it lies on the floor.

    Args:
        floor: shape (6,), pose of the floor frame in the camera's [rad, m].
        board: shape (6,), pose of the board in the camera's [rad, m].

    Returns:
        x, y, turn of the board in the floor frame, shape (3,) [m, m, rad].
    """
    to_floor = cv2.Rodrigues(floor[:3])[0].T
    rotation = to_floor @ cv2.Rodrigues(board[:3])[0]
    x, y, _ = to_floor @ (board[3:] - floor[3:])
    return np.array((x, y, np.arctan2(rotation[1, 0], rotation[0, 0])))


def with_floor(
    problem: Problem, state: State, boards: Sequence[Seen], frame: FloorFrame
) -> tuple[Problem, State]:
    """Add boards on the floor to a problem, the first one as the anchor of the floor frame.

    Args:
        problem: boards held freely.
        state: its first guess or fit.
        boards: on the floor, in their own frames.
        frame: where the first one lies.

    Returns:
        The larger problem and a first guess for it.
    """
    height = np.array((0.0, 0.0, frame.thickness))
    anchor = Seen(frame.points(boards[0].points), boards[0].pixels)
    laid = tuple(Seen(board.points + height, board.pixels) for board in boards[1:])
    floor = pose_of(anchor, state.lens)
    places = [place_on(floor, pose_of(board, state.lens)) for board in laid]
    return (
        replace(problem, anchor=anchor, laid=laid),
        replace(state, floor=floor, laid=np.reshape(places, (-1, 3))),
    )


def floor_spread(
    size_px: tuple[int, int], lens: Floats, floor: Floats, covariance: Floats, tag_height: float
) -> tuple[Floats, Floats]:
    """Expected error of floor positions all over the image, from the fit's covariance.

    Args:
        size_px: width and height of the image [px].
        lens: shape (9,).
        floor: shape (6,).
        covariance: shape (15, 15), of both.
        tag_height: of the tags [m].

    Returns:
        Pixels, shape (G, 2) [px], and the standard deviation of the distance from the true place,
        shape (G,) [m]; NaN where a pixel sees no floor.
    """
    grid, values = image_grid(size_px), np.concatenate((lens, floor))

    def _places(numbers: Floats) -> Floats:
        camera = camera_of(size_px, numbers[:LENS], numbers[LENS:], tag_height)
        return camera.to_floor(grid, tag_height)

    slopes = []
    for index, value in enumerate(values):
        step = np.zeros_like(values)
        step[index] = 1e-6 * max(abs(value), 1.0)
        slopes.append((_places(values + step) - _places(values - step)) / (2.0 * step[index]))
    slope = np.stack(slopes, axis=-1)  # (G, 2, 15)
    variance = np.einsum("gip,pq,giq->g", slope, covariance, slope)
    return grid, np.sqrt(np.maximum(variance, 0.0))


def image_grid(size_px: tuple[int, int]) -> Floats:
    """Pixels spread over the image.

    Args:
        size_px: width and height of the image [px].

    Returns:
        Shape (G, 2) [px].
    """
    across, down = (np.linspace(0, n - 1, k) for n, k in zip(size_px, _GRID, strict=True))
    return np.stack(np.meshgrid(across, down), -1).reshape(-1, 2)


def held_out_errors(
    size_px: tuple[int, int], problem: Problem, fit: Fit, thickness: float
) -> Floats:
    """Measure every board on the floor with a floor that was fitted without it.

    With several boards one is left out after the other, and its corners, measured on the floor, are
    compared with the board itself, wherever it lies. A single board is cut in two: each half is
    measured with the other.

    Args:
        size_px: width and height of the image [px].
        problem: with an anchor.
        fit: its fit.
        thickness: height of the boards' faces above the floor [m].

    Returns:
        Distances of the corners from where they belong, shape (N,) [m].
    """
    assert problem.anchor is not None
    if not problem.laid:
        return _halves(size_px, problem.anchor, fit.state.lens, thickness)
    boards = (problem.anchor, *problem.laid)
    errors = []
    for out, board in enumerate(boards):
        rest = [b for index, b in enumerate(boards) if index != out]
        floor = floor_from(rest, fit.state.lens)
        camera = camera_of(size_px, fit.state.lens, floor, 0.0)
        measured = camera.to_floor(board.pixels, thickness)
        errors.append(_misfit(measured, board.points[:, :2]))
    return np.concatenate(errors)


def floor_from(boards: Sequence[Seen], lens: Floats) -> Floats:
    """The floor of some boards on it, under a known lens.

    Args:
        boards: the first one in the floor frame, at least one.
        lens: shape (9,).

    Returns:
        Rodrigues rotation [rad] and translation [m], shape (6,).
    """
    floor = pose_of(boards[0], lens)
    places = [place_on(floor, pose_of(board, lens)) for board in boards[1:]]
    start = State(lens, np.zeros((0, 6)), floor, np.reshape(places, (-1, 3)))
    fit = adjust(Problem((), boards[0], tuple(boards[1:]), _NO_LENS), start)
    return fit.state.floor


def _halves(size_px: tuple[int, int], board: Seen, lens: Floats, thickness: float) -> Floats:
    """Errors of each half of a board, measured with the other half."""
    points = board.points - board.points.mean(axis=0)
    axis = np.linalg.svd(points[:, :2])[2][0]
    left = points[:, :2] @ axis < 0.0
    errors = []
    for used in (left, ~left):
        floor = floor_from([Seen(board.points[used], board.pixels[used])], lens)
        measured = camera_of(size_px, lens, floor, 0.0).to_floor(board.pixels[~used], thickness)
        errors.append(np.linalg.norm(measured - board.points[~used, :2], axis=1))
    return np.concatenate(errors)


def _misfit(measured: Floats, true: Floats) -> Floats:
    """Distances (N,) after the best shift and turn of one shape onto the other."""
    a, b = measured - measured.mean(axis=0), true - true.mean(axis=0)
    turn = np.arctan2((b[:, 0] * a[:, 1] - b[:, 1] * a[:, 0]).sum(), (a * b).sum())
    rotation = np.array([[cos(turn), -sin(turn)], [sin(turn), cos(turn)]])
    return np.asarray(np.linalg.norm(a - b @ rotation.T, axis=1), np.float64)
