"""How well the robots were seen, against the truth at the moments of capture."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from control.command import RobotId
from control.geometry import wrap_angle
from datasets.scores import rms
from datasets.track import TruthTrack
from vision.camera import CameraModel

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Places = NDArray[np.intp]

STRANGER = -1
"""The place of a detection that is none of the robots'."""


@dataclass(frozen=True, slots=True)
class VisionScore:
    """How well the robots were seen, against the truth at the moments of capture.

    Attributes:
        recall: share of the robots wholly inside the image that were found where they are.
        false_ids: detections farther than half a side from the robot of that id.
        position_rms_m: of the right detections [m].
        heading_rms_rad: of the right detections [rad].
    """

    recall: float | None
    false_ids: int
    position_rms_m: float | None
    heading_rms_rad: float | None


@dataclass(frozen=True, slots=True)
class Sighted:
    """How often a robot was seen.

    Attributes:
        robot_id: the robot.
        frames: number of frames it was recognised in.
    """

    robot_id: RobotId
    frames: int


@dataclass(frozen=True, slots=True)
class Sightings:
    """All that was seen in F frames: N detections.

    Attributes:
        captures: shape (F,), capture times [s].
        frames: shape (N,), the frame of each detection.
        places: shape (N,), whose each is: place among the robots, or STRANGER.
        poses: shape (N, 3) [m, m, rad].
    """

    captures: Floats
    frames: Places
    places: Places
    poses: Floats


def sighted(seen: Sightings, ids: tuple[RobotId, ...]) -> tuple[Sighted, ...]:
    """Count the frames in which each robot was recognised.

    Args:
        seen: in all frames.
        ids: of the robots, in the order of their places.

    Returns:
        One count per robot, in the given order.
    """
    return tuple(Sighted(robot, int((seen.places == n).sum())) for n, robot in enumerate(ids))


def vision_score(
    seen: Sightings, track: TruthTrack, camera: CameraModel, side: float
) -> VisionScore:
    """Compare what was seen with the truth at the moments of capture.

    Args:
        seen: in all frames.
        track: where the R robots were.
        camera: who looked.
        side: of the square tags [m].

    Returns:
        The score.
    """
    true = track.at(seen.captures)
    inside = wholly_inside(true, camera, side)
    off = seen.poses - true[seen.frames, seen.places]
    distances = np.hypot(off[:, 0], off[:, 1])
    right = (seen.places != STRANGER) & (distances < 0.5 * side)
    found = np.zeros(inside.shape, bool)
    found[seen.frames[right], seen.places[right]] = True
    turns = np.array([wrap_angle(turn) for turn in off[right, 2].tolist()])
    recall = float(found[inside].mean()) if inside.any() else None
    return VisionScore(recall, int((~right).sum()), rms(distances[right]), rms(turns))


def wholly_inside(poses: Floats, camera: CameraModel, side: float) -> Flags:
    """Which robots' tags lie inside the image with all four corners.

    Args:
        poses: shape (..., 3) [m, m, rad].
        camera: who looks.
        side: of the square tags [m].

    Returns:
        Shape (...).
    """
    corners = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * (0.5 * side)
    c, s = np.cos(poses[..., 2, None]), np.sin(poses[..., 2, None])
    points = np.empty((*poses.shape[:-1], 4, 3))
    points[..., 0] = poses[..., 0, None] + c * corners[:, 0] - s * corners[:, 1]
    points[..., 1] = poses[..., 1, None] + s * corners[:, 0] + c * corners[:, 1]
    points[..., 2] = camera.tag_height
    pixels = camera.project(points.reshape(-1, 3)).reshape(*points.shape[:-1], 2)
    inside = (pixels > -0.5) & (pixels < np.array(camera.size_px) - 0.5)
    whole: Flags = np.asarray(inside.all(axis=(-2, -1)))
    return whole
