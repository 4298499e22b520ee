"""Fitted candidates: accepted, one per robot, or rejected with the numbers that decided."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from control.geometry import Pose2D, wrap_angle
from vision.eye import Eye
from vision.identify import Candidates
from vision.pose import Fit
from vision.scene import Detection, PixelPose, Rejection
from vision.shapes import Shape

Floats = NDArray[np.float64]

_BORDER_PX = 0.25  # a tag may reach so far beyond the image
_APART = 0.85  # plates nearer than this share of their width are two readings of one place


@dataclass(frozen=True, slots=True)
class Verdict:
    """Scores of fitted candidates.

    Attributes:
        scores: shape (N, T), probability of the colours of the least certain part if candidate n
            wears tag t, 0 where it is not possible.
        reasons: of the N candidates, empty for those that can be accepted.
        screen: shape (N, 3), where they are in the image [px, px, rad].
    """

    scores: Floats
    reasons: tuple[str, ...]
    screen: Floats


def judge(fit: Fit, candidates: Candidates, eye: Eye, possible: NDArray[np.bool_]) -> Verdict:
    """Decide which candidates look like which tag.

    Args:
        fit: the outcome of the fit.
        candidates: where the fit began.
        eye: tags, palette and thresholds.
        possible: shape (N, T), which tag each candidate may be.

    Returns:
        Scores and reasons.
    """
    chances = eye.palette.probabilities(fit.colors)  # (N, K, classes)
    scores = _scores(fit.colors, chances, candidates.shapes, eye) * possible
    moved = np.hypot(*(fit.poses[:, :2] - candidates.poses[:, :2]).T)
    screen, overhang = _on_screen(fit.poses, candidates.shapes, eye)
    limits = eye.thresholds
    best = scores.max(axis=1)
    radius = eye.radius
    good = (overhang <= _BORDER_PX) & (moved < radius) & (fit.residual_px < limits.residual_px)
    good &= best >= limits.confidence
    reasons = [""] * len(good)
    for n in np.flatnonzero(~good):
        if overhang[n] > _BORDER_PX:
            reasons[n] = f"cut by the image border: {overhang[n]:.1f} px of the tag lie beyond it"
        elif not moved[n] < radius:
            reasons[n] = f"fit went astray: {1e3 * moved[n]:.0f} mm from where it began"
        elif not fit.residual_px[n] < limits.residual_px:
            reasons[n] = f"misfit of {fit.residual_px[n]:.2f} px, limit {limits.residual_px:.2f} px"
        else:
            shape = eye.shapes[candidates.shapes[n]]
            reasons[n] = _color_reason(fit.colors[n], chances[n], shape, eye, possible[n], best[n])
    return Verdict(scores, tuple(reasons), screen)


def assign(
    verdict: Verdict, fit: Fit, eye: Eye, taken: Floats
) -> tuple[tuple[Detection, ...], tuple[Rejection, ...]]:
    """Give every acceptable candidate its robot, every robot and place at most once.

    Args:
        verdict: scores and reasons.
        fit: the outcome of the fit.
        eye: tags and camera.
        taken: shape (M, 2), places of robots already found [m].

    Returns:
        Detections; rejections.
    """
    free, rejected = _separate(verdict, fit, eye, taken)
    pairs = _matched(verdict.scores[free], eye.thresholds.confidence)
    detections = []
    matched = set()
    for row, tag in pairs:
        n = free[row]
        matched.add(n)
        detections.append(_detection(verdict, fit, n, tag, eye))
    for n in free:
        if n not in matched:
            tag = int(verdict.scores[n].argmax())
            best = max((verdict.scores[free[row], t] for row, t in pairs if t == tag), default=0.0)
            reason = (
                f"id {eye.tags.ids[tag]} already taken by a better candidate "
                f"({best:.2f} >= {verdict.scores[n, tag]:.2f})"
            )
            rejected.append(_rejection(verdict, n, reason))
    return tuple(detections), tuple(rejected)


def _scores(
    colors: Floats, chances: NDArray[np.float32], shapes: NDArray[np.intp], eye: Eye
) -> Floats:
    """Probability (N, T) of the least certain coloured part, all parts being in the same light."""
    scores = np.zeros((len(shapes), len(eye.tags.tags)))
    width = 2.0 * eye.thresholds.light_spread**2
    for index, shape in enumerate(eye.shapes):
        rows, parts = np.flatnonzero(shapes == index), shape.colored
        own = chances[rows][:, parts, shape.part_classes[:, parts]].min(axis=2)  # (rows, tags)
        light = np.einsum("npc,tpc->ntp", colors[rows][:, parts], shape.reference)
        light = np.log(np.maximum(light, 1e-3))
        contrast = light.max(axis=2) - light.min(axis=2)
        scores[rows[:, None], shape.tags] = own * np.exp(-(contrast**2) / width)
    return scores


def _on_screen(poses: Floats, shapes: NDArray[np.intp], eye: Eye) -> tuple[Floats, Floats]:
    """Poses on the screen (N, 3) [px, px, rad], and how far plates reach beyond the image [px]."""
    w, h = eye.camera.size_px
    screen, overhang = np.zeros((len(poses), 3)), np.zeros(len(poses))
    c, s = np.cos(poses[:, 2:]), np.sin(poses[:, 2:])
    for index, shape in enumerate(eye.shapes):
        rows = np.flatnonzero(shapes == index)
        u, v = shape.outline.T
        points = np.full((len(rows), len(u), 3), eye.camera.tag_height)
        points[..., 0] = poses[rows, :1] + c[rows] * u - s[rows] * v
        points[..., 1] = poses[rows, 1:2] + s[rows] * u + c[rows] * v
        pixels = eye.camera.project(points.reshape(-1, 3)).reshape(len(rows), len(u), 2)
        screen[rows, :2] = pixels[:, 0]
        ahead = pixels[:, 1] - pixels[:, 2]
        screen[rows, 2] = np.arctan2(-ahead[:, 1], ahead[:, 0])
        beyond = np.maximum(-0.5 - pixels, pixels - (w - 0.5, h - 0.5)).max(axis=(1, 2))
        overhang[rows] = np.where(beyond == beyond, beyond, np.inf)  # NaN: behind the camera
    return screen, overhang


def _color_reason(
    colors: Floats,
    chances: NDArray[np.float32],
    shape: Shape,
    eye: Eye,
    possible: NDArray[np.bool_],
    best: float,
) -> str:
    """Name the part whose colour is least certain, and what it looks like."""
    rows = np.flatnonzero(possible[shape.tags])
    if len(rows) == 0:
        return "no robot of this shape is missing"
    part = min(
        shape.colored.tolist(),
        key=lambda k: chances[k][shape.part_classes[rows, k]].max(),
    )
    label = ("no colour", *eye.palette.names)
    surest = float(chances[part][shape.part_classes[rows, part]].max())
    if surest >= eye.thresholds.confidence:
        return f"colours {surest:.2f}, but only {best:.2f} with all parts in the same light"
    first, second = np.argsort(-chances[part])[:2]
    b, g, r = np.clip(colors[part], 0, 255)
    return (
        f"{shape.names[part]} colour ambiguous or wrong: {label[first]} {chances[part, first]:.2f},"
        f" {label[second]} {chances[part, second]:.2f} (b {b:.0f}, g {g:.0f}, r {r:.0f})"
    )


def _separate(
    verdict: Verdict, fit: Fit, eye: Eye, taken: Floats
) -> tuple[list[int], list[Rejection]]:
    """Keep the best fitting of overlapping candidates; report those that failed elsewhere."""
    order = sorted(
        range(len(verdict.reasons)),
        key=lambda n: (verdict.reasons[n] != "", float(fit.residual_px[n])),
    )
    places = np.vstack((fit.poses[:, :2], taken))
    away = fit.poses[:, None, :2] - places
    nearest = 2.0 * _APART * min(shape.inner_radius for shape in eye.shapes)
    overlaps = np.hypot(away[..., 0], away[..., 1]) < nearest
    told = list(range(len(order), len(places)))
    kept: list[int] = []
    rejected: list[Rejection] = []
    for n in order:
        if overlaps[n, told].any():
            continue
        told.append(n)
        if verdict.reasons[n]:
            rejected.append(_rejection(verdict, n, verdict.reasons[n]))
        else:
            kept.append(n)
    return kept, rejected


def _matched(scores: Floats, least: float) -> list[tuple[int, int]]:
    """Pair candidates (rows) and tags, the surest pair first.

    The chances of two colours for one part add up to at most 1, so a candidate reaches more than
    1/2 for one tag only; for `least` above 1/2 this is the assignment with the largest sum.
    """
    pairs = np.argwhere(scores >= least)
    order = np.argsort(-scores[tuple(pairs.T)], kind="stable")
    chosen: dict[int, int] = {}
    for n, tag in pairs[order].tolist():
        if n not in chosen and tag not in chosen.values():
            chosen[n] = tag
    return list(chosen.items())


def _detection(verdict: Verdict, fit: Fit, n: int, tag: int, eye: Eye) -> Detection:
    x, y, theta = fit.poses[n].tolist()
    covariance = fit.covariances[n].copy()
    covariance.flags.writeable = False
    return Detection(
        eye.tags.ids[tag],
        Pose2D(x, y, wrap_angle(theta)),
        PixelPose(*verdict.screen[n].tolist()),
        covariance,
        float(fit.residual_px[n]),
        float(verdict.scores[n, tag]),
    )


def _rejection(verdict: Verdict, n: int, reason: str) -> Rejection:
    x, y, _ = np.nan_to_num(verdict.screen[n]).tolist()
    return Rejection(x, y, reason)
