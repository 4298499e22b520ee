"""What the search leaves over, and why: what blobs lack, which colours disagree, what was cut."""

import numpy as np
from numpy.typing import NDArray

from vision.compiled import compiled
from vision.eye import Eye
from vision.scene import Rejection
from vision.segment import Blobs

Floats = NDArray[np.float64]

_MAX_REASONS = 32
SLACK_PX = 1.0
"""Error of the distance of two blobs beside the relative one [px]."""


def lonely(blobs: Blobs, eye: Eye, places: Floats) -> tuple[Rejection, ...]:
    """Say of large blobs without a partner what was missing.

    Args:
        blobs: coloured regions.
        eye: tags.
        places: shape (N, 2), where blobs found partners [px].

    Returns:
        At most 32 rejections.
    """
    scale = float(eye.gauge.scales[-1])
    alone = np.flatnonzero(_are_alone(blobs.centers, places, eye.radius * scale))
    reasons = []
    for index in alone[:_MAX_REASONS]:
        label, area = int(blobs.classes[index]), float(blobs.areas[index])
        missing = _missing_partner(eye, label, area, scale)
        if missing:
            reason = f"{eye.palette.names[label - 1]} blob of {area:.0f} px: {missing}"
            reasons.append(_at(blobs.centers[index], reason))
    return tuple(reasons)


@compiled
def _are_alone(places: Floats, others: Floats, reach: float) -> NDArray[np.bool_]:
    """Which places (N,) have none of the others within reach [px]."""
    alone = np.ones(len(places), np.bool_)
    for n in range(len(places)):
        for x, y in others:
            if np.hypot(places[n, 0] - x, places[n, 1] - y) < reach:
                alone[n] = False
                break
    return alone


def _missing_partner(eye: Eye, label: int, area: float, scale: float) -> str:
    """What a blob of a class would need to be part of a tag; empty if it is too small to matter."""
    for index, shape in enumerate(eye.shapes):
        centroids, classes = eye.looks.centroids[index], eye.looks.classes[list(shape.tags)]
        for i, j in shape.anchors:
            for part, other in ((i, j), (j, i)):
                large = area > 0.5 * shape.areas[part] * scale**2
                if large and (classes[:, part] == label).any():
                    length = float(np.hypot(*(centroids[i] - centroids[j])))
                    reach = length * (1 + eye.thresholds.distance_share) * scale + SLACK_PX
                    names = shape.names
                    return f"{names[part]} patch without {names[other]} patch within {reach:.1f} px"
    return ""


def feeble(centers: Floats, agreements: Floats, told: Floats, eye: Eye) -> tuple[Rejection, ...]:
    """Say of pairs that disagree with the class image by how much, if nothing better is there.

    Args:
        centers: shape (N, 2), where they are [px].
        agreements: shape (N,), share of the sample points that show the right class.
        told: shape (M, 2), where better candidates are [px].
        eye: tags.

    Returns:
        At most 32 rejections.
    """
    reasons: list[Rejection] = []
    reach = eye.radius * float(eye.gauge.scales[-1])
    for center, agreement in zip(centers, agreements, strict=True):
        if (np.hypot(*(told - center).T) < reach).any():
            continue
        told = np.vstack((told, center))
        shares = f"{agreement:.2f} < {eye.thresholds.agreement:.2f}"
        reasons.append(_at(center, f"colours agree at too few points: {shares}"))
        if len(reasons) == _MAX_REASONS:
            break
    return tuple(reasons)


def cut(candidates: int, blobs: int, eye: Eye) -> tuple[Rejection, ...]:
    """Say that a limit was reached.

    Args:
        candidates: how many were not looked at.
        blobs: how many were not looked at.
        eye: its limits.

    Returns:
        A rejection for every limit.
    """
    if not (candidates or blobs):
        return ()
    reasons = []
    if blobs:
        reasons.append(f"{blobs} smaller blobs beyond {eye.thresholds.max_blobs} not looked at")
    if candidates:
        limit = eye.thresholds.max_candidates
        reasons.append(f"{candidates} weaker candidates beyond {limit} not looked at")
    middle = 0.5 * (np.array(eye.camera.size_px) - 1.0)
    return tuple(_at(middle, reason) for reason in reasons)


def _at(pixel: Floats, reason: str) -> Rejection:
    return Rejection(float(pixel[0]), float(pixel[1]), reason)
