"""How well the robots were seen, against the truth at the moments of capture."""

from collections import Counter
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from control.command import RobotId
from control.geometry import wrap_angle
from datasets.scores import rms
from datasets.track import TruthTrack
from vision.camera import CameraModel
from vision.scene import Detection, Scene

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]


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


def sighted(scenes: tuple[Scene, ...], ids: tuple[RobotId, ...]) -> tuple[Sighted, ...]:
    """Count the frames in which each robot was recognised.

    Args:
        scenes: one per frame.
        ids: robots to count.

    Returns:
        One count per robot, in the given order.
    """
    counts = Counter(d.robot_id for scene in scenes for d in scene.detections)
    return tuple(Sighted(robot, counts[robot]) for robot in ids)


def vision_score(
    scenes: tuple[Scene, ...],
    ids: tuple[RobotId, ...],
    track: TruthTrack,
    camera: CameraModel,
    side: float,
) -> VisionScore:
    """Compare what was seen with the truth at the moments of capture.

    Args:
        scenes: of all frames.
        ids: of the track's R robots.
        track: where they were.
        camera: who looked.
        side: of the square tags [m].

    Returns:
        The score.
    """
    true = track.at(np.array([scene.t_capture for scene in scenes]))
    inside = wholly_inside(true, camera, side)
    found = np.zeros(inside.shape, bool)
    off: list[tuple[float, float]] = []
    false = 0
    for frame, scene in enumerate(scenes):
        for detection in scene.detections:
            place = ids.index(detection.robot_id) if detection.robot_id in ids else None
            distance, turn = _misfit(detection, true[frame, place or 0])
            if place is None or not distance < 0.5 * side:
                false += 1
                continue
            found[frame, place] = True
            off.append((distance, turn))
    distances, turns = np.array(off).reshape(-1, 2).T
    recall = float(found[inside].mean()) if inside.any() else None
    return VisionScore(recall, false, rms(distances), rms(turns))


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


def _misfit(detection: Detection, true: Floats) -> tuple[float, float]:
    """Distance [m] and turn [rad] from the truth to what was seen."""
    pose = detection.pose
    distance = float(np.hypot(pose.x - true[0], pose.y - true[1]))
    return distance, wrap_angle(pose.theta - float(true[2]))
