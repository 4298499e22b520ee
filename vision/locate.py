"""A frame in, robot poses out, in five stages: follow, segment, propose, fit, accept."""

from dataclasses import dataclass
from math import hypot, inf

import numpy as np
from numpy.typing import NDArray

from control.command import RobotId
from control.geometry import Pose2D
from vision.accept import assign, judge
from vision.errors import VisionError
from vision.eye import Eye
from vision.frame import Frame
from vision.identify import Candidates, propose
from vision.pose import fit_poses
from vision.scene import Detection, Rejection, Scene
from vision.segment import Blobs, find_blobs

Floats = NDArray[np.float64]

_WORLD = 100.0  # robots are not looked for beyond so many heights of the camera
_STEPS = 8  # at most, of Gauss-Newton; 2 or 3 are usual


@dataclass(frozen=True, slots=True)
class Prediction:
    """Where a robot is expected in the frame.

    Attributes:
        robot_id: the robot.
        pose: on the floor [m, m, rad].
        covariance: of the pose, shape (3, 3) [m^2, m rad, rad^2].
    """

    robot_id: RobotId
    pose: Pose2D
    covariance: Floats


def locate(frame: Frame, eye: Eye, predictions: tuple[Prediction, ...] = ()) -> Scene:
    """Find the robots in a frame.

    Predicted robots are fitted straight from their predictions; only if a robot of the tag set is
    then still missing, the whole frame is searched for it.

    Args:
        frame: what the camera saw.
        eye: camera, tags, palette; everything constant.
        predictions: where robots are expected, those not in the tag set are ignored.

    Returns:
        The robots found, in the order of the tag set, and what was not accepted.

    Raises:
        VisionError: if the frame's size is not the camera's.
    """
    if frame.size_px != eye.camera.size_px:
        (w, h), (cw, ch) = frame.size_px, eye.camera.size_px
        raise VisionError(f"frame of {w} x {h} px, but the camera model is for {cw} x {ch} px")
    found, rejected = _follow(frame, eye, predictions)
    missing = _missing(found, eye)
    if missing:
        more, rejected = _search(frame, eye, missing, found)
        found += more
    order = {robot_id: rank for rank, robot_id in enumerate(eye.tags.ids)}
    ranked = sorted(found, key=lambda detection: order[detection.robot_id])
    return Scene(frame.t_capture, tuple(ranked), rejected)


_Outcome = tuple[tuple[Detection, ...], tuple[Rejection, ...]]


def _follow(frame: Frame, eye: Eye, predictions: tuple[Prediction, ...]) -> _Outcome:
    """Fit the predicted robots where they are expected."""
    index = {robot_id: n for n, robot_id in enumerate(eye.tags.ids)}
    known = [p for p in predictions if p.robot_id in index and _is_near(p.pose, eye)]
    if not known:
        return (), ()
    tags = np.array([index[p.robot_id] for p in known])
    poses = np.array([(p.pose.x, p.pose.y, p.pose.theta) for p in known])
    start = Candidates(eye.shape_of[tags], poses, np.ones(len(known)))
    possible = tags[:, None] == np.arange(len(eye.tags.tags))
    return _accepted(frame, eye, start, possible, np.zeros((0, 2)))


def _search(
    frame: Frame, eye: Eye, missing: tuple[int, ...], found: tuple[Detection, ...]
) -> _Outcome:
    """Look for the missing robots in the whole frame."""
    taken = np.array([(d.pose.x, d.pose.y) for d in found]).reshape(-1, 2)
    classes = eye.palette.classify(frame.image)
    blobs = find_blobs(classes, eye.min_blob_px, eye.thresholds.max_blobs)
    candidates, rejected = propose(_unexplained(blobs, taken, eye), classes, eye, missing)
    if len(candidates) == 0:
        return (), rejected
    possible = np.zeros((len(candidates), len(eye.tags.tags)), bool)
    possible[:, list(missing)] = True
    detections, reasons = _accepted(frame, eye, candidates, possible, taken)
    return detections, rejected + reasons


def _accepted(
    frame: Frame,
    eye: Eye,
    candidates: Candidates,
    possible: NDArray[np.bool_],
    taken: Floats,
) -> _Outcome:
    """Fit candidates and accept them or not."""
    fit = fit_poses(frame.image, eye, candidates.shapes, candidates.poses, _STEPS)
    verdict = judge(fit, candidates, eye, possible)
    return assign(verdict, fit, eye, taken)


def _missing(found: tuple[Detection, ...], eye: Eye) -> tuple[int, ...]:
    """Indices of the tags that were not found."""
    seen = {detection.robot_id for detection in found}
    return tuple(n for n, robot_id in enumerate(eye.tags.ids) if robot_id not in seen)


def _is_near(pose: Pose2D, eye: Eye) -> bool:
    """Whether a prediction is finite and within the camera's world; False for nan."""
    x, y, height = eye.camera.position.tolist()
    return hypot(pose.x - x, pose.y - y) < _WORLD * height and abs(pose.theta) < inf


def _unexplained(blobs: Blobs, taken: Floats, eye: Eye) -> Blobs:
    """Blobs that do not lie on a robot already found."""
    if len(taken) == 0 or len(blobs) == 0:
        return blobs
    floor = eye.camera.to_floor(blobs.centers, eye.camera.tag_height)
    away = np.hypot(*(floor[:, None] - taken).transpose(2, 0, 1)).min(axis=1)
    free = np.flatnonzero(~(away < 0.6 * eye.radius))
    return Blobs(blobs.classes[free], blobs.centers[free], blobs.areas[free], blobs.dropped)
