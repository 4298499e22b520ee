"""Sub-pixel pose: the blurred layout is fitted to the pixels themselves, for all tags at once.

The luma or chroma of a pixel is the sum over the tag's parts (and the floor around it) of coverage
times brightness. The brightnesses are linear unknowns and solved exactly; the pose follows by
Gauss-Newton with them projected out (variable projection, Golub and Pereyra 1973). Everything but
one look-up of the template and its Gram matrix is arithmetic on a few small matrices per tag.

R tags, P pixels, C = 3 channels (luma, two chromas), M = K + 1 parts with the outside. Template
channels come in 4 groups of M: coverage, and its derivatives by a step forward, left and a turn.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.eye import Eye
from vision.palette import BGR_FROM_YCC, YCC_FROM_BGR
from vision.template import Singles

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

_PRIOR_WEIGHT = 20.0  # pixels that the stated noise counts for, against the residuals found
_RIDGE = 1e-3  # pixels of brightness 0 for every part: keeps parts out of sight solvable
_STEP = 0.3  # longest Gauss-Newton step, in half sides of the tag
_SETTLED_PX = 0.15  # after a shorter step no other follows: it would be shorter than 0.01 px
_LEAST = 0.05  # share of the residuals that a step leaves at least
_MODEL_PX = 0.008  # error of the model itself: pixels are squares, not Gaussians
_MODEL_TURN_PX = 0.027  # and of the heading, as a displacement at one side's distance
_NO_MAP = np.empty(0, np.float32)
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
class _Samples:
    """Brightness and colour around every tag; B blocks of 2 x 2 pixels.

    floor: (R, 5 B, 4) homogeneous floor points [m] and row, first those of the 4 B pixels, then
    those of the B colour samples; luma: (R, 4 B, 1); chroma: (R, B, 2); rows: (R,) where the tags'
    templates begin.
    """

    floor: Singles
    luma: Singles
    chroma: Singles
    rows: Indices


@dataclass(frozen=True, slots=True)
class _Step:
    """Normal equations H (R, 3, 3), g (R, 3, 1), and what they were made from.

    bright: (R, C, M) brightness of the parts; in units of the noise, per tag (R,): misfit, the sum
    of squared residuals; slope, of squared derivatives by position; freedom, what the misfit and
    the prior of the noise would be if the noise were as stated.
    """

    normal: Floats
    gradient: Floats
    bright: Floats
    misfit: Floats
    slope: Floats
    freedom: Floats


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
    samples, scale = _cut_out(image, eye, shapes, start)
    poses = start.astype(np.float64, copy=True)
    arm = 0.5 * eye.templates.side  # turns are compared with displacements at this distance
    for _ in range(steps):
        step = _linearised(samples, eye, poses)
        delta = np.asarray(np.linalg.solve(step.normal, step.gradient)[..., 0])
        length = np.fmax(np.hypot(delta[:, 0], delta[:, 1]), arm * np.abs(delta[:, 2]))
        delta /= np.fmax(length / (_STEP * arm), 1.0)[:, None]
        _move(poses, delta)
        if (length * scale < _SETTLED_PX).all():
            break
    return _outcome(poses, step, delta, scale, 2.0 * arm * scale)


def _cut_out(
    image: NDArray[np.uint8], eye: Eye, shapes: Indices, start: Floats
) -> tuple[_Samples, Floats]:
    """Cut a window of whole 2 x 2 blocks around every tag, shifted to lie inside the image."""
    w, h = eye.camera.size_px
    n, templates, count = eye.window_px, eye.templates, len(start)
    points = np.column_stack((start[:, :2], np.full(count, eye.camera.tag_height)))
    center = np.fmax(np.fmin(eye.camera.project(points), (w - 1, h - 1)), 0)
    corners = np.fmax(np.fmin(center - (n / 2 - 1.5), (w - n, h - n)), 0).astype(np.intp) // 2
    x, y = (corners[:, None] + eye.blocks).transpose(2, 0, 1)  # blocks, (R, B)
    luma, chroma = _planes(image, eye, x, y)
    floor = eye.samples[y, x].transpose(0, 2, 1, 3).reshape(count, -1, 4)
    column, row = center.astype(np.intp).T
    level = eye.level[row, column].astype(np.intp)
    rows = (level * templates.shapes + shapes) * templates.pitch
    return _Samples(floor, luma, chroma, rows), templates.scales[level]


def _planes(image: NDArray[np.uint8], eye: Eye, x: Indices, y: Indices) -> tuple[Singles, Singles]:
    """Luma (R, 4 B, 1) and chroma means (R, B, 2) of the blocks at x, y (R, B)."""
    h, w = image.shape[0] // 2, image.shape[1] // 2
    blocks = image[: 2 * h, : 2 * w].reshape(h, 2, w, 2, 3)
    pixels = blocks[y, :, x].astype(np.float32)  # (R, B, 2, 2, 3)
    sums = _block_sums(pixels)
    if eye.optics.chroma.mixed_one_way:  # mix the rows 1 : 6 : 1, as upsampling mixed the columns
        above = _block_sums(blocks[np.fmax(y - 1, 0), :, x].astype(np.float32))
        below = _block_sums(blocks[np.fmin(y + 1, h - 1), :, x].astype(np.float32))
        sums = 0.75 * sums + 0.125 * (above + below)
    luma = pixels.transpose(0, 2, 3, 1, 4).reshape(len(x), -1, 3) @ _LUMA
    return np.asarray(luma, np.float32), np.asarray(sums @ _CHROMA, np.float32)


def _block_sums(pixels: Singles) -> Singles:
    """Sums (R, B, 3) over the four pixels of blocks (R, B, 2, 2, 3)."""
    rows: Singles = pixels[:, :, 0] + pixels[:, :, 1]
    return rows[:, :, 0] + rows[:, :, 1]


def _linearised(samples: _Samples, eye: Eye, poses: Floats) -> _Step:
    """Linearise the picture about the poses and eliminate the brightness of the parts."""
    gram, moment, energy = _sums(samples, eye, poses)
    count, parts = len(poses), eye.templates.parts + 1
    covers = gram[..., :parts, :parts]  # V^T V
    inverse = np.linalg.inv(covers + _RIDGE * eye.templates.unit)
    bright = inverse @ moment[..., :parts, None]  # (R, C, M, 1)
    turned = bright.transpose(0, 1, 3, 2)[:, :, None]
    mixed = (turned @ gram.reshape(count, 3, 4, parts, 4 * parts))[:, :, :, 0]  # (R, C, 4, 4 M)
    products = (mixed.reshape(count, 3, 4, 4, parts) @ bright[:, :, None])[..., 0]
    seen = moment.reshape(count, 3, 4, parts) @ bright  # (R, C, 4, 1)
    squares = np.fmax(energy - 2.0 * seen[..., 0, 0] + products[..., 0, 0], 0.0)
    free = _PRIOR_WEIGHT + np.fmax(np.einsum("rcij->rc", covers) - parts, 1.0)
    free *= (1.0, eye.optics.chroma.independence, eye.optics.chroma.independence)
    precision = free / (_PRIOR_WEIGHT * (max(eye.optics.noise, 0.5) * _NOISE_GAIN) ** 2 + squares)
    shared = mixed[:, :, 1:, :parts]  # J^T V
    own = products[:, :, 1:, 1:]  # J^T J
    reduced = own - shared @ inverse @ shared.transpose(0, 1, 3, 2)
    gradient = seen[:, :, 1:] - products[:, :, 1:, :1]  # J^T (y - V a)
    return _Step(
        np.einsum("rcij,rc->rij", reduced, precision) + _STIFFNESS,
        np.einsum("rcij,rc->rij", gradient, precision),
        bright[..., 0],
        np.einsum("rc,rc->r", squares, precision),
        np.einsum("rc,rc->r", own[..., 0, 0] + own[..., 1, 1], precision),
        np.einsum("rc->r", free),
    )


def _sums(samples: _Samples, eye: Eye, poses: Floats) -> tuple[Floats, Floats, Floats]:
    """Weighted sums over the samples: template by template (R, C, 4 M, 4 M), template by picture
    (R, C, 4 M) and picture by itself (R, C).
    """
    at = samples.floor @ _cells_from_floor(eye, poses, samples.rows)
    cells = np.asarray(cv2.remap(eye.templates.cells, at, _NO_MAP, cv2.INTER_LINEAR), np.float32)
    pixels = samples.luma.shape[1]
    grams, moments, energies = [], [], []
    for part, values in ((cells[:, :pixels], samples.luma), (cells[:, pixels:], samples.chroma)):
        model, picture = part[..., 1:], values * part[..., :1]
        turned = model.transpose(0, 2, 1)
        grams.append(turned @ model)
        moments.append((turned @ picture).transpose(0, 2, 1))
        energies.append(np.einsum("rpc,rpc->rc", picture, picture))
    gram = np.stack((grams[0], grams[1], grams[1]), axis=1, dtype=np.float64)
    moment, energy = (np.concatenate(s, axis=1, dtype=np.float64) for s in (moments, energies))
    return gram, moment, energy


def _cells_from_floor(eye: Eye, poses: Floats, rows: Indices) -> Singles:
    """Matrices (R, 4, 2) that take floor points to cells of the tags' templates."""
    pitch = 1.0 / eye.templates.cell
    x, y, theta = poses.T
    c, s = pitch * np.cos(theta), pitch * np.sin(theta)
    middle = eye.templates.n // 2
    matrix = np.empty((len(poses), 4, 2), np.float32)
    matrix[:, 0, 0], matrix[:, 0, 1] = c, -s
    matrix[:, 1, 0], matrix[:, 1, 1] = s, c
    matrix[:, 2, 0], matrix[:, 2, 1] = middle - c * x - s * y, middle + rows + s * x - c * y
    matrix[:, 3] = (0.0, 1.0)
    return matrix


def _move(poses: Floats, delta: Floats) -> None:
    """Add steps (R, 3) in the tags' own frames to poses (R, 3) on the floor."""
    dx, dy, turn = delta.T
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    poses[:, 0] += c * dx - s * dy
    poses[:, 1] += s * dx + c * dy
    poses[:, 2] += turn


def _outcome(poses: Floats, step: _Step, delta: Floats, scale: Floats, side_px: Floats) -> Fit:
    """Gather the outcome of the last step, with what it took off the residuals."""
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    turn = np.zeros((len(poses), 3, 3))
    turn[:, 0, 0] = turn[:, 1, 1] = c
    turn[:, 0, 1], turn[:, 1, 0], turn[:, 2, 2] = -s, s, 1.0
    gain = np.einsum("ri,ri->r", delta, step.gradient[..., 0])
    left = np.fmax(1.0 - gain / step.freedom, _LEAST)[:, None, None]
    covariances = turn @ (left * np.linalg.inv(step.normal)) @ turn.transpose(0, 2, 1)
    covariances[:, 0, 0] += (_MODEL_PX / scale) ** 2
    covariances[:, 1, 1] += (_MODEL_PX / scale) ** 2
    covariances[:, 2, 2] += (_MODEL_TURN_PX / side_px) ** 2
    misfit = np.fmax(step.misfit - gain, _LEAST * step.misfit)
    residual = np.sqrt(misfit / np.fmax(step.slope, 1e-9)) * scale
    colors = step.bright[:, :, :-1].transpose(0, 2, 1) @ BGR_FROM_YCC.T
    return Fit(poses, covariances, residual, colors)
