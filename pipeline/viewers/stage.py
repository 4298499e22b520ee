"""What a viewer draws on: the fixed things of a run, and shapes in floor coordinates."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import cos, pi, sin

import numpy as np
from numpy.typing import NDArray

from control.command import RobotId
from control.geometry import Pose2D
from control.placement import wanted_pose
from datasets.cycle import PairState, RobotState
from vision.camera import CameraModel
from vision.tags import Tag

Floats = NDArray[np.float64]

# The palette of Okabe and Ito, lightened for a dark ground: told apart by colour-blind people too.
_LEADER = (240, 240, 240)
_FOLLOWERS = (
    (86, 180, 233),
    (245, 165, 36),
    (46, 200, 155),
    (226, 140, 190),
    (250, 110, 60),
    (120, 130, 250),
)


@dataclass(frozen=True, slots=True)
class Stage:
    """Fixed things of a run that a viewer draws.

    Attributes:
        camera: sees the field.
        tags: one per robot; the first part is its outline.
        camera_offset: from a follower's axle forward to its camera point, d [m].
        path: planned path of the formation's leader, shape (N, 2) [m]; N = 0 if there is none.
        obstacles: x, y and radius of discs that it drives round, where they are at first [m].
        worn: radius of the disc about each robot that it drives round [m].
    """

    camera: CameraModel
    tags: tuple[Tag, ...]
    camera_offset: float
    path: Floats
    obstacles: tuple[tuple[float, float, float], ...] = ()
    worn: Mapping[RobotId, float] = field(default_factory=dict)

    def color(self, robot_id: RobotId) -> tuple[int, int, int]:
        """Colour of a robot in every view.

        Args:
            robot_id: any robot.

        Returns:
            Red, green and blue, 0 to 255; white for the first tag's robot.
        """
        ids = [tag.robot_id for tag in self.tags]
        index = ids.index(robot_id) if robot_id in ids else len(ids)
        return _FOLLOWERS[(index - 1) % len(_FOLLOWERS)] if index else _LEADER

    def outline(self, robot_id: RobotId, pose: Pose2D) -> Floats:
        """Closed outline of a robot on the floor.

        Args:
            robot_id: whose outline.
            pose: where it stands [m, m, rad].

        Returns:
            Corners, the first one repeated at the end, shape (N + 1, 2) [m].
        """
        plates = [tag.parts[0].polygon for tag in self.tags if tag.robot_id == robot_id]
        plate = plates[0] if plates else _SQUARE
        return placed(np.vstack((plate, plate[:1])), pose)

    def on_screen(self, points: Floats) -> Floats:
        """Project points at the height of the tags into the picture.

        Args:
            points: shape (N, 2) [m].

        Returns:
            Pixels, shape (N, 2).
        """
        height = np.full((len(points), 1), self.camera.tag_height)
        return self.camera.project(np.hstack((points, height)))

    def field(self) -> Floats:
        """What the camera sees of the floor.

        Returns:
            Corners of the picture on the floor, the first one repeated, shape (5, 2) [m].
        """
        right, low = self.camera.size_px[0] - 0.5, self.camera.size_px[1] - 0.5
        corners = [(-0.5, -0.5), (right, -0.5), (right, low), (-0.5, low), (-0.5, -0.5)]
        return self.camera.to_floor(np.array(corners, dtype=np.float64), 0.0)

    def wanted_pose(
        self, pairs: Sequence[PairState], robots: tuple[RobotState, ...]
    ) -> Pose2D | None:
        """Where a follower should be now, with its heading as it is.

        Args:
            pairs: the follower, its leaders and its references.
            robots: predicted states of all robots.

        Returns:
            The pose [m, m, rad], None if one of them is not known.
        """
        poses = {robot.robot_id: robot.state.pose for robot in robots}
        follower = poses.get(pairs[0].follower)
        leaders = [poses[pair.leader] for pair in pairs if pair.leader in poses]
        if follower is None or len(leaders) < len(pairs):
            return None
        references = [pair.reference for pair in pairs]
        return wanted_pose(leaders, references, follower, self.camera_offset)


_SQUARE = 0.0375 * np.array([(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)])


def name_of(robot_id: RobotId) -> str:
    """How a robot is called on the screen.

    Args:
        robot_id: number or name.

    Returns:
        The paper's R1, R2 ... for numbers, names as they are.
    """
    return f"R{robot_id}" if isinstance(robot_id, int) else robot_id


def placed(points: Floats, pose: Pose2D) -> Floats:
    """Map points of a robot's frame to the floor.

    Args:
        points: shape (N, 2) [m].
        pose: of the robot [m, m, rad].

    Returns:
        Points on the floor, shape (N, 2) [m].
    """
    c, s = cos(pose.theta), sin(pose.theta)
    on_floor: Floats = points @ np.array([[c, s], [-s, c]]) + (pose.x, pose.y)
    return on_floor


def circle(x: float, y: float, radius: float) -> Floats:
    """A closed circle as a polyline.

    Args:
        x: of the centre [m or px].
        y: of the centre [m or px].
        radius: of the circle [m or px].

    Returns:
        Points, shape (25, 2) [m or px].
    """
    angle = np.linspace(0.0, 2.0 * pi, 25)
    return np.column_stack((x + radius * np.cos(angle), y + radius * np.sin(angle)))


def grid(low: Floats, high: Floats, spacing: float = 0.5) -> list[Floats]:
    """Lines at round coordinates, in Rerun's orientation (y negated) like all the floor is drawn.

    Args:
        low: smallest x and y, shape (2,) [m].
        high: largest x and y, shape (2,) [m].
        spacing: between lines [m].

    Returns:
        Lines, each of shape (2, 2) [m].
    """
    xs = np.arange(np.ceil(low[0] / spacing), high[0] / spacing) * spacing
    ys = np.arange(np.ceil(low[1] / spacing), high[1] / spacing) * spacing
    upright = [np.array([(x, -low[1]), (x, -high[1])]) for x in xs]
    return upright + [np.array([(low[0], -y), (high[0], -y)]) for y in ys]


def dashes(path: Floats, length: float = 0.03) -> list[Floats]:
    """Cut a polyline into dashes, in Rerun's orientation (y negated).

    Args:
        path: shape (N, 2) [m].
        length: of a dash and of a gap [m].

    Returns:
        Dashes, each of shape (M, 2) [m]; none for fewer than two points.
    """
    if len(path) < 2:
        return []
    way = np.concatenate(([0.0], np.hypot(*np.diff(path, axis=0).T).cumsum()))
    starts = np.arange(0.0, way[-1], 2.0 * length)
    at = starts[:, None] + np.linspace(0.0, length, 4)
    return [
        np.column_stack((np.interp(s, way, path[:, 0]), -np.interp(s, way, path[:, 1]))) for s in at
    ]
