"""The Cramer-Rao bound: how well any unbiased method could know a pose from the pixels.

The noise-free picture is linear in the brightness of the tag's K parts and of the floor around it;
these are unknown, in blue, green and red. Its slope by x, y and heading comes from the renderer
itself, see `slopes`. With J the derivative of the picture by all 3 + 3 (K + 1) unknowns and S the
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

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from benchmarks.slopes import Slopes, in_blocks
from vision.palette import BGR_FROM_YCC, YCC_FROM_BGR

Floats = NDArray[np.float64]

_ROUNDING = 1.0 / 12.0  # variance of rounding to whole numbers
_GREY = np.arange(256.0)
_UNLIKELY = 1e-12
_LEAST = 1e-6  # information of a pixel far beyond what the sensor can show
_MEANS = np.linspace(0.0, 255.0, 1021)  # for which the information of a pixel is worked out


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
        change = in_blocks(seen[y : y + h, x : x + w, :, None])[..., 0] - slopes.picture
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
