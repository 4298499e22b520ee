"""What is sent to a robot, and to whom."""

from dataclasses import dataclass
from typing import TypeAlias

from control.unicycle import Twist

RobotId: TypeAlias = int | str


@dataclass(frozen=True, slots=True)
class Command:
    """A velocity command for one robot.

    Attributes:
        robot_id: the robot that is to obey.
        twist: commanded velocities [m/s, rad/s].
        t_effective: when it reaches the wheels, on the capture clock [s].
        valid_until: never sent after this time [s].
    """

    robot_id: RobotId
    twist: Twist
    t_effective: float
    valid_until: float
