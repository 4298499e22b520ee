"""Sub-pixel pose: the blurred layout is fitted to the samples themselves, never to thresholds.

Every tag by itself, by Gauss-Newton from its starting pose; the steps are in `elimination`.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vision.compiled import compiled, compiled_part
from vision.elimination import (
    COVERS,
    WEIGHT,
    accumulate,
    dot,
    invert,
    look_up,
    part_colors,
    solve_brightness,
)
from vision.fit import Fit, empty_fit
from vision.floor_map import PITCH, around, pixel_slopes
from vision.gauge import Gauge, Plane
from vision.samples import Lattice, Usage, Window, collect, see_bgr, see_chroma, see_luma

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Bytes = NDArray[np.uint8]
Indices = NDArray[np.intp]

_PRIOR_WEIGHT = 20.0  # samples that the stated noise counts for, against the residuals found
_STEP = 0.3  # longest Gauss-Newton step, in arms: half sides of the largest tag
_SETTLED_PX, _LEFT = 0.15, 0.7  # after a shorter step no other follows, nor if its square, about
# what it leaves, is below this share of what noise does
_ASTRAY_PX = (3.0, 0.7)  # samples are collected anew after a longer way, coarse and all
_NEAR_PX = 1.0  # after a shorter step all samples are looked at
_MOST_SAMPLES = 2048  # of a tag; thinning leaves half as many
_ROUNDING = 1.0 / 12.0  # no picture is truer than its rounding to whole numbers: variance
_LEAST = 0.05  # share of the residuals that a step leaves at least
_STIFFNESS_M, _STIFFNESS_RAD = 0.1, 10.0  # known beforehand: keeps blind fits solvable


class _Room(NamedTuple):
    """Memory to work in: floor points of samples, their values and tables, for each plane; which
    pixels they are; unknowns a (3, M) and their normal matrices (3, M, M); the pose's normal
    equations (2, 3, 3) and gradients (4, 3); numbers of samples.
    """

    places: Singles
    values: Singles
    tables: Singles
    chosen: NDArray[np.int32]
    bright: Floats
    inner: Floats
    normal: Floats
    gradient: Floats
    counts: Indices


class _Spot(NamedTuple):
    """How a tag is looked for: index of its scale, of its geometry, of its heading's turn; whether
    coarsely (0) or fully (1).
    """

    level: int
    shape: int
    turn: int
    look: int


def fit_poses(
    image: Bytes, gauge: Gauge, shapes: Indices, start: Floats, centers: Floats, steps: int
) -> Fit:
    """Fit tags to the picture, each from its own starting pose.

    Args:
        image: shape (H, W, 3), BGR.
        gauge: templates, floor map and noise.
        shapes: shape (R,), geometry of every tag.
        start: shape (R, 3), x, y, theta on the floor [m, m, rad].
        centers: shape (R, 2), where that is in the image [px].
        steps: number of Gauss-Newton steps, at least 1.

    Returns:
        The fitted tags, in the same order.
    """
    parts = gauge.pixels.cells.shape[-1]
    fit = empty_fit(len(start), parts)
    fit.poses[:] = start
    _fit_all(
        image, gauge, shapes, centers.copy(), steps, _room(gauge, parts),
        fit.poses, fit.covariances, fit.residual_px, fit.colors, fit.settled,
    )  # fmt: skip
    return fit


def _room(gauge: Gauge, parts: int) -> _Room:
    """Memory for the largest tag."""
    most = min(int(3.2 * (gauge.radius + 2) ** 2), _MOST_SAMPLES)
    return _Room(
        np.empty((2, 2, most), np.float32), np.empty((2, 3, most), np.float32),
        np.empty((2, COVERS + 3 * parts + 3 + 4, most), np.float32),
        np.empty((2, most), np.int32), np.empty((3, parts + 1)),
        np.empty((3, parts + 1, parts + 1)), np.empty((2, 3, 3)), np.empty((4, 3)),
        np.zeros(2, np.intp),
    )  # fmt: skip


@compiled
def _fit_all(
    image: Bytes, g: Gauge, shapes: Indices, centers: Floats, steps: int, room: _Room,
    poses: Floats, covariances: Floats, residual_px: Floats, colors: Floats,
    settled: NDArray[np.bool_],
) -> None:  # fmt: skip
    """Fit tag after tag; poses: start, and outcome."""
    for n in range(len(poses)):
        residual_px[n], settled[n] = _fit_one(
            image, g, shapes[n], centers[n], steps, room, poses[n], covariances[n]
        )
        part_colors(room.bright, len(g.pixels.noise) == 3, colors[n])


@compiled_part
def _fit_one(
    image: Bytes, g: Gauge, shape: int, center: Floats, steps: int, room: _Room,
    pose: Floats, covariance: Floats,
) -> tuple[float, bool]:  # fmt: skip
    """Fit a tag; returns the rms misfit as a displacement of edges [px], and whether it settled."""
    rows, columns = g.level.shape
    level = g.level[
        _within(center[1] / PITCH + 0.5, rows), _within(center[0] / PITCH + 0.5, columns)
    ]
    scale, turns = g.scales[level], g.pixels.cells.shape[2]
    gradient, delta, local = room.gradient[0], room.gradient[1], room.gradient[2]
    x, y, tilt, away, sums = pose[0], pose[1], 0.0, np.inf, (0.0, 0.0, 1.0)
    look, settled = 0 if g.coarse_pays[level, shape] and steps > 1 else 1, False
    for step in range(steps):
        if away * scale > _ASTRAY_PX[look]:
            tilt = _follow(g.nodes, pose[0] - x, pose[1] - y, center)
            x, y, away = pose[0], pose[1], 0.0
            _collect(image, g, _Spot(level, shape, 0, look), pose, center, room)
        turn = int(np.floor((pose[2] - tilt) * (2.0 * turns / np.pi) + 0.5)) % turns
        local[0], local[1], local[2] = pose[0] - x, pose[1] - y, pose[2]
        sums = _linearise(g, _Spot(level, shape, turn, look), local, room)
        invert(room.normal[0], covariance)
        length = _step(covariance, gradient, g.arm, pose, delta)
        away += length
        if look == 0 and (length * scale < _NEAR_PX or step == steps - 2):
            look, away = 1, np.inf  # near enough for all samples
        elif length * scale < min(_SETTLED_PX, np.sqrt(_LEFT * _deviation(covariance) * scale)):
            settled = True
            break
    misfit, slope, freedom = sums
    gain = delta[0] * gradient[0] + delta[1] * gradient[1] + delta[2] * gradient[2]
    _turn(covariance, pose[2], max(1.0 - gain / freedom, _LEAST))
    misfit = max(misfit - gain, _LEAST * misfit)
    return float(np.sqrt(misfit / max(slope, 1e-9)) * scale), settled


@compiled_part
def _within(position: float, count: int) -> int:
    """Index of a position on an axis, clipped to it; nan becomes 0."""
    return int(min(count - 1.0, max(0.0, position)))


@compiled_part
def _follow(nodes: Floats, dx: float, dy: float, center: Floats) -> float:
    """Move a tag's centre in the image as its pose moved; returns the rows' direction there."""
    a, b, c, d = pixel_slopes(nodes, center[0], center[1])
    center[0] += a * dx + b * dy
    center[1] += c * dx + d * dy
    return float(np.arctan2(-c, d))  # one column is (d, -c) / (a d - b c) on the floor


@compiled_part
def _collect(
    image: Bytes, g: Gauge, spot: _Spot, pose: Floats, center: Floats, room: _Room
) -> None:
    """Collect the samples around a pose."""
    x, y = _within(center[0] + 0.5, image.shape[1]), _within(center[1] + 0.5, image.shape[0])
    window, size_px, chosen = Window(x, y, g.radius), image.shape[:2], room.chosen
    patch = around(g.nodes, x, y, g.radius)
    count = collect(
        size_px, patch, _usage(g.pixels, spot), Lattice(1, 0.0, 0.0), pose, window,
        room.places[0], chosen,
    )  # fmt: skip
    room.counts[0] = count
    if len(g.pixels.noise) == 3:
        see_bgr(image, chosen, count, room.values[0])
        return
    see_luma(image, chosen, count, room.values[0])
    colors = Lattice(2, g.offset[0], g.offset[1])
    count = collect(
        size_px, patch, _usage(g.colors, spot), colors, pose, window, room.places[1], chosen
    )
    room.counts[1] = count
    see_chroma(image, chosen, count, g.mix_rows, room.values[1])


@compiled_part
def _usage(plane: Plane, spot: _Spot) -> Usage:
    """Which samples of a tag are used."""
    level, shape, look = spot.level, spot.shape, spot.look
    steps = plane.strides[level, shape, look]
    return Usage(
        plane.usage[level, shape], plane.shares[level, shape, look], (steps[0], steps[1]),
        plane.cell,
    )  # fmt: skip


@compiled_part
def _linearise(g: Gauge, spot: _Spot, local: Floats, room: _Room) -> tuple[float, float, float]:
    """Set up the normal equations at a pose; returns misfit, slope [1/m^2] and freedom."""
    normal, gradient = room.normal[0], room.gradient[0]
    for j in range(3):
        gradient[j] = 0.0
        for k in range(3):
            normal[j, k] = 0.0
        normal[j, j] = (_STIFFNESS_M if j < 2 else _STIFFNESS_RAD) ** -2
    misfit, slope, freedom = _add(g.pixels, spot, local, room)
    if len(g.pixels.noise) == 1:
        more = _add(g.colors, spot, local, room)
        misfit, slope, freedom = misfit + more[0], slope + more[1], freedom + more[2]
    return misfit, slope, freedom


@compiled_part
def _add(plane: Plane, spot: _Spot, local: Floats, room: _Room) -> tuple[float, float, float]:
    """Add the samples of a plane to the normal equations; returns misfit, slope and freedom."""
    cells, channels = plane.cells[spot.level, spot.shape, spot.turn], len(plane.noise)
    first, parts = plane.plane, cells.shape[2]
    table, count = room.tables[first], room.counts[first]
    inverse, own, pull = room.inner[0], room.normal[1], room.gradient[3]
    look_up(
        cells, plane.cell, local, room.places[first], room.values[first], plane.noise, count, table
    )
    solve_brightness(table, count, parts, channels, room.inner, room.bright[first:])
    weights = dot(table[WEIGHT], table[WEIGHT], count)
    free = (_PRIOR_WEIGHT + max(weights - parts - 1, 1.0)) * plane.independence
    misfit, slope, cell = 0.0, 0.0, plane.cell
    for channel in range(channels):
        squares, steep = accumulate(
            table, count, parts, channel, inverse, room.bright[first + channel], own, pull
        )
        precision = free / (_PRIOR_WEIGHT * plane.noise[channel] ** 2 + squares)
        for j in range(3):
            share = precision * (1.0 / cell if j < 2 else 1.0)
            room.gradient[0, j] += share * pull[j]
            for k in range(3):
                room.normal[0, j, k] += share * (1.0 / cell if k < 2 else 1.0) * own[j, k]
        misfit += precision * max(squares, _ROUNDING * weights)  # without contrast: nothing fits
        slope += precision * steep / cell**2
    return misfit, slope, free * channels


@compiled_part
def _step(inverse: Floats, gradient: Floats, arm: float, pose: Floats, delta: Floats) -> float:
    """Move a pose by a Gauss-Newton step, at most `_STEP` arms; returns its full length [m]."""
    for j in range(3):
        delta[j] = 0.0
        for k in range(3):
            delta[j] += inverse[j, k] * gradient[k]
    length = float(max(np.hypot(delta[0], delta[1]), arm * abs(delta[2])))
    delta /= max(length / (_STEP * arm), 1.0)
    c, s = np.cos(pose[2]), np.sin(pose[2])
    pose[0] += c * delta[0] - s * delta[1]
    pose[1] += s * delta[0] + c * delta[1]
    pose[2] += delta[2]
    return length


@compiled_part
def _deviation(covariance: Floats) -> float:
    """Standard deviation of a place [m]."""
    return float(np.sqrt(covariance[0, 0] + covariance[1, 1]))


@compiled_part
def _turn(covariance: Floats, heading: float, scale: float) -> None:
    """Turn a covariance from the tag's frame to the floor's, and scale it."""
    c, s = np.cos(heading), np.sin(heading)
    xx, xy, yy = covariance[0, 0], covariance[0, 1], covariance[1, 1]
    xt, yt = covariance[0, 2], covariance[1, 2]
    covariance[0, 0] = scale * (c * c * xx - 2.0 * c * s * xy + s * s * yy)
    covariance[1, 1] = scale * (s * s * xx + 2.0 * c * s * xy + c * c * yy)
    covariance[0, 1] = covariance[1, 0] = scale * (c * s * (xx - yy) + (c * c - s * s) * xy)
    covariance[0, 2] = covariance[2, 0] = scale * (c * xt - s * yt)
    covariance[1, 2] = covariance[2, 1] = scale * (s * xt + c * yt)
    covariance[2, 2] *= scale
