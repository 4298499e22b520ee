"""A field to test on: tags, colours, cameras and random poses."""

from math import pi

import numpy as np
from numpy.typing import ArrayLike, NDArray

from control.unicycle import UnicycleState
from datasets.cycle import RobotState
from vision.palette import NamedColor
from vision.tags import Part, Tag, TagSet, polygon_array

SIDE = 0.075  # of the tags [m]
REAR_COLORS = ("red", "green", "blue", "cyan", "magenta", "orange", "violet")
COLORS = tuple(
    NamedColor(name, bgr)
    for name, bgr in (
        ("yellow", (30, 220, 255)),
        ("red", (45, 40, 210)),
        ("green", (60, 150, 30)),
        ("blue", (210, 90, 40)),
        ("cyan", (200, 180, 40)),
        ("magenta", (160, 60, 210)),
        ("orange", (20, 120, 240)),
        ("violet", (150, 50, 100)),
        ("white", (255, 255, 255)),
    )
)


def rectangle(x0: float, x1: float, half: float) -> NDArray[np.float64]:
    """Outline of a rectangle across the robot's x axis [m]."""
    return polygon_array([[x1, half], [x0, half], [x0, -half], [x1, -half]])


def two_patch_tags(count: int) -> TagSet:
    """Tags of robots 1 to count: yellow in front, the robot's colour behind, a black rim."""
    plate, front = rectangle(-0.0375, 0.0375, 0.0375), rectangle(0.003, 0.032, 0.032)
    rear = rectangle(-0.032, -0.003, 0.032)
    return TagSet(
        tuple(
            Tag(
                number,
                (
                    Part("plate", plate, "black"),
                    Part("front", front, "yellow"),
                    Part("rear", rear, color),
                ),
            )
            for number, color in enumerate(REAR_COLORS[:count], 1)
        )
    )


def robot(robot_id: int, x: float, y: float, theta: float = 0.0) -> RobotState:
    """A robot at rest [m, m, rad]."""
    return RobotState(robot_id, UnicycleState(x, y, theta, 0.0, 0.0))


def scattered(
    rng: np.random.Generator, count: int, low: ArrayLike, high: ArrayLike
) -> tuple[RobotState, ...]:
    """Robots at random places of a rectangle, at least 0.11 m apart, with random headings."""
    places: list[NDArray[np.float64]] = []
    while len(places) < count:
        place = rng.uniform(low, high)
        if all(np.hypot(*(place - other)) > 0.11 for other in places):
            places.append(place)
    return tuple(
        robot(number, *place, rng.uniform(-pi, pi)) for number, place in enumerate(places, 1)
    )
