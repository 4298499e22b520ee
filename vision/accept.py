"""Fitted candidates: accepted, one per robot, or rejected with the numbers that decided."""

import numpy as np
from numpy.typing import NDArray

from control.geometry import Pose2D, wrap_angle
from vision.assignment import REPEATED, all_sure, settle
from vision.compiled import compiled, compiled_part
from vision.eye import Eye
from vision.fit import Fit
from vision.identify import Candidates
from vision.identity import Expectation, tell_apart
from vision.projection import Lens, project_point
from vision.refusals import BORDER_PX, refusals
from vision.scene import Detection, PixelPose, Rejection
from vision.scoring import color_ratios, score_colors
from vision.shapes import Looks
from vision.verdict import Verdict

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

_VAGUE = 0.3  # a place known to this share of the radius only is none: nothing is seen there
_APART = 0.85  # plates nearer than this share of their width are two readings of one place
_AHEAD = 1e-3  # points so far before and behind the centre give the heading on the screen [m]


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
        np.empty(count), np.empty(count), np.empty((count, 3)), np.zeros(count),
        np.full(count, -1), np.zeros((count, 3)),
    )  # fmt: skip
    _judge(
        fit.poses, fit.covariances, fit.residual_px, fit.colors, candidates.shapes,
        candidates.poses, eye.looks, eye.camera.lens, eye.camera.tag_height, eye.camera.size_px,
        gains, possible, slack * limits.light_spread, eye.radius, eye.most_residual_px,
        limits.confidence, verdict.scores, verdict.screen, verdict.overhang, verdict.moved,
        verdict.sound, verdict.good,
    )  # fmt: skip
    return verdict


def assign(
    verdict: Verdict,
    fit: Fit,
    candidates: Candidates,
    eye: Eye,
    taken: Floats,
    known: Expectation | None = None,
) -> tuple[Indices, tuple[Rejection, ...]]:
    """Give every acceptable candidate its robot, every robot and place at most once.

    Args:
        verdict: scores and reasons.
        fit: the outcome of the fit.
        candidates: where the fit began.
        eye: tags and camera.
        taken: shape (M, 2), places of robots already found [m].
        known: where robots are expected: it decides between candidates with the same colours;
            None if the colours decide.

    Returns:
        Index of the tag of every candidate, negative for none, shape (N,); rejections.
    """
    nearest = 2.0 * _APART * min(shape.inner_radius for shape in eye.shapes)
    tags = settle(verdict.scores, verdict.good, fit.residual_px, fit.poses, taken, nearest)
    if known is not None:
        claims, places = verdict.good & (tags != REPEATED), np.ascontiguousarray(fit.poses[:, :2])
        tell_apart(tags, verdict.scores, claims, places, np.array(eye.tags.alike), known)
    if all_sure(verdict.scores, tags, eye.thresholds.confidence):
        return tags, ()
    rows = np.flatnonzero(tags >= 0)
    unsure = verdict.scores[rows, tags[rows]] < eye.thresholds.confidence
    refused = [*np.flatnonzero((tags < 0) & (tags != REPEATED)).tolist(), *rows[unsure].tolist()]
    rejected = refusals(refused, verdict, fit, candidates.shapes, eye, tags)
    tags[rows[unsure]] = REPEATED
    return tags, rejected


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
    ratios = np.empty((len(tags), eye.looks.classes.shape[1], 3))
    color_ratios(fit.colors, tags, eye.looks, ratios)
    return ratios


@compiled
def _judge(
    poses: Floats, covariances: Floats, residual_px: Floats, colors: Floats, shapes: Indices,
    starts: Floats, looks: Looks, lens: Lens, height: float, size_px: tuple[int, int],
    gains: Floats, possible: NDArray[np.bool_], spread: float, radius: float, most_px: float,
    confidence: float, scores: Floats, screen: Floats, overhang: Floats, moved: Floats,
    sound: NDArray[np.bool_], good: NDArray[np.bool_],
) -> None:  # fmt: skip
    """Score the colours, find the places on the screen, and hold all against the thresholds."""
    score_colors(colors, shapes, looks, gains, possible, spread, scores)
    _to_screen(poses, shapes, looks, lens, height, size_px, screen, overhang)
    _compare(
        poses, starts, covariances, residual_px, overhang, scores, radius, most_px, confidence,
        moved, sound, good,
    )  # fmt: skip


@compiled_part
def _compare(
    poses: Floats, starts: Floats, covariances: Floats, residual_px: Floats, overhang: Floats,
    scores: Floats,
    radius: float, most_px: float, confidence: float,
    moved: Floats, sound: NDArray[np.bool_], good: NDArray[np.bool_],
) -> None:  # fmt: skip
    """Hold fits against the thresholds."""
    for n in range(len(poses)):
        moved[n] = np.hypot(poses[n, 0] - starts[n, 0], poses[n, 1] - starts[n, 1])
        near = overhang[n] <= BORDER_PX and moved[n] < radius
        told = covariances[n, 0, 0] + covariances[n, 1, 1] < (_VAGUE * radius) ** 2
        sound[n] = near and told and residual_px[n] < most_px
        good[n] = sound[n] and scores[n].max() >= confidence


@compiled_part
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
