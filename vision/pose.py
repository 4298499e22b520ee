"""Sub-pixel pose: the blurred layout is fitted to the pixels themselves, for all tags at once.

The luma or chroma of a pixel is the sum over the tag's parts (and the floor around it) of coverage
times brightness. The brightnesses are linear unknowns and solved exactly; the pose follows by
Gauss-Newton with them projected out (variable projection, Golub and Pereyra 1973). Everything but
one look-up of the template and its Gram matrix is arithmetic on a few small matrices per tag.

R tags, P pixels, C = 3 channels (luma, two chromas), M = K + 1 parts with the outside. Template
channels come in 4 groups of M: coverage, and its derivatives by a step forward, left and a turn.
"""

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.eye import Eye
from vision.palette import BGR_FROM_YCC, YCC_FROM_BGR
from vision.template import Singles

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
_Window = NDArray[Any]

_PRIOR_WEIGHT = 20.0  # pixels that the stated noise counts for, against the residuals found
_RIDGE = 1e-3  # pixels of brightness 0 for every part: keeps parts out of sight solvable
_STEP = 0.15  # longest Gauss-Newton step, in sides of the tag
_TURN = 0.3  # largest Gauss-Newton turn [rad]
_SETTLED_M, _SETTLED_RAD = 1.0 / 2e-4, 1.0 / 5e-3  # inverse of steps after which none follows
_MODEL_PX = 0.008  # error of the model itself: pixels are squares, not Gaussians
_MODEL_TURN_PX = 0.027  # and of the heading, as a displacement at one side's distance
_STIFFNESS = np.diag((1e2, 1e2, 1e-2))  # as if known to 0.1 m, 10 rad: keeps blind fits solvable
_LUMA = YCC_FROM_BGR[:1].T.astype(np.float32)
_CHROMA = (YCC_FROM_BGR[1:].T / 4.0).astype(np.float32)  # of the sum of 4 pixels
_NOISE_GAIN = np.hypot.reduce(YCC_FROM_BGR, axis=1) * (1.0, 0.5, 0.5)  # chroma: mean of 4 pixels


@dataclass(frozen=True, slots=True)
class Fit:
    """Fitted tags.

    Attributes:
        poses: shape (R, 3), x, y, theta on the floor [m, m, rad].
        covariances: shape (R, 3, 3) [m^2, m rad, rad^2].
        residual_px: shape (R,), rms misfit as a displacement of edges [px].
        colors: shape (R, K, 3), BGR of every part as it would look without blur.
    """

    poses: Floats
    covariances: Floats
    residual_px: Floats
    colors: Floats


@dataclass(frozen=True, slots=True)
class _Plane:
    """The pixels of luma or chroma around every tag.

    floor: (R, P, 3) homogeneous floor points [m]; values: (R, P, 1) luma or (R, P, 2) chromas;
    rows: (R,) where the tags' templates begin.
    """

    floor: Singles
    values: Singles
    rows: Indices


@dataclass(frozen=True, slots=True)
class _Step:
    """Normal equations H (R, 3, 3), g (R, 3), and per channel what they were made from.

    bright: (R, C, M) brightness of the parts; own: (R, C, 3, 3) J^T J; squares: (R, C) sum of
    squared residuals; precision: (R, C) inverse variance of a pixel.
    """

    normal: Floats
    gradient: Floats
    bright: Floats
    own: Floats
    squares: Floats
    precision: Floats


def fit_poses(
    image: NDArray[np.uint8], eye: Eye, shapes: Indices, start: Floats, steps: int
) -> Fit:
    """Fit tags to the picture, each from its own starting pose.

    Args:
        image: shape (H, W, 3), BGR.
        eye: templates, floor points and noise.
        shapes: shape (R,), R >= 1, geometry of every tag, an index of `eye.shapes`.
        start: shape (R, 3), x, y, theta on the floor [m, m, rad].
        steps: number of Gauss-Newton steps, at least 1.

    Returns:
        The fitted tags, in the same order.
    """
    planes, scale = _cut_out(image, eye, shapes, start)
    poses = start.astype(np.float64, copy=True)
    side = eye.tags.tags[0].side
    longest = _STEP * side
    for _ in range(steps):
        step = _linearised(planes, eye, poses)
        delta = _shortened(np.asarray(np.linalg.solve(step.normal, step.gradient)[..., 0]), longest)
        poses += _in_floor_frame(poses[:, 2], delta)
        if (np.abs(delta) * (_SETTLED_M, _SETTLED_M, _SETTLED_RAD)).max() < 1.0:
            break
    return _outcome(poses, step, scale, scale * side)


def _cut_out(
    image: NDArray[np.uint8], eye: Eye, shapes: Indices, start: Floats
) -> tuple[tuple[_Plane, _Plane], Floats]:
    """Cut a window of whole 2 x 2 blocks around every tag, shifted to lie inside the image."""
    w, h = eye.camera.size_px
    n = eye.window_px
    points = np.column_stack((start[:, :2], np.full(len(start), eye.camera.tag_height)))
    center = np.clip(np.nan_to_num(eye.camera.project(points)), 0, (w - 1, h - 1))
    corners = np.clip(center - (0.5 * n - 1.5), 0, (w - n, h - n)) // 2 * 2
    places = corners.astype(int).tolist()
    pixels = _blocks(eye, [image[y : y + n, x : x + n] for x, y in places]).astype(np.float32)
    floor = _blocks(eye, [eye.floor[y : y + n, x : x + n] for x, y in places])
    half = [eye.block_floor[y // 2 : (y + n) // 2, x // 2 : (x + n) // 2] for x, y in places]
    count = len(start)
    block_floor = np.stack(half).reshape(count, -1, 3)
    means = pixels.sum(axis=2)
    if eye.optics.chroma.mixed_one_way:
        means = _mixed_down(means, n // 2)
    luma = pixels.take(eye.blocks, axis=1).reshape(count, -1, 3) @ _LUMA
    chroma = means.take(eye.blocks, axis=1) @ _CHROMA
    level = eye.level[tuple(center.astype(int).T[::-1])].astype(np.intp)
    templates = eye.templates
    rows = (level * templates.shapes + shapes) * templates.pitch
    floor, block_floor = floor.take(eye.blocks, axis=1), block_floor.take(eye.blocks, axis=1)
    return (
        _Plane(floor.reshape(count, -1, 3), luma, rows),
        _Plane(block_floor, chroma, rows + templates.chroma_row),
    ), templates.scales[level]


def _blocks(eye: Eye, windows: list[_Window]) -> _Window:
    """All 2 x 2 blocks of windows (n, n, 3) as one array (R, b * b, 4, 3)."""
    b = eye.window_px // 2
    split = np.stack(windows).reshape(-1, b, 2, b, 2, 3).transpose(0, 1, 3, 2, 4, 5)
    return split.reshape(-1, b * b, 4, 3)


def _mixed_down(means: Singles, b: int) -> Singles:
    """Mix the rows of block means (R, b * b, 3) 1 : 6 : 1, as upsampling mixed the columns."""
    rows = means.reshape(-1, b, b, 3)
    mixed = 0.75 * rows
    mixed[:, 1:] += 0.125 * rows[:, :-1]
    mixed[:, :-1] += 0.125 * rows[:, 1:]
    return mixed.reshape(means.shape)


def _linearised(planes: tuple[_Plane, _Plane], eye: Eye, poses: Floats) -> _Step:
    """Linearise the picture about the poses and eliminate the brightness of the parts."""
    gram, moment, energy = _sums(planes, eye, poses)
    count, parts = len(poses), eye.templates.parts + 1
    covers = gram[..., :parts, :parts]  # V^T V
    inverse = np.linalg.inv(covers + _RIDGE * np.eye(parts))
    bright = inverse @ moment[..., :parts, None]  # (R, C, M, 1)
    turned = bright.transpose(0, 1, 3, 2)[:, :, None]
    mixed = (turned @ gram.reshape(count, 3, 4, parts, 4 * parts))[:, :, :, 0]  # (R, C, 4, 4 M)
    products = (mixed.reshape(count, 3, 4, 4, parts) @ bright[:, :, None])[..., 0]
    seen = moment.reshape(count, 3, 4, parts) @ bright  # (R, C, 4, 1)
    squares = np.maximum(energy - 2.0 * seen[..., 0, 0] + products[..., 0, 0], 0.0)
    free = _PRIOR_WEIGHT + np.maximum(covers.sum(axis=(2, 3)) - parts, 1.0)
    free[:, 1:] *= eye.optics.chroma.independence
    precision = free / (_PRIOR_WEIGHT * (max(eye.optics.noise, 0.5) * _NOISE_GAIN) ** 2 + squares)
    shared = mixed[:, :, 1:, :parts]  # J^T V
    own = products[:, :, 1:, 1:]  # J^T J
    reduced = own - shared @ inverse @ shared.transpose(0, 1, 3, 2)
    gradient = seen[:, :, 1:] - products[:, :, 1:, :1]  # J^T (y - V a)
    weight = precision[..., None, None]
    normal = (reduced * weight).sum(axis=1) + _STIFFNESS
    total = (gradient * weight).sum(axis=1)
    return _Step(normal, total, bright[..., 0], own, squares, precision)


def _sums(planes: tuple[_Plane, _Plane], eye: Eye, poses: Floats) -> tuple[Floats, Floats, Floats]:
    """Weighted sums over the pixels: template by template (R, C, 4 M, 4 M), template by picture
    (R, C, 4 M) and picture by itself (R, C).
    """
    to_cells = _cells_from_floor(eye, poses)
    rows = to_cells[:, 2, 1].copy()
    grams, moments, energies = [], [], []
    for plane in planes:
        to_cells[:, 2, 1] = rows + plane.rows
        cells = _looked_up(eye.templates.cells, plane.floor @ to_cells)
        model, picture = cells[..., 1:], plane.values * cells[..., :1]
        turned = model.transpose(0, 2, 1)
        grams.append(turned @ model)
        moments.append((turned @ picture).transpose(0, 2, 1))
        energies.append(np.einsum("rpc,rpc->rc", picture, picture))
    gram = np.stack((grams[0], grams[1], grams[1]), axis=1, dtype=np.float64)
    moment, energy = (np.concatenate(s, axis=1, dtype=np.float64) for s in (moments, energies))
    return gram, moment, energy


def _looked_up(cells: Singles, at: Singles) -> Singles:
    """All channels of the templates at cells (R, P, 2), between cells by linear interpolation."""
    empty = np.empty(0, np.float32)
    return np.asarray(cv2.remap(cells, at, empty, cv2.INTER_LINEAR), np.float32)


def _cells_from_floor(eye: Eye, poses: Floats) -> Singles:
    """Matrices (R, 3, 2) that take homogeneous floor points to the tags' template cells."""
    pitch = 1.0 / eye.templates.cell
    c, s = pitch * np.cos(poses[:, 2]), pitch * np.sin(poses[:, 2])
    x, y = poses[:, 0], poses[:, 1]
    middle = eye.templates.n // 2
    matrix = np.array([[c, -s], [s, c], [middle - c * x - s * y, middle + s * x - c * y]])
    return np.ascontiguousarray(matrix.transpose(2, 0, 1), np.float32)


def _shortened(delta: Floats, longest: float) -> Floats:
    """Shorten steps (R, 3) that are too long to be trusted."""
    reach = np.hypot(delta[:, 0], delta[:, 1]) / longest
    shortened: Floats = delta / np.fmax(np.fmax(reach, np.abs(delta[:, 2]) / _TURN), 1.0)[:, None]
    return shortened


def _in_floor_frame(theta: Floats, delta: Floats) -> Floats:
    """Turn steps (R, 3) from the tags' frames to the floor's."""
    c, s = np.cos(theta), np.sin(theta)
    dx, dy, turn = delta.T
    return np.column_stack((c * dx - s * dy, s * dx + c * dy, turn))


def _outcome(poses: Floats, step: _Step, scale: Floats, side_px: Floats) -> Fit:
    """Gather the outcome of the last step."""
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    turn = np.zeros((len(poses), 3, 3))
    turn[:, 0, 0] = turn[:, 1, 1] = c
    turn[:, 0, 1], turn[:, 1, 0], turn[:, 2, 2] = -s, s, 1.0
    covariances = turn @ np.linalg.inv(step.normal) @ turn.transpose(0, 2, 1)
    covariances[:, 0, 0] += (_MODEL_PX / scale) ** 2
    covariances[:, 1, 1] += (_MODEL_PX / scale) ** 2
    covariances[:, 2, 2] += (_MODEL_TURN_PX / side_px) ** 2
    misfit = (step.squares * step.precision).sum(axis=1)
    slope = ((step.own[..., 0, 0] + step.own[..., 1, 1]) * step.precision).sum(axis=1)
    residual = np.sqrt(misfit / np.maximum(slope, 1e-9)) * scale
    colors = step.bright[:, :, :-1].transpose(0, 2, 1) @ BGR_FROM_YCC.T
    return Fit(poses, covariances, residual, colors)
