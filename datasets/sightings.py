"""How well the robots were seen, against the truth at the moments of capture."""

from collections import Counter, deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from control.command import RobotId
from control.geometry import wrap_angle
from datasets.track import TruthTrack
from vision.camera import CameraModel
from vision.scene import Detection, Scene

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
States = tuple[tuple[float, ...], ...]

TOGETHER = 16  # frames that are judged at a time
OLDEST = 2.0  # that a frame may be on its arrival, to be judged well [s]


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


class Sightings:
    """Judges what was seen while a run goes on: the way before the last frames is forgotten."""

    def __init__(self, ids: tuple[RobotId, ...], camera: CameraModel, side: float) -> None:
        """Begin without a frame.

        Args:
            ids: of the R robots.
            camera: who looks.
            side: of the square tags [m].
        """
        self._ids, self._camera, self._side = ids, camera, side
        self._counts = Counter[RobotId]()
        self._waiting: list[Scene] = []
        self._way: deque[tuple[float, States]] = deque()
        self._inside, self._recalled, self._found, self._false = 0, 0, 0, 0
        self._off = np.zeros(2)  # squares of distances and turns, of those that were found
        self.frames = 0

    def take(self, t: float, true: States | None, scene: Scene | None) -> None:
        """Take note of one cycle.

        Args:
            t: its moment [s].
            true: x, y, theta, v, omega of the R robots then; None where nobody knows.
            scene: what was seen in its frame, None without one.
        """
        if scene is not None:
            self.frames += 1
            self._counts.update(d.robot_id for d in scene.detections)
        if true is None:
            return
        if not self._way or t > self._way[-1][0]:  # two ticks may share a moment
            self._way.append((t, true))
        if scene is not None:
            self._waiting.append(scene)
            if len(self._waiting) == TOGETHER:
                self._judge()

    def sighted(self) -> tuple[Sighted, ...]:
        """Count the frames in which each robot was recognised.

        Returns:
            One count per robot, in the given order.
        """
        return tuple(Sighted(robot, self._counts[robot]) for robot in self._ids)

    def score(self) -> VisionScore | None:
        """Compare what was seen with the truth at the moments of capture.

        Returns:
            The score; None without a frame.
        """
        if self._waiting:
            self._judge()
        if not self.frames:
            return None
        recall = self._recalled / self._inside if self._inside else None
        distance, turn = np.sqrt(self._off / self._found).tolist() if self._found else (None, None)
        return VisionScore(recall, self._false, distance, turn)

    def _judge(self) -> None:
        """Compare the frames that wait, and forget what no later one can need."""
        scenes, self._waiting = self._waiting, []
        states = np.array([states for _, states in self._way])
        states[..., 2] = np.unwrap(states[..., 2], axis=0)
        track = TruthTrack(np.array([t for t, _ in self._way]), states)
        true = track.at(np.array([scene.t_capture for scene in scenes]))
        inside = wholly_inside(true, self._camera, self._side)
        self._inside += int(inside.sum())
        for frame, scene in enumerate(scenes):
            for detection in scene.detections:
                self._compare(detection, true[frame], inside[frame])
        while self._way[0][0] < self._way[-1][0] - OLDEST:
            self._way.popleft()

    def _compare(self, detection: Detection, true: Floats, inside: Flags) -> None:
        if detection.robot_id not in self._ids:
            self._false += 1
            return
        place = self._ids.index(detection.robot_id)
        distance, turn = _misfit(detection, true[place])
        if not distance < 0.5 * self._side:
            self._false += 1
            return
        self._found += 1
        self._recalled += int(inside[place])
        self._off += distance**2, turn**2


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
