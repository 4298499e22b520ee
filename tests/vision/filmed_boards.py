"""Boards filmed by known cameras: what the tests of the calibration share."""

from dataclasses import replace
from functools import cache
from math import cos, radians, sin

import cv2
import numpy as np
from numpy.typing import NDArray

from datasets.boards import BoardFilm
from datasets.sensor import SensorModel
from vision.calibration.board import Board
from vision.calibration.detect import BoardView, find_board, make_view
from vision.camera import CameraModel

Floats = NDArray[np.float64]

BOARD = Board(square=0.048, marker=0.034)  # fills an A3 sheet
CHECKERS = Board("chessboard", 9, 6, 0.045)
SENSOR = SensorModel(read_noise=3.0, blur_px=0.6, uneven_light=0.3)
PLACES = (
    (0.0, 0.0, 0.0),
    (-0.5, 0.35, 0.5),
    (0.45, 0.3, 1.0),
    (0.4, -0.35, 2.0),
    (-0.5, -0.3, 4.0),
)


def tilted(width: int = 640, tilt_deg: float = 12.0) -> CameraModel:
    """A wide, distorted, tilted, turned camera with oblong pixels over 1.9 m of floor."""
    a, b = radians(180.0 - tilt_deg), radians(20.0)
    lean = np.array([[1, 0, 0], [0, cos(a), -sin(a)], [0, sin(a), cos(a)]])
    turn = np.array([[cos(b), -sin(b), 0], [sin(b), cos(b), 0], [0, 0, 1]])
    rotation = lean @ turn
    matrix = np.array([[500.0, 0.0, 331.2], [0.0, 488.0, 227.7], [0.0, 0.0, 1.0]])
    camera = CameraModel(
        (640, 480), matrix, np.array((-0.22, 0.07, 0.0012, -0.0008, -0.01)), rotation,
        -rotation @ (0.1, -0.25, 1.45), 0.075,
    )  # fmt: skip
    return camera if width == 640 else camera.scaled_to((width, width * 3 // 4))


def film(camera: CameraModel, board: Board = BOARD, sensor: SensorModel = SENSOR) -> BoardFilm:
    """The camera with a board before it."""
    return BoardFilm(camera, board, sensor, seed=3)


def held_poses(camera: CameraModel, count: int, seed: int = 0) -> list[tuple[Floats, Floats]]:
    """Where a person holds a board: tilted this and that way, all over the picture."""
    rng = np.random.default_rng(seed)
    poses = []
    for number in range(count):
        lean = rng.uniform(-0.55, 0.55, 2)
        rotation = np.asarray(cv2.Rodrigues(np.array((*lean, rng.uniform(-3.0, 3.0))))[0])
        height = rng.uniform(0.25, 0.9)
        cell = np.array(((number % 4 + 0.5) / 4, (number // 4 % 4 + 0.5) / 4))
        pixel = (0.1 + 0.8 * cell) * camera.size_px
        middle = np.array((*camera.to_floor(pixel[None], height)[0], height))
        poses.append((rotation, middle - rotation @ (*np.divide(BOARD.size, 2), 0.0)))
    return poses


def flat_pose(x: float, y: float, turn: float) -> tuple[Floats, Floats]:
    """A board on the floor, its origin at x, y."""
    rotation = np.asarray(cv2.Rodrigues(np.array((0.0, 0.0, turn)))[0])
    if (x, y) == (0.0, 0.0):
        return rotation, np.zeros(3)
    return rotation, np.array((x, y, 0.0)) - rotation @ (*np.divide(BOARD.size, 2), 0.0)


def found(
    filmed: BoardFilm, poses: list[tuple[Floats, Floats]], board: Board = BOARD, first: int = 0
) -> list[BoardView]:
    """What is found in pictures of the board."""
    views = [
        find_board(filmed.picture(*pose, first + number), board, f"view{first + number}.png")
        for number, pose in enumerate(poses)
    ]
    return [view for view in views if isinstance(view, BoardView)]


@cache
def filmed_set(width: int) -> tuple[tuple[BoardView, ...], tuple[BoardView, ...]]:
    """15 views of a board in the hands, and 5 of it on the floor; detected once."""
    camera = tilted(width)
    filmed = film(camera)
    held = found(filmed, held_poses(camera, 15))
    places = PLACES if width == 640 else PLACES[:3]
    laid = found(filmed, [flat_pose(*place) for place in places], first=100)
    return tuple(held), tuple(laid)


def floor_errors(camera: CameraModel, truth: CameraModel) -> Floats:
    """How far floor positions at tag height are off, all over the image, shape (G,) [m]."""
    w, h = truth.size_px
    grid = np.stack(np.meshgrid(np.linspace(0, w - 1, 13), np.linspace(0, h - 1, 9)), -1)
    height = truth.tag_height
    got, wanted = (c.to_floor(grid.reshape(-1, 2), height) for c in (camera, truth))
    return np.linalg.norm(got - wanted, axis=1)


def without_tangential(camera: CameraModel) -> CameraModel:
    """The same camera with another lens, for fits that must choose fewer terms."""
    return replace(camera, distortion=np.array((-0.1, 0.0, 0.0, 0.0, 0.0)))


def ideal(rotation: Floats, place: Floats, name: str = "ideal") -> BoardView:
    """What a perfect detector would see of a board."""
    camera = tilted()
    pixels = camera.project(BOARD.corners @ rotation.T + place)
    inside = ((pixels > 0) & (pixels < np.array(camera.size_px) - 1)).all(axis=1)
    pixels += np.random.default_rng(1).normal(0.0, 0.02, pixels.shape)
    return make_view(name, camera.size_px, np.flatnonzero(inside), pixels[inside], 2.0)
