"""Pixels known to show a colour: deep inside the parts of named tags, and far from tags."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.camera import CameraModel
from vision.tags import Tag

Floats = NDArray[np.float64]
Pixels = NDArray[np.uint8]

_CELLS = 96  # of a tag's drawing, along its box
_DEEP_PX = 1.0  # pixels are inside a part if so far from its edge
_LEAST = 3  # of a part too small for that, the deepest pixels count
_MOST_SORTED = 20000  # pixels; of more, every so many-th is looked at
_CLEAR = 1.15  # the floor begins so many radii from a tag's centre


@dataclass(frozen=True, slots=True)
class Drawing:
    """A tag drawn in its own frame.

    Attributes:
        part: shape (n, n), index of the visible part, over y and x; -1 for none.
        depth: shape (n, n), distance to the part's edge [m].
        reach: half the side of the drawing [m].
    """

    part: NDArray[np.int16]
    depth: NDArray[np.float32]
    reach: float


def draw_tag(tag: Tag) -> Drawing:
    """Draw a tag finely.

    Args:
        tag: whose parts.

    Returns:
        The drawing.
    """
    reach = 1.02 * tag.outer_radius
    part = np.full((_CELLS, _CELLS), -1, np.int16)
    for index, polygon in enumerate(p.polygon for p in tag.parts):
        corners = np.rint(((polygon / reach + 1.0) * _CELLS / 2.0 - 0.5) * 16.0).astype(np.int32)
        cv2.fillPoly(part, [corners], (index,), shift=4)
    depth = np.zeros(part.shape, np.float32)
    for index in range(len(tag.parts)):
        mask = np.pad(np.asarray(part == index, np.uint8), 1)
        inside = np.asarray(cv2.distanceTransform(mask, cv2.DIST_L2, 5), np.float32)[1:-1, 1:-1]
        depth += inside * np.float32(2.0 * reach / _CELLS)
    return Drawing(part, depth, reach)


def part_pixels(
    image: Pixels, camera: CameraModel, drawing: Drawing, pose: Floats
) -> tuple[Pixels, ...]:
    """Collect the pixels deep inside each part of a tag.

    Args:
        image: shape (H, W, 3), BGR.
        camera: that took it.
        drawing: of the tag.
        pose: x, y, theta on the floor [m, m, rad].

    Returns:
        For every part its pixels, shape (N, 3); where no pixel is deep enough, the few deepest.
    """
    columns, rows = _window(camera, drawing.reach, pose)
    floor = camera.to_floor(np.column_stack((columns, rows)), camera.tag_height)
    dx, dy = (floor - pose[:2]).T
    c, s = np.cos(pose[2]), np.sin(pose[2])
    own = np.column_stack((c * dx + s * dy, c * dy - s * dx))
    cell = np.floor(np.nan_to_num((own / drawing.reach + 1.0) * _CELLS / 2.0, nan=-1.0))
    inside = np.asarray(((cell >= 0) & (cell < _CELLS)).all(axis=1))
    u, v = np.where(inside[:, None], cell, 0).astype(np.intp).T
    part = np.where(inside, drawing.part[v, u], -1)
    depth = drawing.depth[v, u]
    slope = camera.affine_at(np.array([[pose[0], pose[1], camera.tag_height]]))
    deep = _DEEP_PX / float(np.sqrt(np.abs(np.linalg.det(slope))[0]))
    found = []
    for index in range(int(drawing.part.max()) + 1):
        at = np.flatnonzero(part == index)
        at = at[np.argsort(-depth[at], kind="stable")]
        enough = max(int(np.count_nonzero(depth[at] >= deep)), _LEAST)
        found.append(image[rows[at[:enough]], columns[at[:enough]]])
    return tuple(found)


def floor_pixels(image: Pixels, camera: CameraModel, poses: Floats, radius: float) -> Pixels:
    """Collect what is not a tag.

    Args:
        image: shape (H, W, 3), BGR.
        camera: that took it.
        poses: shape (R, 3), of all tags in the picture [m, m, rad].
        radius: of the largest tag [m].

    Returns:
        The other pixels, shape (N, 3), row by row.
    """
    away = np.ones(image.shape[:2], bool)
    for pose in poses:
        columns, rows = _window(camera, _CLEAR * radius, pose)
        floor = camera.to_floor(np.column_stack((columns, rows)), camera.tag_height)
        near = np.hypot(*(floor - pose[:2]).T) < _CLEAR * radius
        away[rows[near], columns[near]] = False
    return image[away]


def representative(pixels: Pixels, count: int) -> Pixels:
    """Choose pixels that stand for many: evenly along a curve that passes alike colours together.

    Args:
        pixels: shape (N, 3), BGR.
        count: at most so many.

    Returns:
        Shape (M, 3), M <= count, from dark to bright along the curve.
    """
    pixels = pixels[:: max(1, len(pixels) // _MOST_SORTED)]
    order = np.argsort(_morton(pixels), kind="stable")
    if len(order) > count:
        order = order[np.linspace(0, len(order) - 1, 2 * count + 1).astype(np.intp)[1::2]]
    return pixels[order]


def _morton(pixels: Pixels) -> NDArray[np.int64]:
    """The bits of blue, green and red interleaved, the highest first."""
    code = np.zeros(len(pixels), np.int64)
    wide = pixels.astype(np.int64)
    for bit in range(8):
        for channel in range(3):
            code |= ((wide[:, channel] >> bit) & 1) << (3 * bit + channel)
    return code


def _window(
    camera: CameraModel, reach: float, pose: Floats
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Columns and rows of the pixels of a box around a place."""
    turns = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
    rim = pose[:2] + 1.1 * reach * np.column_stack((np.cos(turns), np.sin(turns)))
    pixels = camera.project(np.column_stack((rim, np.full(16, camera.tag_height))))
    low = np.maximum(np.floor(np.nanmin(pixels, axis=0)), 0).astype(int)
    high = np.minimum(np.ceil(np.nanmax(pixels, axis=0)), np.array(camera.size_px) - 1).astype(int)
    columns, rows = np.meshgrid(np.arange(low[0], high[0] + 1), np.arange(low[1], high[1] + 1))
    return columns.reshape(-1), rows.reshape(-1)
