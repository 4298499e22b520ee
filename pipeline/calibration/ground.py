"""Whether the floor about a robot is clear enough to drive a pattern on it."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import cos, hypot, pi, sin

import numpy as np

from control.command import RobotId
from control.geometry import Pose2D
from control.safety import Arena
from pipeline.calibration.pattern import Pattern
from pipeline.calibration.watch import Bench, Circle, Sight
from pipeline.config import Scenario
from pipeline.errors import ConfigError
from pipeline.looking import look
from vision.camera import CameraModel

STANDING = 0.03
"""A robot that is not to leave its place is seen no farther from it [m]."""

_RIM = 16  # points of a circle that must be in the picture


@dataclass(frozen=True, slots=True)
class Ground:
    """What there is on the floor.

    Attributes:
        arena: what no body may leave.
        camera: that looks down on it.
        body: radius of a circle about a body [m].
        spare: distance that is kept between bodies, and to the border [m].
    """

    arena: Arena
    camera: CameraModel
    body: float
    spare: float

    def needed(self, circle: Circle) -> float:
        """Clear floor about the middle of a circle.

        Args:
            circle: where the middle of the robot will be.

        Returns:
            Its radius with the body and what is kept free [m].
        """
        return circle.radius + self.body + self.spare


@dataclass(frozen=True, slots=True)
class Thing:
    """Something that is no robot.

    Attributes:
        x: where it is, if it is as high as tags are [m].
        y: the same [m].
        reason: why it is no robot.
    """

    x: float
    y: float
    reason: str


def make_ground(scenario: Scenario, camera: CameraModel, side: float) -> Ground:
    """The floor of a scenario.

    Args:
        scenario: checked scenario.
        camera: that looks down on it.
        side: of the square bodies [m].

    Returns:
        The ground.

    Raises:
        ConfigError: if the scenario says no arena.
    """
    if scenario.safety.arena_m is None:
        raise ConfigError(
            f"scenario {scenario.name}: missing key safety.arena_m: robots are moved only inside "
            "a stated arena, [x_low, y_low, x_high, y_high]"
        )
    arena = Arena(*scenario.safety.arena_m)
    return Ground(arena, camera, side * 0.5**0.5, scenario.safety.clearance_m)


def circle_about(pose: Pose2D, pattern: Pattern) -> Circle:
    """Where a robot must stay while it drives a pattern.

    Args:
        pose: of its tag before [m, m, rad].
        pattern: what it will be told.

    Returns:
        A circle that it leaves only if something is wrong.
    """
    return Circle(pose.x, pose.y, pattern.reach() + STANDING)


def survey(
    bench: Bench, sight: Sight, ground: Ground, pattern: Pattern
) -> Mapping[RobotId, tuple[Circle, tuple[str, ...]]]:
    """Say for every robot whether it could drive a pattern where it stands.

    Args:
        bench: finds the robots.
        sight: with a picture that is still true, of robots that stand.
        ground: on which they stand.
        pattern: to be driven.

    Returns:
        By robot the circle it needs, and what is in its way with the remedy.
    """
    poses = {robot: track.estimate.state.pose for robot, track in sight.tracks.items()}
    things = _things(bench, sight, ground, poses)
    circles = {robot: circle_about(pose, pattern) for robot, pose in poses.items()}
    return {
        robot: (circle, _obstacles(ground, poses, things, robot, circle))
        for robot, circle in circles.items()
    }


def _things(
    bench: Bench, sight: Sight, ground: Ground, poses: Mapping[RobotId, Pose2D]
) -> tuple[Thing, ...]:
    """What looks like a part of a tag, in a fresh look without predictions, and is on no robot."""
    if sight.frame is None:
        return ()
    rejected = look(bench.lookout.seeing.detector_for(sight.frame.size_px), sight.frame).rejected
    pixels = np.array([(thing.x, thing.y) for thing in rejected]).reshape(-1, 2)
    places = ground.camera.to_floor(pixels, ground.camera.tag_height).tolist()
    things = [Thing(x, y, r.reason) for (x, y), r in zip(places, rejected, strict=True)]
    return tuple(
        thing
        for thing in things
        if all(hypot(thing.x - p.x, thing.y - p.y) > ground.body for p in poses.values())
    )


def _obstacles(
    ground: Ground,
    poses: Mapping[RobotId, Pose2D],
    things: Sequence[Thing],
    robot: RobotId,
    circle: Circle,
) -> tuple[str, ...]:
    """One line per obstacle; nothing if the way is clear."""
    others = {other: pose for other, pose in poses.items() if other != robot}
    return tuple(
        f"robot {robot} needs {ground.needed(circle):.2f} m of clear floor about it: {what}"
        for what in (
            *_border(ground, circle),
            *_robots(ground, others, circle),
            *_strange(ground, things, circle),
        )
    )


def _border(ground: Ground, circle: Circle) -> Iterator[str]:
    """The arena's sides and those of the picture."""
    a = ground.arena
    sides = circle.x - a.x_low, a.x_high - circle.x, circle.y - a.y_low, a.y_high - circle.y
    if min(sides) < ground.needed(circle):
        yield f"the border of safety.arena_m is {min(sides):.2f} m away; move it inwards"
    if not _is_in_picture(ground, circle):
        yield "the picture ends before; move it inwards"


def _is_in_picture(ground: Ground, circle: Circle) -> bool:
    """Whether the tag would be seen on the whole circle."""
    camera, radius = ground.camera, circle.radius + ground.body
    angles = [2.0 * pi * number / _RIM for number in range(_RIM)]
    rim = [
        (circle.x + radius * cos(a), circle.y + radius * sin(a), camera.tag_height) for a in angles
    ]
    pixels = camera.project(np.array(rim))
    return bool(np.all((pixels >= 0.0) & (pixels <= np.array(camera.size_px) - 1.0)))


def _robots(ground: Ground, others: Mapping[RobotId, Pose2D], circle: Circle) -> Iterator[str]:
    for other, pose in others.items():
        away = hypot(pose.x - circle.x, pose.y - circle.y)
        if away - ground.body < ground.needed(circle):
            yield f"robot {other} is {away:.2f} m away; put them farther apart"


def _strange(ground: Ground, things: Sequence[Thing], circle: Circle) -> Iterator[str]:
    for thing in things:
        away = hypot(thing.x - circle.x, thing.y - circle.y)
        if away < ground.needed(circle):
            yield f"something is {away:.2f} m away ({thing.reason}); take it away"
