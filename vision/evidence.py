"""Is a fitted candidate a tag all over? Misfit, colours at its points and a dark plate, together.

Clouds of colour sometimes have a tag's colours where its parts are, and fit badly. Real tags fit
badly too where cameras sharpen the picture, but show the right colours all over. So no single limit
tells them apart: the squares of the three, each in units of what is too much, are added up.
"""

from math import hypot

import numpy as np
from numpy.typing import NDArray

from vision.compiled import compiled, compiled_part
from vision.eye import Eye
from vision.fit import Fit
from vision.identify import agreement_at
from vision.shapes import Looks
from vision.verdict import Verdict

Floats = NDArray[np.float64]
Bytes = NDArray[np.uint8]
Indices = NDArray[np.intp]

_MISFIT, _LEAST_MISFIT, _MOST_MISFIT_PX = 0.048, 0.0215, 0.86  # too much, of the tag's side
_BLUR, _NOISE = 0.25, 0.05  # and what is usual: px per px of blur, per grey level and px of edges
_USUAL = 1.5  # and what is usual with this camera, times
_SOME = 3  # tags tell what is usual, at least
_WRONG = 0.66  # share of points with another colour that is too much
_BRIGHT = 1.5  # light on the plate over that on the parts that is too much


def refuse_unlike(
    verdict: Verdict, fit: Fit, shapes: Indices, classes: Bytes, eye: Eye, usual_px: float
) -> None:
    """Refuse candidates that speak against being a tag by more than one thing.

    Args:
        verdict: on the candidates.
        fit: of the candidates.
        shapes: shape (N,), geometry of the candidates.
        classes: shape (H, W), class image.
        eye: tags, sharpness and noise.
        usual_px: misfit of tags through this camera, 0 if nobody knows: then those that are tags
            beyond doubt tell it, if there are some [px].
    """
    side_px = 2.0 * eye.gauge.arm * float(eye.gauge.scales[0])
    own = max(min(_MISFIT * side_px, _MOST_MISFIT_PX), _LEAST_MISFIT * side_px)
    most_px = hypot(own, _BLUR * eye.optics.blur_px, _NOISE * eye.optics.noise * eye.optics.edge_px)
    _refuse(
        fit.poses, fit.colors, fit.residual_px, shapes, verdict.screen, verdict.scores, classes,
        eye.gauge.nodes, eye.looks, most_px, usual_px, verdict.good, verdict.unlike,
    )  # fmt: skip


@compiled
def _refuse(
    poses: Floats, colors: Floats, residual_px: Floats, shapes: Indices, screen: Floats,
    scores: Floats, classes: Bytes, nodes: Floats, looks: Looks, most_px: float, usual_px: float,
    good: NDArray[np.bool_], unlike: Floats,
) -> None:  # fmt: skip
    """Squares of misfit, wrong points and the plate's light (N, 3), and who is good in spite."""
    wanted, sure = np.zeros(scores.shape[1], np.bool_), np.zeros(len(poses), np.bool_)
    limit = most_px**2 + (_USUAL * usual_px) ** 2
    for n in range(len(poses)):
        if good[n]:
            tag = int(scores[n].argmax())
            wanted[:] = False
            wanted[tag] = True
            right = agreement_at(classes, nodes, looks, shapes[n], wanted, poses[n], screen[n, :2])
            light = _plate(colors[n], looks.classes[tag], looks.part_counts[shapes[n]])
            unlike[n, 0] = residual_px[n] ** 2 / limit
            unlike[n, 1], unlike[n, 2] = ((1.0 - right) / _WRONG) ** 2, (light / _BRIGHT) ** 2
            sure[n] = unlike[n].sum() < 1.0
    if usual_px == 0.0 and np.count_nonzero(sure) >= _SOME:
        unlike[:, 0] *= limit / (limit + (_USUAL * np.median(residual_px[sure])) ** 2)
    for n in range(len(poses)):
        good[n] = good[n] and unlike[n].sum() < 1.0


@compiled_part
def _plate(colors: Floats, classes: Indices, parts: int) -> float:
    """Light of the parts without a colour over that of the parts with one."""
    dark, bright, dull, colored = 0.0, 0.0, 0, 0
    for k in range(parts):
        squares = 0.0
        for channel in range(3):
            squares += max(colors[k, channel], 0.0) ** 2
        if classes[k] == 0:
            dark, dull = dark + np.sqrt(squares), dull + 1
        else:
            bright, colored = bright + np.sqrt(squares), colored + 1
    return dark / max(dull, 1) * colored / max(bright, 1.0)
