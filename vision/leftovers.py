"""What the search leaves over, and why: what blobs lack, which colours disagree, what was cut."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from vision.compiled import compiled
from vision.eye import Eye
from vision.scene import Rejection
from vision.segment import Blobs

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

_MAX_REASONS = 16
SLACK_PX = 1.0
"""Error of the distance of two blobs beside the relative one [px]."""


def lonely(blobs: Blobs, eye: Eye, places: Floats) -> tuple[Rejection, ...]:
    """Say of large blobs without a partner what was missing.

    Args:
        blobs: coloured regions.
        eye: tags.
        places: shape (N, 2), where blobs found partners [px].

    Returns:
        At most 16 rejections.
    """
    scale = float(eye.gauge.scales[-1])
    alone = np.flatnonzero(_are_alone(blobs.centers, places, eye.radius * scale))[:_MAX_REASONS]
    if len(alone) == 0:
        return ()
    kinds, areas = blobs.classes[alone].tolist(), blobs.areas[alone].tolist()
    partners = {label: _partners(eye, label) for label in set(kinds)}
    reasons = []
    for label, area, center in zip(kinds, areas, blobs.centers[alone], strict=True):
        missing = next((text for least, text in partners[label] if area > least), "")
        if missing:
            reason = f"{eye.palette.names[label - 1]} blob of {area:.0f} px: {missing}"
            reasons.append(_at(center, reason))
    return tuple(reasons)


@compiled
def _are_alone(places: Floats, others: Floats, reach: float) -> NDArray[np.bool_]:
    """Which places (N,) have none of the others within reach [px]."""
    alone = np.ones(len(places), np.bool_)
    for n in range(len(places)):
        for x, y in others:
            if (places[n, 0] - x) ** 2 + (places[n, 1] - y) ** 2 < reach * reach:
                alone[n] = False
                break
    return alone


@lru_cache(maxsize=8)
def _partners(eye: Eye, label: int) -> tuple[tuple[float, str], ...]:
    """What blobs of a class need to be part of a tag, if they are larger than so many px."""
    found, scale = [], float(eye.gauge.scales[-1])
    for index, shape in enumerate(eye.shapes):
        centroids, classes = eye.looks.centroids[index], eye.looks.classes[list(shape.tags)]
        for i, j in shape.anchors:
            length = float(np.hypot(*(centroids[i] - centroids[j])))
            reach = length * (1 + eye.thresholds.distance_share) * scale + SLACK_PX
            for part, other in ((i, j), (j, i)):
                if (classes[:, part] == label).any():
                    one, two = shape.names[part], shape.names[other]
                    text = f"{one} patch without {two} patch within {reach:.1f} px"
                    found.append((0.5 * float(shape.areas[part]) * scale**2, text))
    return tuple(found)


def feeble(centers: Floats, agreements: Floats, told: Floats, eye: Eye) -> tuple[Rejection, ...]:
    """Say of pairs that disagree with the class image by how much, if nothing better is there.

    Args:
        centers: shape (N, 2), where they are [px].
        agreements: shape (N,), share of the sample points that show the right class.
        told: shape (M, 2), where better candidates are [px].
        eye: tags.

    Returns:
        At most 16 rejections.
    """
    if len(centers) == 0:
        return ()
    reach = eye.radius * float(eye.gauge.scales[-1])
    chosen = np.empty(_MAX_REASONS, np.intp)
    count = _keep_apart(centers, told, reach, chosen)
    limit = eye.thresholds.agreement
    return tuple(
        _at(centers[n], f"colours agree at too few points: {agreements[n]:.2f} < {limit:.2f}")
        for n in chosen[:count].tolist()
    )


@compiled
def _keep_apart(places: Floats, others: Floats, reach: float, chosen: Indices) -> int:
    """Choose places in turn that are not near others or one chosen before; returns how many."""
    free, count = _are_alone(places, others, reach), 0
    for n in range(len(places)):
        if count == len(chosen):
            break
        for before in chosen[:count]:
            dx, dy = places[n, 0] - places[before, 0], places[n, 1] - places[before, 1]
            free[n] = free[n] and not dx * dx + dy * dy < reach * reach
        if free[n]:
            chosen[count] = n
            count += 1
    return count


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
