"""The floor behind the picture, worked out once: exact for every camera, cheap in every frame."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vision.camera import CameraModel
from vision.compiled import compiled_part
from vision.errors import VisionError

Floats = NDArray[np.float64]

PITCH = 8
"""Distance of two nodes of a floor map [px]."""

_SCALE_STEP = 1.1  # scales that differ by less than this factor are treated as one
_LEAST_NODES = 4  # along each side: `around` needs them
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
    columns, rows = (max(size // PITCH + 2, _LEAST_NODES) for size in camera.size_px)
    x, y = np.meshgrid(np.arange(columns) * float(PITCH), np.arange(rows) * float(PITCH))
    points = camera.to_floor(np.column_stack((x.reshape(-1), y.reshape(-1))), camera.tag_height)
    scale = np.nan_to_num(_scale(camera, points), nan=0.0)
    level = np.abs(np.log(np.maximum(scale, 1e-9)[:, None] / scales)).argmin(axis=1)
    nodes = np.nan_to_num(points, nan=_FAR).reshape(rows, columns, 2)
    levels = level.astype(np.uint8).reshape(rows, columns)
    for array in (nodes, levels):
        array.flags.writeable = False
    return FloorMap(nodes, levels)


class Patch(NamedTuple):
    """The floor around a place, as a polynomial of third degree in column and in row.

    Attributes:
        terms: shape (2, 4, 4), of x and y; powers of the column, powers of the row [m].
        column: from where columns count [px].
        row: from where rows count [px].
        pitch: their unit [px].
    """

    terms: Floats
    column: float
    row: float
    pitch: float


@compiled_part
def around(nodes: Floats, x: float, y: float, radius: float) -> Patch:
    """Interpolate a floor map around a pixel, by 4 x 4 of its nodes: perspective bends.

    Args:
        nodes: see `FloorMap`.
        x: of the pixel [px].
        y: of the pixel [px].
        radius: of the window around it [px].

    Returns:
        The patch; its error is that of the fourth order.
    """
    rows, columns = nodes.shape[0], nodes.shape[1]
    apart = int(min(np.ceil(2.0 * radius / (3 * PITCH)), (min(rows, columns) - 1) // 3))
    apart = max(apart, 1)
    column = int(min(max(x / PITCH - 1.5 * apart + 0.5, 0.0), columns - 1.0 - 3 * apart))
    row = int(min(max(y / PITCH - 1.5 * apart + 0.5, 0.0), rows - 1.0 - 3 * apart))
    terms, half = np.empty((2, 4, 4)), np.empty((4, 4))
    for axis in range(2):
        for k in range(4):
            j = row + k * apart
            _cubic(
                nodes[j, column, axis], nodes[j, column + apart, axis],
                nodes[j, column + 2 * apart, axis], nodes[j, column + 3 * apart, axis], half[:, k],
            )  # fmt: skip
        for k in range(4):
            _cubic(half[k, 0], half[k, 1], half[k, 2], half[k, 3], terms[axis, k])
    pitch = float(PITCH)
    return Patch(terms, column * pitch, row * pitch, apart * pitch)


@compiled_part
def _cubic(zero: float, one: float, two: float, three: float, terms: Floats) -> None:
    """Terms (4,) of the cubic with given values at 0, 1, 2 and 3."""
    terms[0] = zero
    terms[1] = (-11.0 * zero + 18.0 * one - 9.0 * two + 2.0 * three) / 6.0
    terms[2] = (2.0 * zero - 5.0 * one + 4.0 * two - three) / 2.0
    terms[3] = (-zero + 3.0 * one - 3.0 * two + three) / 6.0


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
