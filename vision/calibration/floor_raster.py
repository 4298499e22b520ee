"""The floor at tag height as if seen straight from above, on a raster of equal cells."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.camera import CameraModel

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]

_GRID = 17  # points along each side of the image by which the floor's extent is found
_OBLIQUE = 3.0  # floor seen at less than the median scale by this factor is left out
_MOST_CELLS = 1 << 21  # of a raster; a larger floor gets larger cells
_HALF_PX = 0.5  # blur against aliasing: standard deviation, as a share of a cell's side


@dataclass(frozen=True, slots=True)
class Raster:
    """A picture of the floor at tag height.

    Attributes:
        colors: shape (rows, columns, 3), BGR, over y and x of the floor.
        seen: shape (rows, columns), whether the camera sees the cell.
        origin: x, y of the first cell, shape (2,) [m].
        cell: side of a cell [m].
        cell_px: the same in the middle of the image [px].
    """

    colors: Singles
    seen: NDArray[np.bool_]
    origin: Floats
    cell: float
    cell_px: float


def floor_raster(image: NDArray[np.uint8], camera: CameraModel, cell: float) -> Raster:
    """Look at the floor from straight above.

    Args:
        image: shape (H, W, 3), BGR.
        camera: that took it.
        cell: wanted side of a cell; larger where the floor would need too many [m].

    Returns:
        The raster around all of the floor that is seen at a useful scale.
    """
    low, high, scale = _extent(camera)
    cell = max(cell, float(np.sqrt(np.prod(high - low) / _MOST_CELLS)))
    columns, rows = np.ceil((high - low) / cell).astype(int) + 1
    x, y = np.meshgrid(low[0] + cell * np.arange(columns), low[1] + cell * np.arange(rows))
    points = np.column_stack((x.ravel(), y.ravel(), np.full(x.size, camera.tag_height)))
    pixels = camera.project(points).reshape(rows, columns, 2)
    limit = np.array(camera.size_px) - 1
    seen = np.asarray(((pixels >= 0) & (pixels <= limit)).all(axis=2))
    source = image.astype(np.float32)
    if cell * scale > 1.0:
        source = np.asarray(cv2.GaussianBlur(source, (0, 0), _HALF_PX * cell * scale), np.float32)
    across, down = np.nan_to_num(pixels, nan=-1.0).astype(np.float32).transpose(2, 0, 1).copy()
    border = cv2.BORDER_REPLICATE
    colors = cv2.remap(source, across, down, cv2.INTER_LINEAR, borderMode=border)
    return Raster(np.asarray(colors, np.float32), seen, low, cell, cell * scale)


def _extent(camera: CameraModel) -> tuple[Floats, Floats, float]:
    """Corners of the floor in the image [m] and the median scale [px/m]."""
    w, h = camera.size_px
    grid = np.stack(np.meshgrid(np.linspace(0, w - 1, _GRID), np.linspace(0, h - 1, _GRID)), -1)
    floor = camera.to_floor(grid.reshape(-1, 2), camera.tag_height)
    floor = floor[np.isfinite(floor).all(axis=1)]
    height = np.full(len(floor), camera.tag_height)
    slopes = camera.affine_at(np.column_stack((floor, height)))
    scale = np.sqrt(np.abs(np.linalg.det(slopes)))
    median = float(np.median(scale))
    near = floor[scale > median / _OBLIQUE]
    return near.min(axis=0), near.max(axis=0), median
