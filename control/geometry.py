"""Planar poses and angles. Transforms name their frames: ``T_floor_robot`` maps robot to floor."""

from dataclasses import dataclass
from math import cos, pi, sin

from control.compilable import compilable
from control.value import value

SMALL_TURN = 0.05
"""Up to here short series give sine and cosine to the last bit [rad]."""


@compilable
def wrap_angle(angle: float) -> float:
    """Wrap an angle [rad] to (-pi, pi].

    Args:
        angle: any finite angle [rad].

    Returns:
        The equal angle in (-pi, pi] [rad].
    """
    return angle if -pi < angle <= pi else pi - (pi - angle) % (2.0 * pi)


@compilable
def cos_of_turn(angle: float) -> float:
    """cos, by its series where that is exact to the last bit: turns within a step are small.

    Args:
        angle: any [rad].

    Returns:
        Its cosine.
    """
    if abs(angle) > SMALL_TURN:
        return cos(angle)
    square = angle * angle
    beyond = square * square * (1.0 / 24.0 - square * (1.0 / 720.0 - square * (1.0 / 40320.0)))
    return 1.0 - 0.5 * square + beyond


@compilable
def sin_of_turn(angle: float) -> float:
    """sin, as `cos_of_turn`.

    Args:
        angle: any [rad].

    Returns:
        Its sine.
    """
    return angle * sine_ratio(angle)


@compilable
def sine_ratio(angle: float) -> float:
    """sin(angle) / angle, as `cos_of_turn`.

    Args:
        angle: any [rad].

    Returns:
        The ratio; 1 for 0.
    """
    if abs(angle) > SMALL_TURN:
        return sin(angle) / angle
    square = angle * angle
    return 1.0 - square * (1.0 / 6.0 - square * (1.0 / 120.0 - square * (1.0 / 5040.0)))


@value
@dataclass(frozen=True, slots=True)
class Pose2D:
    """Position [m] and heading [rad] on the floor; equation (1) of the paper.

    Attributes:
        x: forward axis of the reference frame [m].
        y: left axis of the reference frame [m].
        theta: heading, counter-clockwise from x [rad].
    """

    x: float
    y: float
    theta: float


@compilable
def compose(T_a_b: Pose2D, T_b_c: Pose2D) -> Pose2D:
    """Chain two transforms.

    Args:
        T_a_b: pose of frame b in frame a [m, m, rad].
        T_b_c: pose of frame c in frame b [m, m, rad].

    Returns:
        Pose of frame c in frame a [m, m, rad].
    """
    c, s = cos(T_a_b.theta), sin(T_a_b.theta)
    return Pose2D(
        T_a_b.x + c * T_b_c.x - s * T_b_c.y,
        T_a_b.y + s * T_b_c.x + c * T_b_c.y,
        wrap_angle(T_a_b.theta + T_b_c.theta),
    )


@compilable
def inverse(T_a_b: Pose2D) -> Pose2D:
    """Invert a transform.

    Args:
        T_a_b: pose of frame b in frame a [m, m, rad].

    Returns:
        Pose of frame a in frame b [m, m, rad].
    """
    c, s = cos(T_a_b.theta), sin(T_a_b.theta)
    return Pose2D(-c * T_a_b.x - s * T_a_b.y, s * T_a_b.x - c * T_a_b.y, wrap_angle(-T_a_b.theta))
