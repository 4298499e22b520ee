"""A follower's camera point seen from its leader: equations (6)-(8), with 1/l on row two only.

With phi = psi + theta_ik, d the camera offset, (v_i, w_i) the leader's and (v_k, w_k) the
follower's velocities, and u_i, u_k their accelerations:

    h'  = G [v_k, w_k] + E [v_i, w_i]
    h'' = G u_k + E u_i + F,      E = [[-cos psi, 0], [sin psi / l, -1]]

Bearing as in (7): psi = pi is straight behind the leader, 0 straight ahead, pi/2 on its left.
"""

from dataclasses import dataclass
from math import atan2, cos, pi, sin, sqrt
from typing import TypeAlias

from control.compilable import compilable
from control.geometry import Pose2D, wrap_angle
from control.unicycle import Twist
from control.value import value

Vector2: TypeAlias = tuple[float, float]
Matrix2: TypeAlias = tuple[Vector2, Vector2]


@value
@dataclass(frozen=True, slots=True)
class RelativeState:
    """Relative configuration of a follower, equations (6) and (7).

    Attributes:
        distance: from the follower's camera point to the leader, l_ik [m].
        bearing: of the camera point about the leader, psi_ik in (-pi, pi] [rad].
        heading: leader's heading minus follower's, theta_ik in (-pi, pi] [rad].
    """

    distance: float
    bearing: float
    heading: float


@value
@dataclass(frozen=True, slots=True)
class RelativeRates:
    """Time derivatives of a relative state.

    Attributes:
        distance: l_ik' [m/s].
        bearing: psi_ik' [rad/s].
        heading: theta_ik' [rad/s].
    """

    distance: float
    bearing: float
    heading: float


@compilable
def relative_state(leader: Pose2D, follower: Pose2D, camera_offset: float) -> RelativeState:
    """Relative configuration of two robots, equations (6) and (7).

    Args:
        leader: pose of robot i [m, m, rad].
        follower: pose of robot k [m, m, rad].
        camera_offset: from the follower's axle forward to its camera point, d [m].

    Returns:
        Distance, bearing and relative heading; angles wrapped [m, rad, rad].
    """
    rx = leader.x - follower.x - camera_offset * cos(follower.theta)
    ry = leader.y - follower.y - camera_offset * sin(follower.theta)
    return RelativeState(
        sqrt(rx * rx + ry * ry),  # (6)
        wrap_angle(pi + atan2(ry, rx) - leader.theta),  # (7)
        wrap_angle(leader.theta - follower.theta),
    )


@compilable
def input_matrix(relative: RelativeState, camera_offset: float) -> Matrix2:
    """G of (8): what the follower's velocities do to h', its accelerations to h''.

    Args:
        relative: relative state; its distance must be > 0 [m, rad, rad].
        camera_offset: d [m].

    Returns:
        Rows [1, m] and [1/m, 1]; its determinant is d / l.
    """
    l, d = relative.distance, camera_offset  # noqa: E741 (the paper's l)
    phi = relative.bearing + relative.heading
    c, s = cos(phi), sin(phi)
    return (c, d * s), (-s / l, d * c / l)


@compilable
def inverse_input_matrix(relative: RelativeState, camera_offset: float) -> Matrix2:
    """Inverse of G, in closed form.

    Args:
        relative: relative state; any distance [m, rad, rad].
        camera_offset: d, not 0 [m].

    Returns:
        Rows [1, m] and [1/m, 1].
    """
    l, d = relative.distance, camera_offset  # noqa: E741 (the paper's l)
    phi = relative.bearing + relative.heading
    c, s = cos(phi), sin(phi)
    return (c, -l * s), (s / d, l * c / d)


@compilable
def leader_matrix(relative: RelativeState) -> Matrix2:
    """E: what the leader's velocities do to h', and its accelerations to h'' (a part of P in (8)).

    Args:
        relative: relative state; its distance must be > 0 [m, rad, rad].

    Returns:
        Rows [1, m] and [1/m, 1].
    """
    psi = relative.bearing
    return (-cos(psi), 0.0), (sin(psi) / relative.distance, -1.0)


@compilable
def relative_rates(
    relative: RelativeState, leader: Twist, follower: Twist, camera_offset: float
) -> RelativeRates:
    """Derivative of the relative state from both robots' velocities.

    Args:
        relative: relative state; its distance must be > 0 [m, rad, rad].
        leader: velocities of robot i [m/s, rad/s].
        follower: velocities of robot k [m/s, rad/s].
        camera_offset: d [m].

    Returns:
        Rates of distance, bearing and relative heading [m/s, rad/s, rad/s].
    """
    own = apply(input_matrix(relative, camera_offset), (follower.v, follower.omega))
    lead = apply(leader_matrix(relative), (leader.v, leader.omega))
    return RelativeRates(own[0] + lead[0], own[1] + lead[1], leader.omega - follower.omega)


@compilable
def drift(relative: RelativeState, leader: Twist, follower: Twist, camera_offset: float) -> Vector2:
    """F of (8): h'' of two robots that do not accelerate.

    Args:
        relative: relative state; its distance must be > 0 [m, rad, rad].
        leader: velocities of robot i [m/s, rad/s].
        follower: velocities of robot k [m/s, rad/s].
        camera_offset: d [m].

    Returns:
        Second derivatives of distance and bearing [m/s^2, rad/s^2].
    """
    l, psi = relative.distance, relative.bearing  # noqa: E741 (the paper's l)
    rates = relative_rates(relative, leader, follower, camera_offset)
    zeta_rate = rates.bearing + leader.omega  # of the line of sight, on the floor
    swing = leader.v * leader.omega
    own = apply(input_matrix(relative, camera_offset), own_velocity_terms(follower, camera_offset))
    return (
        l * zeta_rate**2 - swing * sin(psi) - own[0],
        (-2.0 * rates.distance * zeta_rate - swing * cos(psi)) / l - own[1],
    )


@compilable
def own_velocity_terms(follower: Twist, camera_offset: float) -> Vector2:
    """Accelerations that cancel exactly the part of F the follower itself causes.

    Added to u they take [d w^2, -v w / d] out of F: the turning of the camera point about the
    axle. Only the follower's own velocities enter; the leader's stay unknown.

    Args:
        follower: velocities of robot k [m/s, rad/s].
        camera_offset: d, not 0 [m].

    Returns:
        Forward and angular acceleration [m/s^2, rad/s^2].
    """
    v, omega = follower.v, follower.omega
    return camera_offset * omega * omega, -v * omega / camera_offset


@compilable
def apply(matrix: Matrix2, vector: Vector2) -> Vector2:
    """Product of a 2x2 matrix and a vector, in plain floats (these run at command rate).

    Args:
        matrix: two rows.
        vector: two entries.

    Returns:
        Two entries.
    """
    (a, b), (c, d) = matrix
    x, y = vector
    return a * x + b * y, c * x + d * y
