"""From a wanted motion to the speeds of two wheels that cannot be arbitrarily fast."""

from dataclasses import dataclass

from control.unicycle import Twist, WheelSpeeds, wheels_from_twist


@dataclass(frozen=True, slots=True)
class Wheels:
    """A robot's two wheels.

    Attributes:
        track_width: between them [m].
        radius: of a wheel [m].
        fastest: speed of a wheel's rim that is never exceeded [m/s].
    """

    track_width: float = 0.068
    radius: float = 0.026
    fastest: float = 2.0


def limited_wheels(twist: Twist, track_width: float, fastest: float) -> WheelSpeeds:
    """Turn a twist into wheel speeds within reach.

    Beyond the limit both wheels are reduced alike: the robot is slower, on the same curve.

    Args:
        twist: wanted velocities, finite [m/s, rad/s].
        track_width: between the wheels [m].
        fastest: limit of a wheel's speed, > 0 [m/s].

    Returns:
        Speeds in [-fastest, fastest] [m/s].
    """
    wheels = wheels_from_twist(twist, track_width)
    greatest = max(abs(wheels.left), abs(wheels.right))
    share = fastest / greatest if greatest > fastest else 1.0
    return WheelSpeeds(wheels.left * share, wheels.right * share)
