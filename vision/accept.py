"""Fitted candidates: accepted, one per robot, or rejected with the numbers that decided."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from control.geometry import Pose2D, wrap_angle
from vision.assignment import REPEATED, settle
from vision.compiled import compiled
from vision.eye import Eye
from vision.identify import Candidates
from vision.identity import Expectation, tell_apart
from vision.pose import Fit
from vision.projection import Lens, project_point
from vision.scene import Detection, PixelPose, Rejection
from vision.scoring import color_ratios, compare_color, score_colors
from vision.shapes import Looks

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

_BORDER_PX = 0.25  # a tag may reach so far beyond the image
_VAGUE = 0.3  # a place known to this share of the radius only is none: nothing is seen there
_APART = 0.85  # plates nearer than this share of their width are two readings of one place
_AHEAD = 1e-3  # points so far before and behind the centre give the heading on the screen [m]


@dataclass(frozen=True, slots=True)
class Verdict:
    """Scores of fitted candidates.

    Attributes:
        scores: shape (N, T), probability that candidate n has the colours of tag t rather than any
            colours, 0 where it is not possible.
        sound: shape (N,), whether place and misfit are those of a tag, whatever the colours.
        good: shape (N,), whether the candidate can be accepted.
        moved: shape (N,), way of the fit from where it began [m].
        overhang: shape (N,), how far the plate reaches beyond the image [px].
        screen: shape (N, 3), where they are in the image [px, px, rad].
        hidden: shape (N,), share that is covered of tags that are refused for it, else 0.
        twice: shape (N,), index of the tag of a robot already found that they look like, else -1.
    """

    scores: Floats
    sound: NDArray[np.bool_]
    good: NDArray[np.bool_]
    moved: Floats
    overhang: Floats
    screen: Floats
    hidden: Floats
    twice: Indices

    def refuse_covered(self, chosen: Indices, hidden: Floats) -> None:
        """Refuse candidates of which too much is covered.

        Args:
            chosen: shape (R,), their indices.
            hidden: shape (R,), share of each that is covered.
        """
        self.hidden[chosen] = hidden
        self.good[chosen] = self.sound[chosen] = False


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
        np.full(count, -1),
    )  # fmt: skip
    score_colors(
        fit.colors, candidates.shapes, eye.looks, gains, possible, slack * limits.light_spread,
        verdict.scores,
    )  # fmt: skip
    _to_screen(
        fit.poses, candidates.shapes, eye.looks, eye.camera.lens, eye.camera.tag_height,
        eye.camera.size_px, verdict.screen, verdict.overhang,
    )  # fmt: skip
    _compare(
        fit.poses, candidates.poses, fit.covariances, fit.residual_px, verdict.overhang,
        verdict.scores, eye.radius,
        eye.most_residual_px, limits.confidence, verdict.moved, verdict.sound, verdict.good,
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
    order = np.lexsort((fit.residual_px, ~verdict.good))
    places = np.ascontiguousarray(fit.poses[:, :2])
    tags = settle(verdict.scores, verdict.good, order, places, taken, nearest)
    if known is not None:
        claims = verdict.good & (tags != REPEATED)
        tell_apart(tags, verdict.scores, claims, places, np.array(eye.tags.alike), known)
    rows = np.flatnonzero(tags >= 0)
    unsure = verdict.scores[rows, tags[rows]] < eye.thresholds.confidence
    rejected = [
        _rejection(verdict, n, _why_not(verdict, fit, candidates, eye, n, tags))
        for n in [*np.flatnonzero(tags < 0).tolist(), *rows[unsure].tolist()]
        if tags[n] != REPEATED
    ]
    tags[rows[unsure]] = REPEATED
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
    ratios = np.empty((len(tags), eye.looks.classes.shape[1], 3))
    color_ratios(fit.colors, tags, eye.looks, ratios)
    return ratios


@compiled
def _compare(
    poses: Floats, starts: Floats, covariances: Floats, residual_px: Floats, overhang: Floats,
    scores: Floats,
    radius: float, most_px: float, confidence: float,
    moved: Floats, sound: NDArray[np.bool_], good: NDArray[np.bool_],
) -> None:  # fmt: skip
    """Hold fits against the thresholds."""
    for n in range(len(poses)):
        moved[n] = np.hypot(poses[n, 0] - starts[n, 0], poses[n, 1] - starts[n, 1])
        near = overhang[n] <= _BORDER_PX and moved[n] < radius
        told = covariances[n, 0, 0] + covariances[n, 1, 1] < (_VAGUE * radius) ** 2
        sound[n] = near and told and residual_px[n] < most_px
        good[n] = sound[n] and scores[n].max() >= confidence


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


def _why_not(
    verdict: Verdict, fit: Fit, candidates: Candidates, eye: Eye, n: int, tags: Indices
) -> str:
    """Say why a candidate is not accepted."""
    if verdict.overhang[n] > _BORDER_PX:
        return f"cut by the image border: {verdict.overhang[n]:.1f} px of the tag lie beyond it"
    if verdict.hidden[n] > 0.0 or verdict.twice[n] >= 0:
        return _else_why_not(verdict, eye, n)
    if not verdict.moved[n] < eye.radius:
        return f"fit went astray: {1e3 * verdict.moved[n]:.0f} mm from where it began"
    if not verdict.sound[n]:
        return _misfit(float(fit.residual_px[n]), eye.most_residual_px)
    if not verdict.good[n]:
        return _color_reason(fit.colors[n], int(candidates.shapes[n]), verdict.scores[n], eye)
    tag = int(verdict.scores[n].argmax())
    best = verdict.scores[tags == tag, tag].max(initial=0.0)
    return (
        f"id {eye.tags.ids[tag]} already taken by a better candidate "
        f"({best:.2f} >= {verdict.scores[n, tag]:.2f})"
    )


def _misfit(residual_px: float, limit_px: float) -> str:
    """Say why a fit that ended near its start is none."""
    if residual_px < limit_px:
        return "nothing to be seen here that tells where the tag is"
    return f"misfit of {residual_px:.2f} px, limit {limit_px:.2f} px"


def _else_why_not(verdict: Verdict, eye: Eye, n: int) -> str:
    """Say what lies on a candidate, or whom it repeats."""
    if verdict.hidden[n] > 0.0:
        return f"covered: {verdict.hidden[n]:.0%} of it does not look like the tag expected here"
    return f"looks like robot {eye.tags.ids[verdict.twice[n]]}, which is seen elsewhere"


def _color_reason(colors: Floats, shape: int, scores: Floats, eye: Eye) -> str:
    """Name the part whose colour is the farthest from what it may be."""
    kind, looks, limit = eye.shapes[shape], eye.looks, eye.thresholds.confidence
    tag = max(kind.tags, key=lambda t: scores[t])
    unit = np.ones(3)
    angles = [float(compare_color(colors[k], looks.typical[tag, k], unit)[1]) for k in kind.colored]
    part = kind.colored[int(np.argmax(angles))]
    name = eye.palette.names[looks.classes[tag, part] - 1]
    b, g, r = np.clip(colors[part], 0, 255)
    return (
        f"colours {scores.max():.2f}, limit {limit:.2f}: at best robot {eye.tags.ids[tag]}, whose "
        f"{kind.names[part]} is {name}; seen b {b:.0f}, g {g:.0f}, r {r:.0f}, "
        f"{np.degrees(max(angles)):.0f} deg from it"
    )


def _rejection(verdict: Verdict, n: int, reason: str) -> Rejection:
    x, y, _ = np.nan_to_num(verdict.screen[n]).tolist()
    return Rejection(x, y, reason)
