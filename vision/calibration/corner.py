"""Where four squares meet, to a hundredth of a pixel: a direct fit of two crossing edges.

Brightness near a corner is a + b tanh(d1 / s) tanh(d2 / s): d1, d2 are the signed distances from
two lines through the corner, s is the width of the lens's blur. Gauss-Newton steps on all corners
of a picture at once; pixels near the markers are left out.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_ARM = 0.42  # reach along the edges, in squares
_MOST_PX = 12  # reach of the window [px]
_CLEAR_PX = 1.2  # kept free towards a marker [px]
_LEAST_PX = 1.5  # least half width of the window's arms [px]
_STEPS = 15
_FAR = 0.3  # a corner that wanders further, in squares, is none
_POOR = 0.12  # misfit of brightness by half the contrast above which it is none


def fit_corners(
    grey: NDArray[np.uint8], pixels: Floats, slopes: Floats, gap: float
) -> tuple[Floats, NDArray[np.bool_]]:
    """Fit the crossing edges of many corners.

    Args:
        grey: shape (H, W).
        pixels: shape (N, 2), first guesses [px].
        slopes: shape (N, 2, 2), columns: one square across and one down in the picture [px].
        gap: from the edges to the nearest marker, in squares; 1 if there is none.

    Returns:
        Corners, shape (N, 2) [px], and which of them the edges really support, shape (N,).
    """
    offsets, values = _windows(grey, pixels, slopes)
    weights = _weights(offsets, slopes, gap)
    found = _start(values, slopes, offsets)
    for _ in range(_STEPS):
        residual, slope = _misfit(found, offsets, values)
        weighted = slope * weights[..., None]
        normal = weighted.transpose(0, 2, 1) @ slope + 1e-6 * np.eye(7)
        right = weighted.transpose(0, 2, 1) @ residual[..., None]
        step = np.linalg.solve(normal, right)
        found = found + np.clip(step[..., 0], _LOW, -_LOW)
        found[:, 6] = np.clip(found[:, 6], -1.5, 2.0)
    residual, _ = _misfit(found, offsets, values)
    total = np.maximum(weights.sum(axis=1), 1e-9)
    misfit = np.sqrt((weights * residual**2).sum(axis=1) / total)
    size = np.sqrt(np.abs(np.linalg.det(slopes)))
    near = np.linalg.norm(found[:, :2], axis=1) < np.maximum(_FAR * size, 1.0)
    good = near & (misfit < _POOR * np.abs(found[:, 5])) & np.isfinite(found).all(axis=1)
    return np.where(good[:, None], np.rint(pixels) + found[:, :2], pixels), good


_LOW = -np.array((0.7, 0.7, 0.15, 0.15, 40.0, 40.0, 0.4))  # the largest steps down


def _windows(grey: NDArray[np.uint8], pixels: Floats, slopes: Floats) -> tuple[Floats, Floats]:
    """Pixels around the corners: offsets from the rounded guess (P, 2), and brightness (N, P)."""
    reach = _ARM * float(np.median(np.linalg.norm(slopes, axis=1)))
    r = int(np.clip(np.ceil(reach) + 1, 3, _MOST_PX))
    steps = np.arange(-r, r + 1)
    offsets = np.stack(np.meshgrid(steps, steps), -1).reshape(-1, 2).astype(np.float64)
    places = np.rint(pixels)[:, None] + offsets
    framed = cv2.copyMakeBorder(grey, 1, 1, 1, 1, cv2.BORDER_REPLICATE)
    x = np.clip(places[..., 0] + 1, 0, framed.shape[1] - 1).astype(np.intp)
    y = np.clip(places[..., 1] + 1, 0, framed.shape[0] - 1).astype(np.intp)
    return offsets, framed[y, x].astype(np.float64)


def _weights(offsets: Floats, slopes: Floats, gap: float) -> Floats:
    """1 inside the cross of the edges and clear of the markers, shape (N, P)."""
    squares = np.abs(np.einsum("nij,pj->npi", np.linalg.inv(slopes), offsets))
    size = np.linalg.norm(slopes, axis=1)[:, ::-1]  # (N, 2): px per square
    clear = np.maximum(gap - _CLEAR_PX / size, _LEAST_PX / size)[:, None]
    inside = (squares < np.maximum(_ARM, 2.5 / size)[:, None]).all(axis=2)
    return np.asarray(inside & (squares < clear).any(axis=2), np.float64)


def _start(values: Floats, slopes: Floats, offsets: Floats) -> Floats:
    """First parameters (N, 7): x, y, angles of the edges, a, b, log s."""
    low, high = np.percentile(values, (10, 90), axis=1)
    across, down = slopes[:, :, 0], slopes[:, :, 1]
    start = np.zeros((len(values), 7))
    start[:, 2] = np.arctan2(across[:, 1], across[:, 0])
    start[:, 3] = np.arctan2(down[:, 1], down[:, 0])
    start[:, 4], start[:, 5] = 0.5 * (low + high), 0.5 * (high - low)
    shape = _misfit(np.column_stack((start[:, :4], np.zeros_like(low), np.ones_like(low),
                                     start[:, 6])), offsets, values)[0]  # fmt: skip
    product = values - shape
    sign = np.sign(((values - start[:, 4:5]) * product).sum(axis=1))
    start[:, 5] *= np.where(sign == 0.0, 1.0, sign)
    return start


def _misfit(found: Floats, offsets: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Brightness minus model (N, P), and the model's derivatives (N, P, 7)."""
    x = offsets[None, :, 0] - found[:, 0, None]
    y = offsets[None, :, 1] - found[:, 1, None]
    slope = np.empty((*x.shape, 7))
    inverse = np.exp(-found[:, 6, None])
    b = found[:, 5, None]
    edges = []
    for column in (2, 3):
        c, s = np.cos(found[:, column, None]), np.sin(found[:, column, None])
        distance = (c * y - s * x) * inverse
        edge = np.tanh(distance)
        edges.append((edge, (1.0 - edge * edge), distance, c * inverse, s * inverse, x, y))
    (one, dip_one, far_one, c1, s1, _, _), (two, dip_two, far_two, c2, s2, _, _) = edges
    by_one, by_two = b * dip_one * two, b * one * dip_two
    slope[..., 0] = by_one * s1 + by_two * s2
    slope[..., 1] = -by_one * c1 - by_two * c2
    slope[..., 2] = by_one * (-s1 * y - c1 * x)
    slope[..., 3] = by_two * (-s2 * y - c2 * x)
    slope[..., 4] = 1.0
    slope[..., 5] = one * two
    slope[..., 6] = -by_one * far_one - by_two * far_two
    return values - found[:, 4, None] - b * one * two, slope
