"""A calibration board filmed by a known camera: pictures with truth for the calibration."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from datasets.coverage import edge_coverage
from datasets.floor import Floor, paint_floor
from datasets.sensor import SensorModel
from vision.calibration.board import Board
from vision.camera import CameraModel

Floats = NDArray[np.float64]
Image = NDArray[np.uint8]

_PAPER, _INK = 215.0, 28.0  # under full light, of 255
_STEPS = 4  # pieces of an edge, so that a lens may bend it


class BoardFilm:
    """A camera that looks at one board; the same seed and frame give the same picture."""

    def __init__(
        self,
        camera: CameraModel,
        board: Board,
        sensor: SensorModel,
        seed: int = 0,
        margin: float = 0.02,
    ) -> None:
        """Paint and light the empty floor.

        Args:
            camera: who looks.
            board: what it looks at.
            sensor: what the camera does to the light.
            seed: of noise and floor, >= 0.
            margin: of white paper around the squares [m].
        """
        self._camera, self._sensor = camera, sensor
        self._stages = sensor.stages(camera.size_px, seed)
        self._light = sensor.light(camera.size_px)[..., None]
        self._floor = paint_floor(camera, Floor(), 0, seed)
        (width, height), m = board.size, margin
        paper = [[-m, -m], [width + m, -m], [width + m, height + m], [-m, height + m]]
        self._cells = _fine(board.black_cells(), _STEPS)
        self._paper = _fine(np.array([paper]), _STEPS * max(board.columns, board.rows))

    def picture(self, rotation: Floats, translation: Floats, frame: int = 0) -> Image:
        """Film the board somewhere.

        Args:
            rotation: shape (3, 3), R_floor_board.
            translation: shape (3,), the board's origin in the floor frame [m].
            frame: number of the frame, for all that is random.

        Returns:
            Shape (H, W, 3), BGR.
        """
        moved = self._camera.rotation @ translation + self._camera.translation
        camera = replace(self._camera, rotation=self._camera.rotation @ rotation, translation=moved)
        paper, ink = (_covered(camera, outline) for outline in (self._paper, self._cells))
        image = self._floor * (1.0 - paper) + _PAPER * paper - (_PAPER - _INK) * ink
        image = self._sensor.blur(np.asarray(image * self._light, np.float32))
        for stage in self._stages:
            image = stage(image, frame)
        return np.asarray(image, np.uint8)


def _fine(polygons: Floats, steps: int) -> Floats:
    """Polygons (M, V, 2) with every edge cut into pieces, shape (M, V steps, 2)."""
    ways = np.roll(polygons, -1, axis=1) - polygons
    along = np.arange(steps)[:, None] / steps
    return (polygons[:, :, None] + along * ways[:, :, None]).reshape(len(polygons), -1, 2)


def _covered(camera: CameraModel, polygons: Floats) -> NDArray[np.float32]:
    """Share of every pixel covered by disjoint polygons, shape (H, W, 1)."""
    count, corners = polygons.shape[:2]
    flat = polygons.reshape(-1, 2)
    pixels = camera.project(np.column_stack((flat, np.zeros(len(flat))))) + 0.5
    starts = pixels.reshape(count, corners, 2)
    ends = np.roll(starts, -1, axis=1)
    layers = np.zeros(count * corners, np.intp)
    shape = (1, camera.size_px[1], camera.size_px[0])
    covered = edge_coverage(starts.reshape(-1, 2), ends.reshape(-1, 2), layers, shape)[0]
    return np.asarray(np.clip(covered, 0.0, 1.0)[..., None], np.float32)
