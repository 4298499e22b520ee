"""The floor under the robots: dark, slightly spotted, with the white lines of a field."""

from dataclasses import dataclass
from itertools import pairwise
from math import pi

import cv2
import numpy as np
from numpy.typing import NDArray

from datasets.coverage import polygon_coverage
from vision.camera import CameraModel

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]

_STEPS = 24  # points along a line's side, so that a lens may bend it
_PATCHES = ((6, 0.5), (24, 0.3), (96, 0.2))  # cells across the image, share of the texture


@dataclass(frozen=True, slots=True)
class Floor:
    """How the floor looks under full light.

    Attributes:
        bgr: its colour, blue, green, red of 255.
        texture: standard deviation of the spots, relative to the brightness.
        line_bgr: colour of the field's lines, blue, green, red of 255.
        line_width: of the field's lines, 0 for none [m].
        inset: between the seen floor's border and the field's border, as a share of its width.
    """

    bgr: tuple[float, float, float] = (42.0, 46.0, 48.0)
    texture: float = 0.05
    line_bgr: tuple[float, float, float] = (205.0, 210.0, 208.0)
    line_width: float = 0.012
    inset: float = 0.04


def paint_floor(camera: CameraModel, floor: Floor, margin: int, seed: int) -> Singles:
    """Draw the empty floor as the camera sees it, before lens and light.

    Args:
        camera: who looks.
        floor: how it looks.
        margin: further pixels on every side of the image [px].
        seed: of the spots, >= 0.

    Returns:
        Shape (H + 2 margin, W + 2 margin, 3), BGR.
    """
    height, width = camera.size_px[1] + 2 * margin, camera.size_px[0] + 2 * margin
    spots = 1.0 + floor.texture * _spots((height, width), np.random.default_rng((seed, 1)))
    image = np.asarray(spots[..., None] * np.array(floor.bgr), np.float32)
    for outline in _field_lines(camera, floor) if floor.line_width else ():
        points = np.column_stack((outline, np.zeros(len(outline))))
        corners = camera.project(points) + (margin + 0.5)
        if np.isfinite(corners).all():
            _lay(image, corners, np.array(floor.line_bgr, np.float32))
    return image


def _spots(shape: tuple[int, int], rng: np.random.Generator) -> Singles:
    """Smooth noise of several sizes with a standard deviation of about 1."""
    total = np.zeros(shape, np.float32)
    for cells, share in _PATCHES:
        rows = max(2, cells * shape[0] // shape[1])
        coarse = rng.standard_normal((rows, cells), np.float32)
        smooth = cv2.resize(coarse, shape[::-1], interpolation=cv2.INTER_CUBIC)
        total += np.float32(share) * smooth
    return np.asarray(total / sum(share**2 for _, share in _PATCHES) ** 0.5, np.float32)


def _lay(image: Singles, corners: Floats, bgr: Singles) -> None:
    """Lay a polygon of one colour over an image; corner coordinates."""
    size = np.array(image.shape[1::-1])
    low = np.clip(np.floor(corners.min(axis=0)), 0, size).astype(int)
    high = np.clip(np.ceil(corners.max(axis=0)), 0, size).astype(int)
    if (high <= low).any():
        return
    window = image[low[1] : high[1], low[0] : high[0]]
    covered = polygon_coverage(corners - low, window.shape[:2])[..., None].astype(np.float32)
    window += covered * (bgr - window)


def _field_lines(camera: CameraModel, floor: Floor) -> tuple[Floats, ...]:
    """Outlines of the field's border, its middle line and the circle's two halves [m]."""
    width, height = camera.size_px
    seen = camera.to_floor(np.array([[0, 0], [width, 0], [width, height], [0, height]], float), 0.0)
    x0, y0 = np.sort(seen, axis=0)[1]  # inside the outline of the seen floor, also when tilted
    x1, y1 = np.sort(seen, axis=0)[2]
    inset = floor.inset * (x1 - x0)
    x0, y0, x1, y1 = x0 + inset, y0 + inset, x1 - inset, y1 - inset
    half, middle, radius = 0.5 * floor.line_width, 0.5 * (x0 + x1), 0.18 * (y1 - y0)
    strips = [(x, y0, x, y1) for x in (x0, middle, x1)] + [(x0, y, x1, y) for y in (y0, y1)]
    boxes = [_box(a - half, b - half, c + half, d + half) for a, b, c, d in strips]
    center = np.array([middle, 0.5 * (y0 + y1)])
    arcs = [_arc(center, radius - half, radius + half, start) for start in (0.0, pi)]
    return (*boxes, *arcs)


def _box(x0: float, y0: float, x1: float, y1: float) -> Floats:
    """Outline of a rectangle with points along its sides."""
    corners = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1], [x0, y0]])
    steps = np.linspace(0.0, 1.0, _STEPS, endpoint=False)[:, None]
    return np.vstack([a + steps * (b - a) for a, b in pairwise(corners)])


def _arc(center: Floats, inner: float, outer: float, start: float) -> Floats:
    """Outline of half a ring."""
    angles = start + np.linspace(0.0, pi, 2 * _STEPS)
    ring = np.column_stack((np.cos(angles), np.sin(angles)))
    return center + np.vstack((outer * ring, inner * ring[::-1]))
