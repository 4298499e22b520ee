"""Things in the picture that are no robots: clutter on the floor, hands and cables above it."""

from dataclasses import dataclass
from math import inf

import numpy as np
from numpy.typing import ArrayLike, NDArray

from datasets.coverage import edge_coverage
from datasets.errors import SimulationError
from datasets.paths import Path
from datasets.sensor.shutter import Shutter
from vision.camera import CameraModel

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Window = tuple[slice, slice]

# A flat hand with its forearm, fingers along +x, palm about the origin [m].
_FINGERS = [(0.045, -0.042), (0.115, -0.036), (0.118, -0.022), (0.05, -0.018), (0.132, -0.012),
            (0.134, 0.004), (0.052, 0.004), (0.128, 0.012), (0.126, 0.028), (0.048, 0.022),
            (0.1, 0.036), (0.096, 0.05), (0.03, 0.042)]  # fmt: skip
_WRIST = [(-0.03, 0.034), (-0.08, 0.03), (-0.6, 0.045), (-0.6, -0.045), (-0.08, -0.03)]
_THUMB = [(-0.03, -0.04), (0.02, -0.085), (0.036, -0.076), (0.01, -0.042)]
HAND: Floats = np.array([*_FINGERS, *_WRIST, *_THUMB])
HAND.flags.writeable = False


@dataclass(frozen=True, slots=True)
class Thing:
    """A flat thing of one colour.

    Attributes:
        outline: shape (N, 2), in its own frame, read-only [m].
        bgr: its colour under full light, blue, green, red of 255, as the camera shows it.
        path: where its frame is.
        height: above the floor; robots hide what is not higher than their tags [m].
        begin: not there before [s].
        end: not there from then on [s].

    Raises:
        SimulationError: if the outline is not one, or the height is negative.
    """

    outline: Floats
    bgr: tuple[float, float, float]
    path: Path
    height: float = 0.0
    begin: float = -inf
    end: float = inf

    def __post_init__(self) -> None:
        shape = self.outline.shape
        if len(shape) != 2 or shape[0] < 3 or shape[1] != 2 or not np.isfinite(self.outline).all():
            raise SimulationError(f"an outline needs 3 or more finite points, got shape {shape}")
        if not 0.0 <= self.height < inf:
            raise SimulationError(f"a thing is {self.height} m above the floor")

    def mask(
        self, camera: CameraModel, shutter: Shutter, t: float, margin: int, shape: tuple[int, int]
    ) -> tuple[Window, Singles] | None:
        """How much of every pixel it covers, on average over the exposure.

        Args:
            camera: who looks.
            shutter: when the rows are exposed.
            t: moment of the frame [s].
            margin: pixels on every side of the image [px].
            shape: height and width of the image with its margins [px].

        Returns:
            A window of the image and the coverage there, 0 to 1; None if it is not in view.
        """
        if not self.begin <= t < self.end:
            return None
        views = shutter.views(lambda offsets: self._seen(camera, t + offsets), len(self.outline))
        corners = views + (margin + 0.5)
        if not np.isfinite(corners).all():
            return None  # partly behind the camera
        size = np.array(shape[::-1])
        low = np.clip(np.floor(corners.min(axis=(0, 1))), 0, size).astype(int)
        high = np.clip(np.ceil(corners.max(axis=(0, 1))), 0, size).astype(int)
        if (high <= low).any():
            return None
        window = slice(low[1], high[1]), slice(low[0], high[0])
        return window, _mean_coverage(corners - low, (high[1] - low[1], high[0] - low[0]))

    def _seen(self, camera: CameraModel, t: Floats) -> Floats:
        """Where every corner appears, each at a time of its own, shape (N, 2) [px]."""
        pose = self.path.at(t)
        c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
        x, y = self.outline.T
        across, along = pose[:, 0] + c * x - s * y, pose[:, 1] + s * x + c * y
        return camera.project(np.column_stack((across, along, np.full(len(x), self.height))))


def regular_outline(corners: int, radius: float) -> Floats:
    """Outline of a regular polygon.

    Args:
        corners: 3 a triangle, 4 a square, many a disc.
        radius: from its middle to a corner [m].

    Returns:
        Shape (corners, 2), read-only [m].
    """
    angles = 2.0 * np.pi * np.arange(corners) / corners
    return outline_array(radius * np.column_stack((np.cos(angles), np.sin(angles))))


def cable_outline(line: ArrayLike, width: float) -> Floats:
    """Outline of a cable.

    Args:
        line: shape (N, 2), its middle line, N >= 2 [m].
        width: of the cable [m].

    Returns:
        Shape (2 N, 2), read-only [m].

    Raises:
        SimulationError: if the line has fewer than two points, or two are the same.
    """
    points = np.asarray(line, float)
    if points.ndim != 2 or points.shape[1] != 2 or len(points) < 2:
        raise SimulationError(f"a cable needs 2 or more points, got shape {points.shape}")
    ahead = np.gradient(points, axis=0)
    lengths = np.hypot(*ahead.T)
    if not lengths.all():
        raise SimulationError("a cable's points must differ")
    side = 0.5 * width * np.column_stack((-ahead[:, 1], ahead[:, 0])) / lengths[:, None]
    return outline_array(np.vstack((points + side, (points - side)[::-1])))


def outline_array(points: ArrayLike) -> Floats:
    """Make a read-only outline.

    Args:
        points: shape (N, 2) [m].

    Returns:
        The same points, shape (N, 2) [m].
    """
    outline = np.array(points, float)
    outline.flags.writeable = False
    return outline


def _mean_coverage(views: Floats, shape: tuple[int, int]) -> Singles:
    """Mean coverage over K views of one outline, (K, N, 2) in corner coordinates."""
    count, corners = views.shape[:2]
    layers = np.repeat(np.arange(count), corners)
    starts, ends = views.reshape(-1, 2), np.roll(views, -1, axis=1).reshape(-1, 2)
    covered = np.minimum(edge_coverage(starts, ends, layers, (count, *shape)), 1.0)
    return np.asarray(covered.mean(axis=0), np.float32)
