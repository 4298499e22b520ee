"""A frame in, robot poses out: follow and uncover; segment, propose, fit, accept."""

from math import hypot, inf

import numpy as np
from numpy.typing import NDArray

from vision.accept import assign, detections_of, judge, light_ratios
from vision.covered import doubtful_px, follow_up, uncover
from vision.evidence import refuse_unlike
from vision.eye import Eye
from vision.frame import Frame, check_size
from vision.identify import Candidates, propose
from vision.identity import Expectation, Prediction, expect, with_doubts
from vision.light import PALETTE_LIGHT, Light, refitted, relit, taught, watched
from vision.pose import fit_poses
from vision.scene import Detection, Rejection, Scene
from vision.segment import Blobs, find_blobs
from vision.shortlist import fit_best

__all__ = ["Prediction", "locate"]

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Indices = NDArray[np.intp]

_WORLD = 100.0  # robots are not looked for beyond so many heights of the camera
_SLACK = 3.0  # in the light on robots that are where they are expected
_STEPS = 12  # at most, of Gauss-Newton; 2 or 3 are usual


def locate(
    frame: Frame,
    eye: Eye,
    predictions: tuple[Prediction, ...] = (),
    light: Light = PALETTE_LIGHT,
) -> Scene:
    """Find the robots in a frame.

    Predicted robots are fitted straight from their predictions; only if a robot of the tag set is
    then still missing, the whole frame is searched for it.

    Args:
        frame: what the camera saw.
        eye: camera, tags, palette; everything constant.
        predictions: where robots are expected, those not in the tag set are ignored.
        light: as the last frame's scene told it.

    Returns:
        The robots found, in the order of the tag set, what was not accepted, and the light.

    Raises:
        VisionError: if the frame's size is not the camera's.
    """
    check_size(frame, eye.camera.size_px)
    light = watched(light, frame.image)
    known = expect(eye.tags, predictions) if eye.tags.look_alikes else None
    found, rejected, light = _follow(frame, eye, predictions, known, light)
    missing = _missing(found, eye)
    if missing.any():
        known = known or expect(eye.tags, predictions)
        more, reasons = _search(frame, eye, missing, found, known, light)
        found, rejected = found + more, rejected + reasons
    if known is not None and eye.tags.look_alikes:
        found = with_doubts(found, eye.tags, known)
    light = refitted(light, [detection.residual_px for detection in found])
    if not found and not predictions:
        light = relit(light)
    order = {robot_id: rank for rank, robot_id in enumerate(eye.tags.ids)}
    ranked = sorted(found, key=lambda detection: order[detection.robot_id])
    return Scene(frame.t_capture, tuple(ranked), rejected, light)


def _follow(
    frame: Frame,
    eye: Eye,
    predictions: tuple[Prediction, ...],
    among: Expectation | None,
    light: Light,
) -> tuple[tuple[Detection, ...], tuple[Rejection, ...], Light]:
    """Fit the predicted robots where they are expected; they tell the light."""
    if not predictions:
        return (), (), light
    index = {robot_id: n for n, robot_id in enumerate(eye.tags.ids)}
    known = _near_camera([p for p in predictions if p.robot_id in index], eye)
    if not known:
        return (), (), light
    tags = np.array([index[p.robot_id] for p in known])
    poses = np.array([(p.pose.x, p.pose.y, p.pose.theta) for p in known])
    centers = eye.camera.tag_pixels(poses)
    start = Candidates(eye.looks.shape_of[tags], poses, centers, np.ones(len(known)))
    alike = np.array(eye.tags.alike)
    possible = alike[tags][:, None] == alike
    fit = fit_poses(frame.image, eye.gauge, start.shapes, poses, centers, _STEPS)
    verdict = judge(fit, start, eye, possible, light.gains, _SLACK)
    lately = np.array([p.reach == 0.0 for p in known])
    doubtful = np.flatnonzero(lately & (fit.residual_px > doubtful_px(eye, light.misfit_px)))
    if len(doubtful):
        followed = follow_up(tags, poses, known)
        veiled = uncover(frame.image, eye, fit, followed, doubtful, verdict.good, light.gains)
        verdict = judge(fit, start, eye, possible, light.gains, _SLACK)
        verdict.refuse_covered(*veiled)
    chosen, rejected = assign(verdict, fit, start, eye, _NOWHERE, among)
    light = taught(light, light_ratios(fit, chosen, eye))
    return detections_of(verdict, fit, chosen, eye), rejected, light


def _search(
    frame: Frame,
    eye: Eye,
    missing: NDArray[np.bool_],
    found: tuple[Detection, ...],
    known: Expectation,
    light: Light,
) -> tuple[tuple[Detection, ...], tuple[Rejection, ...]]:
    """Look for the missing robots in the whole frame."""
    classes = eye.palette.classify(frame.image, light)
    if eye.mask is not None:
        classes &= eye.mask
    blobs = find_blobs(classes, eye.min_blob_px, eye.thresholds.max_blobs)
    blobs = _unexplained(blobs, found, eye)
    candidates, rejected = propose(blobs, classes, eye, np.ones_like(missing))
    if len(candidates) == 0:
        return (), rejected
    candidates, fit = fit_best(frame.image, eye, candidates)
    everybody = np.ones((len(candidates), len(missing)), np.bool_)
    verdict = judge(fit, candidates, eye, everybody, light.gains)
    if found:
        verdict.keep(missing, eye.thresholds.confidence)
    refuse_unlike(verdict, fit, candidates.shapes, classes, eye, light.misfit_px)
    tracked = known.places[missing & (known.reach == 0.0)]
    if len(tracked):
        veiled = _near(fit.poses, tracked, eye.radius) & (
            fit.residual_px > doubtful_px(eye, light.misfit_px)
        )
        verdict.refuse_covered(np.flatnonzero(veiled), np.ones(np.count_nonzero(veiled)))
    taken = np.array([(d.pose.x, d.pose.y) for d in found]).reshape(-1, 2)
    told = eye.tags.look_alikes or np.isfinite(known.places).any()
    among = known if told else None
    chosen, reasons = assign(verdict, fit, candidates, eye, taken, among)
    return detections_of(verdict, fit, chosen, eye), rejected + reasons


_NOWHERE = np.zeros((0, 2))


def _near(poses: Floats, places: Floats, reach: float) -> Flags:
    """Which poses (N, 3) are near one of some places (M, 2), shape (N,)."""
    away = np.hypot(*(poses[:, None, :2] - places).transpose(2, 0, 1))
    return np.asarray(away.min(axis=1, initial=np.inf) < reach)


def _missing(found: tuple[Detection, ...], eye: Eye) -> NDArray[np.bool_]:
    """Which tags (T,) were not found."""
    seen = {detection.robot_id for detection in found}
    return np.array([robot_id not in seen for robot_id in eye.tags.ids])


def _near_camera(predictions: list[Prediction], eye: Eye) -> list[Prediction]:
    """Predictions that are finite and within the camera's world."""
    x, y, height = eye.camera.position.tolist()
    reach = _WORLD * height
    return [
        p
        for p in predictions
        if hypot(p.pose.x - x, p.pose.y - y) < reach and abs(p.pose.theta) < inf
    ]


def _unexplained(blobs: Blobs, found: tuple[Detection, ...], eye: Eye) -> Blobs:
    """Blobs that do not lie on a robot already found."""
    if not found or len(blobs) == 0:
        return blobs
    taken = np.array([(d.pixel.x, d.pixel.y) for d in found])
    scale = float(eye.gauge.scales[0])
    away = np.hypot(*(blobs.centers[:, None] - taken).transpose(2, 0, 1)).min(axis=1)
    free = np.flatnonzero(~(away < 0.6 * eye.radius * scale))
    return Blobs(blobs.classes[free], blobs.centers[free], blobs.areas[free], blobs.dropped)
