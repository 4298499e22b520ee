"""The floor behind the picture, worked out once: exact for every camera, cheap in every frame."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.camera import CameraModel
from vision.compiled import compiled_part
from vision.errors import VisionError

Floats = NDArray[np.float64]

PITCH = 8
"""Distance of two nodes of a floor map [px]; a lens bends less than 1e-4 px in between."""

_SCALE_STEP = 1.1  # scales that differ by less than this factor are treated as one
_FAR = 1e3  # where a ray that misses the floor is said to meet it [m]


@dataclass(frozen=True, slots=True)
class FloorMap:
    """Floor points at tag height on a lattice of pixels.

    Attributes:
        nodes: shape (rows, columns, 2), the floor point behind pixel (PITCH column, PITCH row);
            reaches beyond the image's last pixel; far away where there is none [m], read-only.
        level: shape (rows, columns), index of the scale nearest to every node's, read-only.
    """

    nodes: Floats
    level: NDArray[np.uint8]


def image_scales(camera: CameraModel) -> Floats:
    """Find the scales at tag height that occur in the image.

    Args:
        camera: that takes the image.

    Returns:
        Ascending scales, each at most `_SCALE_STEP` times the one before, shape (L,) [px/m].

    Raises:
        VisionError: if no pixel sees the floor.
    """
    w, h = camera.size_px
    grid = np.stack(np.meshgrid(np.linspace(0, w - 1, 7), np.linspace(0, h - 1, 7)), -1)
    floor = camera.to_floor(grid.reshape(-1, 2), camera.tag_height)
    floor = floor[np.isfinite(floor).all(axis=1)]
    if len(floor) == 0:
        raise VisionError("no pixel of the camera sees the floor at tag height")
    scale = _scale(camera, floor)
    low, high = max(float(scale.min()), float(np.median(scale)) / 3.0), float(scale.max())
    count = 1 + int(np.ceil(np.log(high / low) / np.log(_SCALE_STEP) - 1e-6))
    return np.geomspace(low, high, count) if count > 1 else np.array([high])


def floor_map(camera: CameraModel, scales: Floats) -> FloorMap:
    """Find the floor points at tag height behind the picture.

    Args:
        camera: that takes the image.
        scales: shape (L,), ascending, L <= 256 [px/m].

    Returns:
        The map.
    """
    columns, rows = (size // PITCH + 2 for size in camera.size_px)
    x, y = np.meshgrid(np.arange(columns) * float(PITCH), np.arange(rows) * float(PITCH))
    points = camera.to_floor(np.column_stack((x.reshape(-1), y.reshape(-1))), camera.tag_height)
    scale = np.nan_to_num(_scale(camera, points), nan=0.0)
    level = np.abs(np.log(np.maximum(scale, 1e-9)[:, None] / scales)).argmin(axis=1)
    nodes = np.nan_to_num(points, nan=_FAR).reshape(rows, columns, 2)
    levels = level.astype(np.uint8).reshape(rows, columns)
    for array in (nodes, levels):
        array.flags.writeable = False
    return FloorMap(nodes, levels)


@compiled_part
def floor_at(nodes: Floats, x: float, y: float) -> tuple[float, float]:
    """Interpolate a floor map.

    Args:
        nodes: see `FloorMap`.
        x: of a pixel in or near the image [px].
        y: of the pixel [px].

    Returns:
        The floor point's coordinates [m].
    """
    rows, columns = nodes.shape[0], nodes.shape[1]
    column = min(max(int(x / PITCH), 0), columns - 2)
    row = min(max(int(y / PITCH), 0), rows - 2)
    a, b = x / PITCH - column, y / PITCH - row
    one, two = (1.0 - a) * (1.0 - b), a * (1.0 - b)
    three, four = (1.0 - a) * b, a * b
    return (
        one * nodes[row, column, 0] + two * nodes[row, column + 1, 0]
        + three * nodes[row + 1, column, 0] + four * nodes[row + 1, column + 1, 0],
        one * nodes[row, column, 1] + two * nodes[row, column + 1, 1]
        + three * nodes[row + 1, column, 1] + four * nodes[row + 1, column + 1, 1],
    )  # fmt: skip


@compiled_part
def pixel_slopes(nodes: Floats, x: float, y: float) -> tuple[float, float, float, float]:
    """How pixels move as floor points do.

    Args:
        nodes: see `FloorMap`.
        x: of a pixel in or near the image [px].
        y: of the pixel [px].

    Returns:
        d column / d x, d column / d y, d row / d x, d row / d y; 0 where nothing is seen [px/m].
    """
    here, right = floor_at(nodes, x, y), floor_at(nodes, x + 1.0, y)
    down = floor_at(nodes, x, y + 1.0)
    a, b, c, d = right[0] - here[0], down[0] - here[0], right[1] - here[1], down[1] - here[1]
    area = a * d - b * c
    if area == 0.0:
        return 0.0, 0.0, 0.0, 0.0
    return d / area, -b / area, -c / area, a / area


def _scale(camera: CameraModel, floor: Floats) -> Floats:
    """Scale at tag height at floor points (N, 2), shape (N,) [px/m]."""
    affine = camera.affine_at(np.column_stack((floor, np.full(len(floor), camera.tag_height))))
    with np.errstate(invalid="ignore"):  # where a bent lens sees nothing
        scale: Floats = np.sqrt(np.abs(np.linalg.det(affine)))
    return scale
