"""Why fitted candidates are not accepted, with the numbers that decided."""

from math import degrees, isfinite

import numpy as np
from numpy.typing import NDArray

from vision.eye import Eye
from vision.fit import Fit
from vision.scene import Rejection
from vision.scoring import compare_color
from vision.verdict import Verdict

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

_MOST = 16  # reasons that are told
_UNIT: Floats = np.ones(3)

BORDER_PX = 0.25
"""A tag may reach so far beyond the image [px]."""


def refusals(
    refused: list[int], verdict: Verdict, fit: Fit, shapes: Indices, eye: Eye, tags: Indices
) -> tuple[Rejection, ...]:
    """Say why candidates are not accepted.

    Args:
        refused: their indices.
        verdict: on all candidates.
        fit: of all candidates.
        shapes: shape (N,), geometry of all candidates.
        eye: tags and thresholds.
        tags: shape (N,), index of the tag of every candidate, negative for none.

    Returns:
        A reason for each of the first 16, and one for the rest.
    """
    told = [
        _rejection(verdict, n, _why_not(verdict, fit, int(shapes[n]), eye, n, tags))
        for n in refused[:_MOST]
    ]
    if len(refused) > _MOST:
        rest = f"{len(refused) - _MOST} more like this, for one reason or another"
        told.append(_rejection(verdict, refused[_MOST], rest))
    return tuple(told)


def _why_not(verdict: Verdict, fit: Fit, shape: int, eye: Eye, n: int, tags: Indices) -> str:
    """Say why a candidate is not accepted."""
    if verdict.overhang[n] > BORDER_PX:
        return f"cut by the image border: {verdict.overhang[n]:.1f} px of the tag lie beyond it"
    if verdict.hidden[n] > 0.0 or verdict.twice[n] >= 0:
        return _else_why_not(verdict, eye, n)
    if not verdict.moved[n] < eye.radius:
        return f"fit went astray: {1e3 * verdict.moved[n]:.0f} mm from where it began"
    against = verdict.unlike[n]
    if not verdict.sound[n] or against.sum() >= 1.0:
        return _misfit(float(fit.residual_px[n]), against, eye, int(verdict.scores[n].argmax()))
    if not verdict.good[n]:
        return _color_reason(fit.colors[n], shape, verdict.scores[n], eye)
    tag = int(verdict.scores[n].argmax())
    best = verdict.scores[tags == tag, tag].max(initial=0.0)
    return (
        f"id {eye.tags.ids[tag]} already taken by a better candidate "
        f"({best:.2f} >= {verdict.scores[n, tag]:.2f})"
    )


def _misfit(residual_px: float, against: Floats, eye: Eye, tag: int) -> str:
    """Say why a fit that ended near its start is none."""
    limit_px = eye.most_residual_px
    if not residual_px < limit_px:
        return f"misfit of {residual_px:.2f} px, limit {limit_px:.2f} px"
    if not against.any():
        return "nothing to be seen here that tells where the tag is"
    misfit, colors, plate = against.tolist()
    return (
        f"little like robot {eye.tags.ids[tag]}: squares of misfit ({residual_px:.2f} px) "
        f"{misfit:.2f}, colours elsewhere {colors:.2f} and light on the plate {plate:.2f} "
        f"add up to {against.sum():.2f}, limit 1"
    )


def _else_why_not(verdict: Verdict, eye: Eye, n: int) -> str:
    """Say what lies on a candidate, or whom it repeats."""
    if verdict.hidden[n] > 0.0:
        return f"covered: {verdict.hidden[n]:.0%} of it does not look like the tag expected here"
    return f"looks like robot {eye.tags.ids[verdict.twice[n]]}, which is seen elsewhere"


def _color_reason(colors: Floats, shape: int, scores: Floats, eye: Eye) -> str:
    """Name the part whose colour is the farthest from what it may be."""
    kind, looks, limit = eye.shapes[shape], eye.looks, eye.thresholds.confidence
    tag = kind.tags[int(scores[list(kind.tags)].argmax())]
    angles = [
        float(compare_color(colors[k], looks.typical[tag, k], _UNIT)[1]) for k in kind.colored
    ]
    part = kind.colored[angles.index(max(angles))]
    name = eye.palette.names[looks.classes[tag, part] - 1]
    b, g, r = (min(max(value, 0.0), 255.0) for value in colors[part].tolist())
    return (
        f"colours {scores.max():.2f}, limit {limit:.2f}: at best robot {eye.tags.ids[tag]}, whose "
        f"{kind.names[part]} is {name}; seen b {b:.0f}, g {g:.0f}, r {r:.0f}, "
        f"{degrees(max(angles)):.0f} deg from it"
    )


def _rejection(verdict: Verdict, n: int, reason: str) -> Rejection:
    x, y, _ = verdict.screen[n].tolist()
    return Rejection(x if isfinite(x) else 0.0, y if isfinite(y) else 0.0, reason)
