"""Fitted candidates: accepted, one per robot, or rejected with the numbers that decided."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from control.geometry import Pose2D, wrap_angle
from vision.compiled import compiled
from vision.eye import Eye
from vision.identify import Candidates
from vision.palette import LEVELS
from vision.pose import Fit
from vision.projection import Lens, project_point
from vision.scene import Detection, PixelPose, Rejection
from vision.shapes import Looks

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

_BORDER_PX = 0.25  # a tag may reach so far beyond the image
_APART = 0.85  # plates nearer than this share of their width are two readings of one place
_AHEAD = 1e-3  # points so far before and behind the centre give the heading on the screen [m]
_LIT = (-0.6, 0.1)  # log brightness for which the palette is right
_DARK, _BRIGHT = 20.0, 250.0  # values beyond tell nothing of the light
_TYPICAL = 80.0  # neither does a channel of which a colour has less
_REPEATED, _TAKEN = -1, -2  # why an acceptable candidate is not accepted


@dataclass(frozen=True, slots=True)
class Verdict:
    """Scores of fitted candidates.

    Attributes:
        scores: shape (N, T), probability of the colours of the least certain part if candidate n
            wears tag t, 0 where it is not possible.
        sound: shape (N,), whether place and misfit are those of a tag, whatever the colours.
        good: shape (N,), whether the candidate can be accepted.
        moved: shape (N,), way of the fit from where it began [m].
        overhang: shape (N,), how far the plate reaches beyond the image [px].
        screen: shape (N, 3), where they are in the image [px, px, rad].
    """

    scores: Floats
    sound: NDArray[np.bool_]
    good: NDArray[np.bool_]
    moved: Floats
    overhang: Floats
    screen: Floats


def judge(
    fit: Fit,
    candidates: Candidates,
    eye: Eye,
    possible: NDArray[np.bool_],
    gains: Floats,
    slack: float = 1.0,
) -> Verdict:
    """Decide which candidates look like which tag.

    Args:
        fit: the outcome of the fit.
        candidates: where the fit began.
        eye: tags, palette and thresholds.
        possible: shape (N, T), which tag each candidate may be.
        gains: shape (3,), factors of the light on the palette's colours, BGR.
        slack: factor on the light's spread; robots found where they are expected may have a
            shadow's rim on them.

    Returns:
        Scores and what decides.
    """
    limits, count = eye.thresholds, len(fit.poses)
    verdict = Verdict(
        np.zeros(possible.shape), np.empty(count, np.bool_), np.empty(count, np.bool_),
        np.empty(count), np.empty(count), np.empty((count, 3)),
    )  # fmt: skip
    _score(
        fit.colors, candidates.shapes, eye.looks, eye.palette.posterior, gains, possible,
        slack * limits.light_spread, verdict.scores,
    )  # fmt: skip
    _to_screen(
        fit.poses, candidates.shapes, eye.looks, eye.camera.lens, eye.camera.tag_height,
        eye.camera.size_px, verdict.screen, verdict.overhang,
    )  # fmt: skip
    _compare(
        fit.poses, candidates.poses, fit.residual_px, verdict.overhang, verdict.scores, eye.radius,
        limits.residual_px, limits.confidence, verdict.moved, verdict.sound, verdict.good,
    )  # fmt: skip
    return verdict


def assign(
    verdict: Verdict, fit: Fit, candidates: Candidates, eye: Eye, taken: Floats
) -> tuple[Indices, tuple[Rejection, ...]]:
    """Give every acceptable candidate its robot, every robot and place at most once.

    Args:
        verdict: scores and reasons.
        fit: the outcome of the fit.
        candidates: where the fit began.
        eye: tags and camera.
        taken: shape (M, 2), places of robots already found [m].

    Returns:
        Index of the tag of every candidate, negative for none, shape (N,); rejections.
    """
    nearest = 2.0 * _APART * min(shape.inner_radius for shape in eye.shapes)
    tags = np.empty(len(fit.poses), np.intp)
    order = np.lexsort((fit.residual_px, ~verdict.good))
    limit = eye.thresholds.confidence
    _settle(verdict.scores, verdict.good, order, fit.poses, taken, nearest, limit, tags)
    rejected = [
        _rejection(verdict, n, _why_not(verdict, fit, candidates, eye, n, tags))
        for n in np.flatnonzero(tags < 0).tolist()
        if tags[n] != _REPEATED
    ]
    return tags, tuple(rejected)


def detections_of(verdict: Verdict, fit: Fit, tags: Indices, eye: Eye) -> tuple[Detection, ...]:
    """Put together what is known of accepted candidates.

    Args:
        verdict: scores and places on the screen.
        fit: the outcome of the fit.
        tags: shape (N,), index of the tag of every candidate, negative for none.
        eye: tags.

    Returns:
        The detections.
    """
    covariances = fit.covariances.view()
    covariances.flags.writeable = False
    ids, poses, screen = eye.tags.ids, fit.poses.tolist(), verdict.screen.tolist()
    return tuple(
        Detection(
            ids[tag], Pose2D(poses[n][0], poses[n][1], wrap_angle(poses[n][2])),
            PixelPose(*screen[n]), covariances[n], float(fit.residual_px[n]),
            float(verdict.scores[n, tag]),
        )
        for n, tag in enumerate(tags.tolist())
        if tag >= 0
    )  # fmt: skip


def light_ratios(fit: Fit, tags: Indices, eye: Eye) -> Floats:
    """Colours of accepted tags over what the palette has learned.

    Args:
        fit: the outcome of the fit.
        tags: shape (N,), index of the tag of every candidate, negative for none.
        eye: tags and palette.

    Returns:
        Shape (N, K, 3), BGR of every part; NaN where there is none or it is too dark or saturated.
    """
    ratios = np.full((len(tags), eye.looks.classes.shape[1], 3), np.nan)
    _compare_colors(fit.colors, tags, eye.looks, ratios)
    return ratios


@compiled
def _compare_colors(colors: Floats, tags: Indices, looks: Looks, ratios: Floats) -> None:
    """Fill in the ratios of the coloured parts of accepted tags."""
    for n in range(len(tags)):
        for k in range(looks.classes.shape[1]):
            if tags[n] < 0 or looks.classes[tags[n], k] == 0:
                continue
            for channel in range(3):
                seen, typical = colors[n, k, channel], looks.typical[tags[n], k, channel]
                if typical > _TYPICAL and _DARK < seen < _BRIGHT:
                    ratios[n, k, channel] = seen / typical


@compiled
def _compare(
    poses: Floats, starts: Floats, residual_px: Floats, overhang: Floats, scores: Floats,
    radius: float, most_px: float, confidence: float,
    moved: Floats, sound: NDArray[np.bool_], good: NDArray[np.bool_],
) -> None:  # fmt: skip
    """Hold fits against the thresholds."""
    for n in range(len(poses)):
        moved[n] = np.hypot(poses[n, 0] - starts[n, 0], poses[n, 1] - starts[n, 1])
        near = overhang[n] <= _BORDER_PX and moved[n] < radius
        sound[n] = near and residual_px[n] < most_px
        good[n] = sound[n] and scores[n].max() >= confidence


@compiled
def _score(
    colors: Floats, shapes: Indices, looks: Looks, posterior: NDArray[np.float32], gains: Floats,
    possible: NDArray[np.bool_], spread: float, scores: Floats,
) -> None:  # fmt: skip
    """Probability (N, T) of the least certain coloured part, all parts being in the same light.

    A tag in a shadow is judged as if it were lit as the palette knows it.
    """
    for n in range(len(shapes)):
        for tag in range(possible.shape[1]):
            if not possible[n, tag] or looks.shape_of[tag] != shapes[n]:
                continue
            darkest, brightest = np.inf, -np.inf
            for k in range(looks.classes.shape[1]):
                if looks.classes[tag, k] > 0:
                    light = _lightness(colors[n, k], looks.typical[tag, k], gains)
                    darkest, brightest = min(darkest, light), max(brightest, light)
            middle = 0.5 * (darkest + brightest)
            local = gains * np.exp(middle - min(max(middle, _LIT[0]), _LIT[1]))
            contrast, least = (brightest - darkest) / spread, 1.0
            for k in range(looks.classes.shape[1]):
                kind = looks.classes[tag, k]
                if kind > 0:
                    least = min(least, posterior[_packed(colors[n, k], local), kind])
            scores[n, tag] = least * np.exp(-0.5 * contrast * contrast)


@compiled
def _packed(color: Floats, gains: Floats) -> int:
    """A colour (3,) as the palette would have seen it, packed to 15 bit; nan is black."""
    place = 0
    for channel in range(2, -1, -1):
        value = color[channel] / gains[channel]
        cell = 0 if not value > 0.0 else min(int(value), 255) >> 3
        place = place * LEVELS + cell
    return place


@compiled
def _lightness(color: Floats, typical: Floats, gains: Floats) -> float:
    """Logarithm of the light on a part, told by its brightness."""
    shared, square = 0.0, 1e-9
    for channel in range(3):
        shared += color[channel] / gains[channel] * typical[channel]
        square += typical[channel] * typical[channel]
    return float(np.log(max(shared / square, 1e-3)))


@compiled
def _to_screen(
    poses: Floats, shapes: Indices, looks: Looks, lens: Lens, height: float,
    size_px: tuple[int, int], screen: Floats, overhang: Floats,
) -> None:  # fmt: skip
    """Poses on the screen, and how far plates reach beyond the image; inf behind the camera."""
    for n in range(len(poses)):
        x, y, theta = poses[n]
        c, s = np.cos(theta), np.sin(theta)
        screen[n, 0], screen[n, 1] = project_point(lens, x, y, height)
        x1, y1 = project_point(lens, x + _AHEAD * c, y + _AHEAD * s, height)
        x0, y0 = project_point(lens, x - _AHEAD * c, y - _AHEAD * s, height)
        screen[n, 2] = np.arctan2(y0 - y1, x1 - x0)
        worst = -np.inf
        for u, v in looks.corners[shapes[n]]:
            px, py = project_point(lens, x + c * u - s * v, y + s * u + c * v, height)
            beyond = max(
                max(-0.5 - px, px - (size_px[0] - 0.5)), max(-0.5 - py, py - (size_px[1] - 0.5))
            )
            worst = np.inf if beyond != beyond else max(worst, beyond)
        overhang[n] = worst


@compiled
def _settle(
    scores: Floats, good: NDArray[np.bool_], order: Indices, poses: Floats, taken: Floats,
    nearest: float, limit: float, tags: Indices,
) -> None:  # fmt: skip
    """Pair candidates and tags, the surest first; of overlapping ones the best fitting counts.

    The chances of two colours for one part add up to at most 1, so a candidate reaches more than
    1/2 for one tag only; for limits above 1/2 this is the assignment with the largest sum.
    """
    tags[:] = _TAKEN
    _drop_repeated(order, poses, taken, nearest, tags)
    free = np.ones(scores.shape[1], np.bool_)
    while True:
        best, candidate, tag = 0.0, -1, -1
        for n in range(len(tags)):
            for t in range(len(free)):
                waits = good[n] and tags[n] == _TAKEN and free[t]
                if waits and scores[n, t] >= limit and scores[n, t] > best:
                    best, candidate, tag = scores[n, t], n, t
        if candidate < 0:
            return
        tags[candidate], free[tag] = tag, False


@compiled
def _drop_repeated(
    order: Indices, poses: Floats, taken: Floats, nearest: float, tags: Indices
) -> None:
    """Mark candidates that overlap a better one, or a robot already found."""
    for rank in range(len(order)):
        n = order[rank]
        for x, y in taken:
            if np.hypot(poses[n, 0] - x, poses[n, 1] - y) < nearest:
                tags[n] = _REPEATED
        for before in order[:rank]:
            away = np.hypot(poses[n, 0] - poses[before, 0], poses[n, 1] - poses[before, 1])
            if tags[before] != _REPEATED and away < nearest:
                tags[n] = _REPEATED


def _why_not(
    verdict: Verdict, fit: Fit, candidates: Candidates, eye: Eye, n: int, tags: Indices
) -> str:
    """Say why a candidate is not accepted."""
    limits = eye.thresholds
    if verdict.overhang[n] > _BORDER_PX:
        return f"cut by the image border: {verdict.overhang[n]:.1f} px of the tag lie beyond it"
    if not verdict.moved[n] < eye.radius:
        return f"fit went astray: {1e3 * verdict.moved[n]:.0f} mm from where it began"
    if not fit.residual_px[n] < limits.residual_px:
        return f"misfit of {fit.residual_px[n]:.2f} px, limit {limits.residual_px:.2f} px"
    if not verdict.good[n]:
        return _color_reason(fit.colors[n], int(candidates.shapes[n]), verdict.scores[n], eye)
    tag = int(verdict.scores[n].argmax())
    best = verdict.scores[tags == tag, tag].max(initial=0.0)
    return (
        f"id {eye.tags.ids[tag]} already taken by a better candidate "
        f"({best:.2f} >= {verdict.scores[n, tag]:.2f})"
    )


def _color_reason(colors: Floats, shape: int, scores: Floats, eye: Eye) -> str:
    """Name the part whose colour is least certain, and what it looks like."""
    chances = eye.palette.probabilities(colors)
    kind, rows = eye.shapes[shape], list(eye.shapes[shape].tags)
    classes = eye.looks.classes[rows]
    part = min(kind.colored, key=lambda k: chances[k][classes[:, k]].max())
    label = ("no colour", *eye.palette.names)
    surest = float(chances[part][classes[:, part]].max())
    if surest >= eye.thresholds.confidence:
        return f"colours {surest:.2f}, but only {scores.max():.2f} with all parts in the same light"
    first, second = np.argsort(-chances[part])[:2]
    b, g, r = np.clip(colors[part], 0, 255)
    return (
        f"{kind.names[part]} colour ambiguous or wrong: {label[first]} {chances[part, first]:.2f},"
        f" {label[second]} {chances[part, second]:.2f} (b {b:.0f}, g {g:.0f}, r {r:.0f})"
    )


def _rejection(verdict: Verdict, n: int, reason: str) -> Rejection:
    x, y, _ = np.nan_to_num(verdict.screen[n]).tolist()
    return Rejection(x, y, reason)
