"""Which candidates are worth how many steps of the fit: the promising ones get more.

In a picture full of the tags' colours there are hundreds of places that might be tags. Steps are
counted, not seconds, so that the same picture always gives the same robots.
"""

import numpy as np
from numpy.typing import NDArray

from vision.eye import Eye
from vision.fit import Fit
from vision.identify import Candidates
from vision.pose import fit_poses

Floats = NDArray[np.float64]
Bytes = NDArray[np.uint8]
Indices = NDArray[np.intp]

_STEPS = 16  # at most, of Gauss-Newton; 2 or 3 are usual
_ROUNDS = (1, 2, 4, 8)  # steps after the first look, if there are many: ever fewer of them go on
_SHARE = 0.5  # of the steps that are left, for each of these rounds
_EFFORT, _EFFORT_PER_TAG = 22, 7  # steps of a frame: in all, and per tag and pair of anchors


def fit_best(image: Bytes, eye: Eye, candidates: Candidates) -> tuple[Candidates, Fit]:
    """Fit candidates, with a limited number of steps in all.

    Args:
        image: shape (H, W, 3), BGR.
        eye: templates and camera.
        candidates: best first.

    Returns:
        The candidates that were looked at, and their fits.
    """
    left = _EFFORT + _EFFORT_PER_TAG * sum(len(s.tags) * len(s.anchors) for s in eye.shapes)
    if len(candidates) * _STEPS <= left:
        return candidates, _fitted(image, eye, candidates, _STEPS)
    first = 2 if 2 * len(candidates) <= _SHARE * left else 1  # tags settle in two
    candidates = candidates.take(slice(int(_SHARE * left / first)))
    fit = _fitted(image, eye, candidates, first)
    left -= len(candidates) * first
    moving = ~fit.settled
    for steps in _ROUNDS:
        ranked = np.flatnonzero(moving)
        ranked = ranked[fit.residual_px[ranked].argsort(kind="stable")]
        chosen = ranked[: int(_SHARE * left / steps)]
        if len(chosen) == 0:
            break
        left -= len(chosen) * steps
        fit.put(chosen, _fitted(image, eye, _moved(candidates, fit, chosen, eye), steps))
        moving[:] = False
        moving[chosen] = ~fit.settled[chosen]
    return candidates, fit


def _fitted(image: Bytes, eye: Eye, some: Candidates, steps: int) -> Fit:
    return fit_poses(image, eye.gauge, some.shapes, some.poses, some.centers, steps)


def _moved(candidates: Candidates, fit: Fit, chosen: Indices, eye: Eye) -> Candidates:
    """Some candidates, from where their fits have come."""
    poses = _finite(fit.poses[chosen])
    centers = _finite(eye.camera.tag_pixels(poses))
    return Candidates(candidates.shapes[chosen], poses, centers, candidates.agreement[chosen])


def _finite(values: Floats) -> Floats:
    """Values, 0 in the place of those that are not finite."""
    values[~np.isfinite(values)] = 0.0
    return values
