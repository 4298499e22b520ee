"""The Cramer-Rao bound: how well any unbiased method could know a pose from the pixels.

The noise-free picture is linear in the brightness of the tag's K parts and of the floor around it;
these are unknown, in blue, green and red. Its slope by x, y and heading comes from the renderer's
own exact coverage. With J the derivative of the picture by all 3 + 3 (K + 1) unknowns and S the
covariance of what the sensor adds, the bound is the upper left of (J^T S^-1 J)^-1.

Three kinds of pictures. "444": every pixel's three channels have noise of their own, are rounded
to 8 bit and clipped. "420": what is left of them are the brightness of every pixel and the colour
mean of every 2 x 2 pixels; the same noise in these sums, correlated as they share pixels. JPEG
besides: its rounding errors are no noise, but look like it; their covariance within 2 x 2 pixels is
measured beside tags and robots, that between such blocks is left out.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from math import ceil

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from datasets.coverage import polygon_coverage
from datasets.sensor import SensorModel
from vision.camera import CameraModel
from vision.palette import BGR_FROM_YCC, YCC_FROM_BGR, NamedColor
from vision.tags import Tag

Floats = NDArray[np.float64]

_AROUND_PX = 3  # of floor seen around the tag, beyond the reach of the lens
_STEP_PX = 1e-3  # of the derivative
_ROUNDING = 1.0 / 12.0  # variance of rounding to whole numbers
_GREY = np.arange(256.0)
_UNLIKELY = 1e-12
_LEAST = 1e-6  # information of a pixel far beyond what the sensor can show
_MEANS = np.linspace(0.0, 255.0, 1021)  # for which the information of a pixel is worked out


@dataclass(frozen=True, slots=True)
class Slopes:
    """A noise-free picture around a tag, in B blocks of 2 x 2 pixels.

    Attributes:
        picture: shape (B, 12), brightness of pixel and channel: pixels row by row, BGR in each.
        by_pose: shape (B, 12, 3), its derivative by x, y, theta [per m, per m, per rad].
        by_color: shape (B, 12, 3 (K + 1)), by blue, green and red of all parts and the floor.
        window: first column and row, width and height of the blocks in the picture [px], all even.
    """

    picture: Floats
    by_pose: Floats
    by_color: Floats
    window: tuple[int, int, int, int]


@dataclass(frozen=True, slots=True)
class Noise:
    """What the sensor adds.

    Attributes:
        sigma: standard deviation in every channel before digitising, of 255.
        chroma: what is kept of the colours, "444" or "420".
        measured: shape (6, 6), covariance of a block's 4 brightnesses and 2 colour means, for "420"
            with errors that are not known otherwise; None: what sigma gives.
    """

    sigma: float
    chroma: str
    measured: Floats | None = None

    def weighted(self, slope: Floats, picture: Floats) -> tuple[Floats, Floats]:
        """What the sensor keeps of a picture's slopes, with and without the noise's inverse.

        Args:
            slope: shape (B, 12, P).
            picture: shape (B, 12), brightness [0..255].

        Returns:
            S^-1 J and J, shape (B, 12, P) or, of what 4:2:0 keeps, (B, 6, P).
        """
        told = np.interp(picture, _MEANS, _table(self.sigma))
        if self.chroma == "444":
            return told[..., None] * slope, slope
        kept = _KEPT @ slope
        spread = self.measured
        if spread is None:
            spread = (_KEPT / np.maximum(told, _LEAST)[:, None]) @ _KEPT.T + _KEPT_ROUNDING
        return np.asarray(np.linalg.solve(spread, kept), np.float64), kept


def best_estimate(
    slopes: Slopes, noise: Noise, colors_known: bool = False
) -> tuple[Floats, Floats]:
    """The bound, and the linear estimate that reaches it near the true pose.

    What the estimate reaches can be reached: it tells whether the bound is right.

    Args:
        slopes: of the picture, N numbers kept of it in all.
        noise: of the sensor.
        colors_known: whether the brightness of parts and floor is known beforehand.

    Returns:
        Smallest covariance of x, y, theta, shape (3, 3) [m^2, m rad, rad^2]; shape (3, N): times
        what `left_over` finds, it gives the estimate's error [m, m, rad].
    """
    parts = (slopes.by_pose,) if colors_known else (slopes.by_pose, slopes.by_color)
    weighted, kept = noise.weighted(np.concatenate(parts, axis=2), slopes.picture)
    count = weighted.shape[2]
    weighted, kept = weighted.reshape(-1, count), kept.reshape(-1, count)
    inverse = _inverse(kept.T @ weighted)[:3]
    return inverse[:, :3], inverse @ weighted.T


def left_over(every: Sequence[Slopes], image: NDArray[np.uint8], chroma: str) -> list[Floats]:
    """What a picture shows beyond the noise-free one.

    Args:
        every: R tags in the picture, at their true poses.
        image: shape (H, W, 3), BGR.
        chroma: "444" or "420"; colours are taken to be filled in linearly, which is undone.

    Returns:
        For every tag the differences, shape (12 B,) or, of what 4:2:0 keeps, (6 B,).
    """
    seen = image.astype(float) if chroma == "444" else _unmixed(image)
    found = []
    for slopes in every:
        x, y, w, h = slopes.window
        change = _blocks(seen[y : y + h, x : x + w, :, None])[..., 0] - slopes.picture
        found.append((change if chroma == "444" else change @ _KEPT.T).reshape(-1))
    return found


def information(means: Floats, noise: float) -> Floats:
    """Fisher information that a noisy, rounded and clipped pixel holds about its brightness.

    Args:
        means: shape (M,), brightness before noise [0..255].
        noise: standard deviation, of 255, > 0.

    Returns:
        Shape (M,); 1 / (noise^2 + 1/12) far from 0 and 255.
    """
    edges = (np.concatenate(([-np.inf], _GREY[1:] - 0.5, [np.inf])) - means[:, None]) / noise
    chance = np.diff(ndtr(edges), axis=1)
    slope = -np.diff(np.exp(-0.5 * edges**2), axis=1) / (np.sqrt(2.0 * np.pi) * noise)
    likely = chance > _UNLIKELY  # the others hold nothing but rounding errors
    told: Floats = (slope**2 / np.where(likely, chance, np.inf)).sum(axis=1)
    return told


def make_slopes(
    tag: Tag,
    pose: Floats,
    camera: CameraModel,
    sensor: SensorModel,
    colors: tuple[NamedColor, ...],
    floor_bgr: tuple[float, float, float],
) -> Slopes:
    """Differentiate the noise-free picture of a tag on a floor of one colour, under even light.

    Args:
        tag: what is seen.
        pose: shape (3,), x, y, theta [m, m, rad].
        camera: who looks.
        sensor: its lens.
        colors: how the tag's colours look.
        floor_bgr: colour of the floor, of 255.

    Returns:
        The picture and its slopes.
    """
    bgr = {color.name: color.bgr for color in colors}
    palette = np.array([bgr[part.color] for part in tag.parts] + [floor_bgr], float)
    px = float(np.sqrt(abs(np.linalg.det(camera.affine_at(_point(pose, camera))[0]))))  # per m
    steps = _STEP_PX / px * np.diag((1.0, 1.0, 2.0 / tag.side))
    rectangle = _window(tag, pose, camera, ceil(4.0 * sensor.blur_px) + _AROUND_PX)
    middle = sensor.blur(_visible(tag, pose, camera, rectangle).astype(np.float32))
    seen = np.asarray(middle, float)
    by_pose = []
    for axis, step in enumerate(steps):
        change = _visible(tag, pose + step, camera, rectangle)
        change -= _visible(tag, pose - step, camera, rectangle)
        slope = sensor.blur((change / (2.0 * step[axis])).astype(np.float32))
        by_pose.append(np.asarray(slope, float) @ palette)
    by_color = np.einsum("hwk,cd->hwckd", seen, np.eye(3)).reshape(*seen.shape[:2], 3, -1)
    return Slopes(
        _blocks((seen @ palette)[..., None])[..., 0],
        _blocks(np.stack(by_pose, axis=-1)),
        _blocks(by_color),
        rectangle,
    )


def _inverse(matrix: Floats) -> Floats:
    """Inverse of a symmetric matrix whose rows have different units."""
    scale = np.sqrt(np.diag(matrix))
    both = np.outer(scale, scale)
    inverse: Floats = np.linalg.inv(matrix / both) / both
    return inverse


def _unmixed(image: NDArray[np.uint8]) -> Floats:
    """Undo linear upsampling of the colours: each mean of 2 x 2 pixels is given back."""
    h, w = image.shape[0] // 2, image.shape[1] // 2
    ycc = image[: 2 * h, : 2 * w].astype(float) @ YCC_FROM_BGR.T
    rows = ycc[0::2, :, 1:] + ycc[1::2, :, 1:]
    means = 0.25 * (rows[:, 0::2] + rows[:, 1::2])
    means = np.einsum("ij,jkc,lk->ilc", _unmixing(h), means, _unmixing(w), optimize=True)
    ycc[..., 1:] = means.repeat(2, axis=0).repeat(2, axis=1)
    unmixed: Floats = ycc @ BGR_FROM_YCC.T
    return unmixed


def _unmixing(count: int) -> Floats:
    """Inverse of what upsampling and taking means do to a row of samples, shape (n, n)."""
    mixing = 0.75 * np.eye(count) + 0.125 * (np.eye(count, k=1) + np.eye(count, k=-1))
    mixing[0, 0] = mixing[-1, -1] = 0.875
    return np.asarray(np.linalg.inv(mixing), np.float64)


@cache
def _table(noise: float) -> Floats:
    """Information of a pixel at `_MEANS`."""
    return information(_MEANS, noise)


def _kept() -> Floats:
    """From the 12 values of a block to its 4 brightnesses and 2 colour means, shape (6, 12)."""
    luma = np.kron(np.eye(4), YCC_FROM_BGR[:1])
    chroma = np.kron(np.full((1, 4), 0.25), YCC_FROM_BGR[1:])
    return np.vstack((luma, chroma))


_KEPT = _kept()
_KEPT_ROUNDING = np.diag(
    _ROUNDING * np.array([1.0, 1.0, 1.0, 1.0, 1.25, 1.25])
)  # mean of 4, then itself


def _point(pose: Floats, camera: CameraModel) -> Floats:
    """A tag's centre in space, shape (1, 3) [m]."""
    return np.array([[pose[0], pose[1], camera.tag_height]])


def _corners(polygon: Floats, pose: Floats, camera: CameraModel) -> Floats:
    """Where a polygon of a tag appears, shape (N, 2) [px, corner coordinates]."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    places = polygon @ np.array([[c, s], [-s, c]]) + pose[:2]
    return camera.project(np.column_stack((places, np.full(len(places), camera.tag_height)))) + 0.5


def _window(tag: Tag, pose: Floats, camera: CameraModel, around: int) -> tuple[int, int, int, int]:
    """First column and row (even), width and height (even) of a window around a tag [px]."""
    corners = np.vstack([_corners(part.polygon, pose, camera) for part in tag.parts])
    low = np.floor(corners.min(axis=0)).astype(int) - around
    low -= low % 2
    size = np.ceil(corners.max(axis=0)).astype(int) + around - low
    size += size % 2
    return int(low[0]), int(low[1]), int(size[0]), int(size[1])


def _visible(
    tag: Tag, pose: Floats, camera: CameraModel, window: tuple[int, int, int, int]
) -> Floats:
    """Share of every pixel that shows each part, and last the floor, shape (h, w, K + 1)."""
    x, y, width, height = window
    covered = [
        polygon_coverage(_corners(part.polygon, pose, camera) - (x, y), (height, width))
        for part in tag.parts
    ]
    visible = [*covered, 1.0 - sum(c for c, p in zip(covered, tag.parents, strict=True) if p < 0)]
    for own, parent in zip(covered, tag.parents, strict=True):
        if parent >= 0:
            visible[parent] = visible[parent] - own
    return np.stack(visible, axis=-1)


def _blocks(image: Floats) -> Floats:
    """Sort (h, w, 3, P) into blocks of 2 x 2 pixels, (B, 12, P)."""
    h, w, _, slopes = image.shape
    sorted_ = image.reshape(h // 2, 2, w // 2, 2, 3, slopes).transpose(0, 2, 1, 3, 4, 5)
    return np.ascontiguousarray(sorted_).reshape(-1, 12, slopes)
