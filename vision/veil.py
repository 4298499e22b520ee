"""A fit of one tag to pixels of which some are not its own: iteratively reweighted.

A pixel's residual counts against what noise, shades and a pose off by a slack can do to it; the
slack shrinks from step to step (graduated non-convexity, Blake and Zisserman 1987; weights of Geman
and McClure 1985). The colours of the tag's parts are known beforehand, about as the palette has
them: that tells the tag's own pixels from others. Unknowns of every channel are K + 1 brightnesses,
of all channels the pose.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vision.compiled import compiled, compiled_part
from vision.elimination import invert
from vision.floor_map import PITCH
from vision.gauge import Gauge
from vision.own_pixels import Known, Pixels, collect_around, expect_colors, look_at

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Bytes = NDArray[np.uint8]

_ON = 0.6  # coverage of the tag: a pixel is on it
_OWN = 0.15  # weight of a pixel that may be the tag's own, at least
_FLOOR = 0.995  # of a sample: then it tells nothing of the tag
_NOTHING = 0.02  # a weight that makes no difference
_CUT = 9.0  # squared normalised residual of a sample at which its weight is a quarter
_ROUNDING = 1.0  # and what the templates leave out: variance of a sample [grey levels^2]
_SHADE = 0.04  # by this share of its brightness a pixel may differ
_PRIOR = 20.0  # samples that the stated noise counts for, against the residuals found
_SQUARE = 0.25  # colours are means of 2 x 2 pixels, and all four are samples
_FREE_STEPS, _VAGUE = 2, 1e-6  # the last steps know the pose beforehand only so much


class _Sums(NamedTuple):
    """Sums over the samples: normal equations for each channel, M = K + 4 unknowns, lower halves
    (3, M, M), and gradients (3, M); squared residuals (3,); the samples' weight and squared slopes
    (2,). Of one sample: residuals and slopes ahead, aside and by a turn (4, 3). Pixels on the
    parts and on the tag: how many there are, and how many are not its own (2, K + 1).
    """

    normal: Floats
    pull: Floats
    squares: Floats
    totals: Floats
    seen: Floats
    strange: Floats


class _Tag(NamedTuple):
    """How a tag would look: templates of pixels and of colours (n, n, K); pose (3,); colours
    (K + 1, 3); expected colours and their standard deviations (K + 1, 3).
    """

    luma: Singles
    chroma: Singles
    pose: Floats
    colors: Floats
    typical: Floats
    spread: Floats


@compiled
def fit_veiled(
    image: Bytes, g: Gauge, known: Known, center: Floats, slacks: Floats, margin: float,
    pose: Floats, covariance: Floats, colors: Floats, hidden: Floats,
) -> float:  # fmt: skip
    """Fit a tag to those pixels that can be its own.

    Args:
        image: shape (H, W, 3), BGR.
        g: templates, floor map and noise.
        known: what is known of the tag.
        center: shape (2,), where it is expected in the image [px].
        slacks: shape (S,), of the pose in every step, as shares of the spread.
        margin: a pose is never known better than this [m].
        pose: shape (3,), receives the pose [m, m, rad].
        covariance: shape (3, 3), receives its covariance [m^2, m rad, rad^2].
        colors: shape (K + 1, 3), receives BGR of the parts and the floor.
        hidden: shape (K + 1,), receives the share of the pixels that are not the tag's own: of the
            parts, and of all.

    Returns:
        Misfit (rms) of the others as a displacement of edges [m].
    """
    rows, columns = g.level.shape
    row = int(min(rows - 1.0, max(0.0, center[1] / PITCH + 0.5)))
    column = int(min(columns - 1.0, max(0.0, center[0] / PITCH + 0.5)))
    level, separate = g.level[row, column], len(g.pixels.noise) == 3
    luma = g.pixels.cells[level, known.shape, 0]
    chroma = luma if separate else g.colors.cells[level, known.shape, 0]
    kinds, size = luma.shape[2] + 1, 4 * (g.radius + 1) ** 2
    tag = _Tag(luma, chroma, pose, colors, np.empty((kinds, 3)), np.empty((kinds, 3)))
    pixels = Pixels(
        np.empty((size, 2)), np.empty((size, 3)), np.empty((2, kinds)), np.empty((2, 2, kinds))
    )
    count = collect_around(image, g, known, center, pixels)
    expect_colors(g, known, luma, count, pixels, tag.typical, tag.spread)
    pose[:], colors[:] = known.pose, tag.typical
    sums = _Sums(
        np.empty((3, kinds + 3, kinds + 3)), np.empty((3, kinds + 3)), np.empty(3), np.empty(2),
        np.empty((4, 3)), np.empty((2, kinds)),
    )  # fmt: skip
    least = np.array((margin, margin, margin / g.arm))
    for step in range(len(slacks)):
        slack = np.maximum(known.spread * slacks[step], least)
        _sum_up(g, known, tag, slack, count, pixels, sums)
        _solve(known, tag, 1.0 if step < len(slacks) - _FREE_STEPS else _VAGUE, sums, covariance)
    if not separate:
        _to_bgr(colors)
    for k in range(kinds):
        hidden[k] = sums.strange[1, k] / max(sums.strange[0, k], 1.0)
    return float(np.sqrt(sums.squares.sum() / max(sums.totals[1], 1e-9)))


@compiled_part
def _sum_up(
    g: Gauge, known: Known, tag: _Tag, slack: Floats, count: int, pixels: Pixels, sums: _Sums
) -> None:
    """Weigh the samples, and set up their normal equations."""
    last = len(tag.colors) - 1
    sums.normal[:], sums.pull[:], sums.squares[:], sums.totals[:] = 0.0, 0.0, 0.0, 0.0
    sums.strange[:] = 0.0
    c, s = np.cos(tag.pose[2]), np.sin(tag.pose[2])
    covers, slopes = pixels.covers, pixels.slopes
    for n in range(count):
        dx = pixels.places[n, 0] + known.pose[0] - tag.pose[0]
        dy = pixels.places[n, 1] + known.pose[1] - tag.pose[1]
        x, y = c * dx + s * dy, c * dy - s * dx
        look_at(tag.luma, g.pixels.cell, x, y, covers[0], slopes[0])
        if covers[0, last] > _FLOOR:
            continue
        if len(g.pixels.noise) == 1:
            look_at(tag.chroma, g.colors.cell, x, y, covers[1], slopes[1])
        square = _compare(g, x, y, pixels.values[n], tag.colors, slack, pixels, sums.seen)
        weight = (_CUT / (_CUT + square)) ** 2
        for k in range(last + 1):
            on = covers[0, k] > _ON if k < last else covers[0, last] < 1.0 - _ON
            sums.strange[0, k] += on
            sums.strange[1, k] += on and weight < _OWN
        if weight > _NOTHING:
            _add(g, weight, pixels, sums)


@compiled_part
def _compare(
    g: Gauge, x: float, y: float, value: Floats, colors: Floats, slack: Floats, pixels: Pixels,
    seen: Floats,
) -> float:  # fmt: skip
    """Residuals and slopes of a sample (4, 3); returns the squared residual, normalised."""
    square = 0.0
    for channel in range(3):
        noise, _, plane = _plane(g, channel)
        off, ahead, aside, bright = value[channel], 0.0, 0.0, 0.0
        for k in range(len(colors)):
            color, cover = colors[k, channel], pixels.covers[plane, k]
            off, bright = off - cover * color, bright + cover * abs(color)
            ahead -= pixels.slopes[plane, 0, k] * color
            aside -= pixels.slopes[plane, 1, k] * color
        turn = x * aside - y * ahead
        seen[0, channel], seen[1, channel], seen[2, channel] = off, ahead, aside
        seen[3, channel] = turn
        allowed = (
            noise + (_SHADE * bright) ** 2 + (slack[0] * ahead) ** 2 + (slack[1] * aside) ** 2
            + (slack[2] * turn) ** 2
        )  # fmt: skip
        square += off * off / allowed
    return square


@compiled_part
def _add(g: Gauge, weight: float, pixels: Pixels, sums: _Sums) -> None:
    """Add a sample to the normal equations."""
    kinds, seen = pixels.covers.shape[1], sums.seen
    sums.totals[0] += weight
    for channel in range(3):
        noise, share, plane = _plane(g, channel)
        off = seen[0, channel]
        sums.squares[channel] += weight * off * off / noise
        sums.totals[1] += weight * (seen[1, channel] ** 2 + seen[2, channel] ** 2) / noise
        factor = weight * share / noise
        for j in range(kinds + 3):
            one = pixels.covers[plane, j] if j < kinds else seen[j - kinds + 1, channel]
            sums.pull[channel, j] += factor * one * off
            for k in range(j + 1):
                two = pixels.covers[plane, k] if k < kinds else seen[k - kinds + 1, channel]
                sums.normal[channel, j, k] += factor * one * two


@compiled_part
def _plane(g: Gauge, channel: int) -> tuple[float, float, int]:
    """Variance, independence and template of a channel."""
    if len(g.pixels.noise) == 3 or channel == 0:
        return g.pixels.noise[channel] ** 2 + _ROUNDING, 1.0, 0
    return g.colors.noise[channel - 1] ** 2 + _ROUNDING, _SQUARE * g.colors.independence, 1


@compiled_part
def _solve(known: Known, tag: _Tag, prior: float, sums: _Sums, covariance: Floats) -> None:
    """Take a Gauss-Newton step: brightnesses are eliminated, and follow from the pose's step."""
    kinds, pose = len(tag.colors), tag.pose
    c, s = np.cos(pose[2]), np.sin(pose[2])
    turned = np.array(((c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0)))
    away = known.pose - pose
    away[2] = (away[2] + np.pi) % (2.0 * np.pi) - np.pi
    sure = prior * known.spread**-2.0
    own, pull = np.diag(sure), sure * (turned.T @ away)
    inner, shared = np.empty((3, kinds, kinds)), np.empty((3, 3, kinds))
    pulls, work = np.empty((3, kinds)), np.empty((kinds, kinds))
    for channel in range(3):
        # residuals tell the noise
        scale = (_PRIOR + sums.totals[0]) / (_PRIOR + sums.squares[channel])
        normal, certain = scale * sums.normal[channel], tag.spread[:, channel] ** -2.0
        for j in range(kinds + 3):
            normal[:j, j] = normal[j, :j]
        work[:] = normal[:kinds, :kinds] + np.diag(certain)
        invert(work, inner[channel])
        shared[channel] = normal[kinds:, :kinds]
        pulls[channel] = scale * sums.pull[channel, :kinds] + certain * (
            tag.typical[:, channel] - tag.colors[:, channel]
        )
        explained = shared[channel] @ inner[channel]
        own += normal[kinds:, kinds:] - explained @ shared[channel].T
        pull += scale * sums.pull[channel, kinds:] - explained @ pulls[channel]
    invert(own, covariance)
    move = covariance @ pull
    move /= max(max(abs(move[0]), abs(move[1])) / known.spread[0], 1.0)
    for channel in range(3):
        tag.colors[:, channel] += inner[channel] @ (pulls[channel] - shared[channel].T @ move)
    pose += turned @ move
    covariance[:] = turned @ covariance @ turned.T


@compiled_part
def _to_bgr(colors: Floats) -> None:
    """Turn luma and chroma (K + 1, 3) into blue, green and red."""
    for k in range(len(colors)):
        y, b, r = colors[k, 0], colors[k, 1], colors[k, 2]
        colors[k, 0], colors[k, 2] = y + 1.772 * b, y + 1.402 * r
        colors[k, 1] = y - 0.344136 * b - 0.714136 * r
