"""What a calibration saw, as pictures: corners with residuals, coverage, the floor's grid."""

from math import ceil

import cv2
import numpy as np
from numpy.typing import NDArray

from pipeline.viewers.overlay import ACCEPTED, FONT, REJECTED, SUBPIXEL, WIDTH
from vision.calibration.detect import BoardView
from vision.calibration.result import Calibration
from vision.calibration.views import region_counts
from vision.camera import CameraModel

Image = NDArray[np.uint8]
Floats = NDArray[np.float64]

_ARROW = 0.05  # longest residual arrow, of the picture's width
_GRID_STEPS = (0.05, 0.1, 0.2, 0.25, 0.5, 1.0, 2.0, 5.0)  # spacing of the floor's grid [m]
_LINES = 12  # across the picture, at most
_GRID: tuple[int, int, int] = (255, 200, 60)
_X_AXIS: tuple[int, int, int] = (60, 60, 255)


def draw_corners(image: Image, view: BoardView, residuals: Floats, magnified: float) -> Image:
    """Draw the corners of a view with magnified residuals.

    Args:
        image: shape (H, W, 3), BGR.
        view: its corners.
        residuals: shape (N, 2), found minus predicted [px].
        magnified: factor of the arrows.

    Returns:
        An enlarged picture.
    """
    canvas, k = _enlarged(image)
    for place, residual in zip(view.pixels, residuals, strict=True):
        _line(canvas, np.stack((place, place + magnified * residual)), REJECTED, k)
        center = tuple(map(int, _fixed(place, k)))
        cv2.circle(canvas, center, 4 << SUBPIXEL, ACCEPTED, 1, cv2.LINE_AA, SUBPIXEL)
    rms = float(np.sqrt((residuals**2).sum(axis=1).mean()))
    _caption(
        canvas, f"{view.name}: {len(view.ids)} corners, {rms:.3f} px rms, arrows x {magnified:.0f}"
    )
    return canvas


def magnification(calibration: Calibration) -> float:
    """A factor that makes residuals visible, the same for all pictures.

    Args:
        calibration: with views.

    Returns:
        A power of ten times 1, 2 or 5.
    """
    largest = float(np.linalg.norm(np.vstack(calibration.residuals), axis=1).max())
    wanted = _ARROW * calibration.size_px[0] / max(largest, 1e-6)
    base = 10.0 ** np.floor(np.log10(wanted))
    return float(max(1.0, base * max(m for m in (1, 2, 5) if m * base <= wanted)))


def draw_coverage(calibration: Calibration) -> Image:
    """Draw all corners of all views, coloured by their residual, and count them by region.

    Args:
        calibration: with views.

    Returns:
        A picture of the image plane.
    """
    w, h = calibration.size_px
    canvas, k = _enlarged(np.full((h, w, 3), 24, np.uint8))
    largest = max(float(np.linalg.norm(np.vstack(calibration.residuals), axis=1).max()), 1e-9)
    for view, residuals in zip(calibration.views, calibration.residuals, strict=True):
        for place, residual in zip(view.pixels, residuals, strict=True):
            share = float(np.linalg.norm(residual)) / largest
            color = (60, int(255 * (1 - share)), int(255 * share))
            center = tuple(map(int, _fixed(place, k)))
            cv2.circle(canvas, center, 3 << SUBPIXEL, color, -1, cv2.LINE_AA, SUBPIXEL)
    counts = region_counts(calibration.views, calibration.size_px)
    for (row, column), count in np.ndenumerate(counts):
        x, y = round(k * w * column / 3), round(k * h * row / 3)
        cv2.rectangle(canvas, (x, y), (x + k * w // 3, y + k * h // 3), (90, 90, 90), 1)
        cv2.putText(canvas, f"{count}", (x + 8, y + 48), FONT, 0.7, (200, 200, 200), 1, cv2.LINE_AA)
    _caption(canvas, f"corners of {len(calibration.views)} views; red: {largest:.3f} px off")
    return canvas


def draw_floor(image: Image, camera: CameraModel) -> Image:
    """Draw the floor's grid over a picture, its x axis red.

    Args:
        image: shape (H, W, 3), BGR, of the camera's size.
        camera: calibrated.

    Returns:
        An enlarged picture.
    """
    canvas, k = _enlarged(image)
    low, high, step = _seen_range(camera)
    ticks = [
        np.arange(ceil(a / step), int(b // step) + 1) * step for a, b in zip(low, high, strict=True)
    ]
    along = [np.linspace(a, b, 80) for a, b in zip(low, high, strict=True)]
    for x in ticks[0]:
        _floor_line(canvas, camera, np.full(80, x), along[1], k, _GRID)
    for y in ticks[1]:
        _floor_line(canvas, camera, along[0], np.full(80, y), k, _GRID)
    axes = np.linspace(0.0, 2.0 * step, 20)
    _floor_line(canvas, camera, axes, 0.0 * axes, k, _X_AXIS, 3)
    _floor_line(canvas, camera, 0.0 * axes, axes, k, ACCEPTED, 3)
    for x in ticks[0]:
        for y in ticks[1]:
            _label(canvas, camera, float(x), float(y), k)
    _caption(canvas, f"floor grid, {step:g} m; red: x axis, green: y axis")
    return canvas


def _seen_range(camera: CameraModel) -> tuple[Floats, Floats, float]:
    """Least and greatest x, y of the seen floor, and a step of the grid [m]."""
    w, h = camera.size_px
    grid = np.stack(np.meshgrid(np.linspace(0, w - 1, 15), np.linspace(0, h - 1, 15)), -1)
    floor = camera.to_floor(grid.reshape(-1, 2), 0.0)
    floor = floor[np.isfinite(floor).all(axis=1)]
    near = np.abs(floor - np.median(floor, axis=0)) < 8.0 * np.median(np.abs(floor), axis=0) + 1.0
    floor = floor[near.all(axis=1)]  # a tilted camera may look at the horizon
    low, high = floor.min(axis=0), floor.max(axis=0)
    extent = float((high - low).max())
    return low, high, next((s for s in _GRID_STEPS if extent / s <= _LINES), _GRID_STEPS[-1])


def _floor_line(
    canvas: Image, camera: CameraModel, x: Floats, y: Floats, k: int,
    color: tuple[int, int, int], width: int = 1,
) -> None:  # fmt: skip
    """A line on the floor, bent by the lens."""
    pixels = camera.project(np.column_stack((x, y, np.zeros(len(x)))))
    seen = np.isfinite(pixels).all(axis=1) & (np.abs(pixels) < 4.0 * max(camera.size_px)).all(
        axis=1
    )
    if seen.sum() >= 2:
        _line(canvas, pixels[seen], color, k, width)


def _label(canvas: Image, camera: CameraModel, x: float, y: float, k: int) -> None:
    u, v = (k * (camera.project(np.array([[x, y, 0.0]]))[0] + 0.5)).tolist()
    if 0 <= u < canvas.shape[1] - 40 and 30 <= v < canvas.shape[0]:
        place = round(u) + 3, round(v) - 3
        cv2.putText(canvas, f"{x + 0.0:g},{y + 0.0:g}", place, FONT, 0.35, _GRID, 1, cv2.LINE_AA)


def _line(
    canvas: Image, points: Floats, color: tuple[int, int, int], k: int, width: int = 1
) -> None:
    cv2.polylines(canvas, [_fixed(points, k)], False, color, width, cv2.LINE_AA, SUBPIXEL)


def _fixed(points: Floats, k: int) -> NDArray[np.int32]:
    """Pixels of the picture as fixed-point pixels of the enlarged one."""
    return np.rint(((points + 0.5) * k - 0.5) * (1 << SUBPIXEL)).astype(np.int32)


def _enlarged(image: Image) -> tuple[Image, int]:
    k = max(1, round(WIDTH / image.shape[1]))
    size = image.shape[1] * k, image.shape[0] * k
    return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_NEAREST), np.uint8), k


def _caption(canvas: Image, text: str) -> None:
    cv2.rectangle(canvas, (0, 0), (canvas.shape[1], 26), (0, 0, 0), -1)
    cv2.putText(canvas, text, (8, 18), FONT, 0.5, (255, 255, 255), 1, cv2.LINE_AA)
