"""Tags partly under a hand or a cable, or with something beside them: what tells where they are.

A robot that is followed and whose fit is in doubt is fitted again to those pixels that can be its
own (`vision.veil`). It is believed if these say well enough where it is.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vision.eye import Eye
from vision.fit import Fit, empty_fit
from vision.gauge import Gauge
from vision.identity import Prediction
from vision.own_pixels import Known
from vision.veil import fit_veiled

Floats = NDArray[np.float64]
Bytes = NDArray[np.uint8]
Indices = NDArray[np.intp]
Flags = NDArray[np.bool_]

_DOUBTFUL_PX, _DOUBTFUL_SHARE, _DOUBTFUL = 0.17, 0.006, 1.8  # misfit that makes one think: in
# pixels, of the tag's side, times the usual one
_BLURRED, _NOISY = 0.255, 0.05  # or per px of an edge's width: by itself, per grey level of noise
_LEAST = 0.12  # strange share of a tag's pixels from which on something lies on it
_MOST = 0.8  # and up to which it may be believed
_GONE = 0.9  # share of a part from which on nothing is seen of it
_SURPRISE, _SPREADS = np.array((0.003, 0.1)), 1.5  # from where a robot is expected: a fit stays
# there, or within so many standard deviations [m], [rad]
_DOUBT = np.diag((0.002**2, 0.002**2, 0.06**2))  # of a doubtful fit that did [m^2, rad^2]
_TOLD_PX = 0.045  # standard deviation of a covered tag that may be believed, at most
_SLACKS = np.array((1.0, 0.6, 0.36, 0.2, 0.12, 0.08, 0.08))  # of the pose, from step to step
_MARGIN = 0.0003  # and at least [m]
_LEAST_SPREAD, _MOST_SPREAD = np.array((0.002, 0.04)), np.array((0.006, 0.1))  # [m], [rad]
_UNSURE = 2.0  # covers have rims that are half seen: factor on covariances


class Followed(NamedTuple):
    """Robots that are followed, as they were expected.

    Attributes:
        tags: shape (N,), indices in the tag set.
        poses: shape (N, 3) [m, m, rad].
        spreads: shape (N, 2), standard deviations along an axis, and of the heading [m, rad].
    """

    tags: Indices
    poses: Floats
    spreads: Floats


def doubtful_px(eye: Eye, usual_px: float) -> float:
    """Misfit of a tracked tag beyond which something may lie on it.

    Args:
        eye: tags and camera.
        usual_px: misfit of tags through this camera [px].

    Returns:
        The limit [px].
    """
    side_px = 2.0 * eye.gauge.arm * float(eye.gauge.scales[0])
    soft = max(_BLURRED, _NOISY * eye.optics.noise) * eye.optics.edge_px
    return max(_DOUBTFUL_PX, _DOUBTFUL_SHARE * side_px, _DOUBTFUL * usual_px, soft)


def follow_up(tags: Indices, poses: Floats, predictions: list[Prediction]) -> Followed:
    """Put together how well followed robots are expected.

    Args:
        tags: shape (N,), indices in the tag set.
        poses: shape (N, 3) [m, m, rad].
        predictions: the N.

    Returns:
        The robots as they were expected.
    """
    variances = np.array([np.diag(p.covariance) for p in predictions])
    spreads = np.sqrt(np.column_stack((0.5 * (variances[:, 0] + variances[:, 1]), variances[:, 2])))
    return Followed(tags, poses, np.clip(np.nan_to_num(spreads), _LEAST_SPREAD, _MOST_SPREAD))


def uncover(
    image: Bytes, eye: Eye, fit: Fit, followed: Followed, doubtful: Indices, good: Flags,
    gains: Floats,
) -> tuple[Indices, Floats]:  # fmt: skip
    """Fit doubtful robots without what is not their own.

    Args:
        image: shape (H, W, 3), BGR.
        eye: templates, noise and colours.
        fit: of all robots; rows of those that are seen well enough are put in their place.
        followed: the robots.
        doubtful: shape (R,), which of them to fit again.
        good: shape (N,), which could be accepted as they are: near where they are expected they
            are, if nothing better is found, but less is known of them.
        gains: shape (3,), factors of the light on the palette's colours, BGR.

    Returns:
        Those of which too much is covered, shape (C,), and the share of each that is.
    """
    veiled, shares = [], []
    stayed = _stayed(fit.poses, followed)
    for n in doubtful.tolist():
        again, hidden = _fit_again(image, eye, followed, n, gains)
        if _is_told(again, eye.gauge, hidden[-1]) and _is_known(eye, followed.tags[n], hidden):
            fit.put(np.array((n,)), again)
        elif good[n] and stayed[n]:
            fit.covariances[n] += _DOUBT
        elif hidden[-1] > _LEAST:
            veiled.append(n)
            shares.append(hidden[-1])
    return np.array(veiled, np.intp), np.array(shares)


def _stayed(poses: Floats, followed: Followed) -> Flags:
    """Which poses (N, 3) are where they were expected, as far as a tracked robot's can be told."""
    away, reach = poses - followed.poses, np.maximum(_SURPRISE, _SPREADS * followed.spreads)
    turn = (away[:, 2] + np.pi) % (2.0 * np.pi) - np.pi
    near = np.hypot(away[:, 0], away[:, 1]) < reach[:, 0]
    return np.asarray(near & (np.abs(turn) < reach[:, 1]))


def _is_known(eye: Eye, tag: int, hidden: Floats) -> bool:
    """Whether the parts of which something is seen have colours that no other tag has there."""
    looks = eye.looks
    others = (looks.shape_of == looks.shape_of[tag]) & (
        np.array(eye.tags.alike) != eye.tags.alike[tag]
    )
    seen = hidden[:-1] < _GONE
    return bool((looks.classes[others][:, seen] != looks.classes[tag, seen]).any(axis=1).all())


def _fit_again(
    image: Bytes, eye: Eye, followed: Followed, n: int, gains: Floats
) -> tuple[Fit, Floats]:
    """Fit a robot (one row) without what is not its own; the share of parts and all that is not."""
    tag, pose = followed.tags[n], followed.poses[n]
    spread = followed.spreads[n, (0, 0, 1)]
    known = Known(int(eye.looks.shape_of[tag]), pose, spread, eye.looks.typical[tag] * gains)
    parts = eye.looks.typical.shape[1]
    again = empty_fit(1, parts)
    center, hidden = eye.camera.tag_pixels(pose[None])[0], np.empty(parts + 1)
    misfit = fit_veiled(
        image, eye.gauge, known, center, _SLACKS, _MARGIN, again.poses[0], again.covariances[0],
        again.colors[0], hidden,
    )  # fmt: skip
    again.covariances[:] *= _UNSURE
    again.settled[0] = True
    again.residual_px[0] = misfit * eye.gauge.scales[0]
    return again, hidden


def _is_told(again: Fit, gauge: Gauge, hidden: float) -> bool:
    """Whether what is seen of a robot tells well enough where it is."""
    deviation = np.sqrt((again.covariances[0, 0, 0] + again.covariances[0, 1, 1]) / _UNSURE)
    return bool(hidden < _MOST and deviation * gauge.scales[0] < _TOLD_PX)
