"""Planar poses and angles. Transforms name their frames: ``T_floor_robot`` maps robot to floor."""

from dataclasses import dataclass
from math import cos, pi, sin

from control.compilable import compilable
from control.value import value


@compilable
def wrap_angle(angle: float) -> float:
    """Wrap an angle [rad] to (-pi, pi].

    Args:
        angle: any finite angle [rad].

    Returns:
        The equal angle in (-pi, pi] [rad].
    """
    return angle if -pi < angle <= pi else pi - (pi - angle) % (2.0 * pi)


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
