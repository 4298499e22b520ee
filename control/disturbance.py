"""How large P_bar of (28), or the disturbance of the first-order law in (20), can get in Omega.

With V the floor velocity of the camera point along and across the line of sight and w_k the
follower's turn rate, equation (8) without its inputs is F = lead - own:

    V = (v_i cos psi + l', l (psi' + w_i) - v_i sin psi),   w_k = (V_1 sin phi + V_2 cos phi) / d
    lead = (l (psi' + w_i)^2 - v_i w_i sin psi, (-2 l' (psi' + w_i) - v_i w_i cos psi) / l)
    own = w_k (V_2, -V_1 / l)          what the own-velocity terms of the default design cancel

Whatever enters linearly (model errors, pushes, reference's and leader's accelerations) is put at
its worst in closed form; the rest is searched: a grid of ends and angles, then refined.
"""

from dataclasses import dataclass
from math import inf, pi
from typing import TypeAlias

import numpy as np

from control.errors import ControlError
from control.maximum import Measures, maxima
from control.model_errors import gain_error
from control.nominal import ErrorDynamics, FloatArray
from control.relative import Vector2
from control.uncertainty import Motion

Dynamics: TypeAlias = tuple[ErrorDynamics, ErrorDynamics]
"""K and L of distance and bearing."""


@dataclass(frozen=True, slots=True)
class Compensation:
    """What a follower's law takes out of the disturbance; nothing in the law as published (27).

    Attributes:
        own_velocities: the part of F the follower itself causes (``own_velocity_terms``).
        leader_velocities: all of F and K e': the first-order law (14), (18).
        leader_acceleration: what u_i does to h'', if the leader's commands are known.

    Raises:
        ControlError: if the leader's velocities are known and the follower's own are not.
    """

    own_velocities: bool = False
    leader_velocities: bool = False
    leader_acceleration: bool = False

    def __post_init__(self) -> None:
        if self.leader_velocities and not self.own_velocities:
            raise ControlError("F of (14) needs the follower's own velocities too")


AS_PUBLISHED = Compensation()
"""Law (27): relative configuration alone."""

DEFAULT_DESIGN = Compensation(own_velocities=True)
"""Law (27) with own-velocity terms, as in ``control.sliding``."""

FIRST_ORDER = Compensation(own_velocities=True, leader_velocities=True)
"""Law (14), (18)."""


def channel_disturbances(
    motion: Motion, dynamics: Dynamics, compensation: Compensation, resolution: int = 24
) -> Vector2:
    """Greatest |P_bar_j| of (28) in Omega, per channel; the first-order law's in (20).

    (20) prints +K e_2 + L e_1 beside F - h^d''; (15) with (18) gives - for both, used here.

    Args:
        motion: what may happen; its spacing must be > 0 m.
        dynamics: K and L of distance and bearing.
        compensation: what the law takes out.
        resolution: angles of the grid around a full circle, >= 4.

    Returns:
        Of distance and of bearing, each at its own worst, found, not proved [m/s^2, rad/s^2].

    Raises:
        ControlError: if the distance may reach 0 or the grid is too coarse.
    """

    def measures(points: FloatArray) -> FloatArray:
        return worst_disturbance(points, motion, dynamics, compensation)

    first, second = _maxima(measures, motion, resolution)
    return first, second


def disturbance_norm(
    motion: Motion,
    dynamics: Dynamics,
    compensation: Compensation,
    scale: float,
    resolution: int = 24,
) -> float:
    """rho_bar of (30) in Omega, or rho of (20), as a norm, the bearing scaled to metres.

    Both channels are taken at the worst model errors and accelerations of each, so that it may be
    a little more than the norm of any one P_bar.

    Args:
        motion: what may happen; its spacing must be > 0 m.
        dynamics: K and L of distance and bearing.
        compensation: what the law takes out.
        scale: metres that count as a radian; 1 is the paper's, units ignored [m].
        resolution: angles of the grid around a full circle, >= 4.

    Returns:
        The maximum found, not proved [m/s^2].

    Raises:
        ControlError: if the distance may reach 0, the scale is not positive or the grid too coarse.
    """
    if not 0.0 < scale < inf:
        raise ControlError(f"the scale of the bearing must be > 0 m, got {scale} m")

    def measures(points: FloatArray) -> FloatArray:
        first, second = worst_disturbance(points, motion, dynamics, compensation)
        norm: FloatArray = np.hypot(first, scale * second)[None]
        return norm

    return _maxima(measures, motion, resolution)[0]


def worst_disturbance(
    points: FloatArray, motion: Motion, dynamics: Dynamics, compensation: Compensation
) -> FloatArray:
    """Greatest |P_bar_j| of (28) at given points of Omega, over all that enters linearly.

    Args:
        points: (11, N) of l^d, e_l, psi^d, e_psi, l^d', e_l', psi^d', e_psi', v_i, w_i, phi; l > 0.
        motion: bounds of accelerations, model errors, pushes.
        dynamics: K and L of distance and bearing.
        compensation: what the law takes out.

    Returns:
        (2, N) of distance and of bearing [m/s^2, rad/s^2].
    """
    known, fed = _parts(points, motion.follower.camera_offset, dynamics, compensation)
    # only the sign of eps eps' matters: that of both is free
    errors = [_through_errors(points, fed, motion, compensation, sign) for sign in (1.0, -1.0)]
    worst: FloatArray = np.abs(known) + _outside(points, motion, compensation) + np.max(errors, 0)
    return worst


def _parts(
    points: FloatArray, d: float, dynamics: Dynamics, compensation: Compensation
) -> tuple[FloatArray, FloatArray]:
    """P_bar without model errors, and what these multiply, but for h^d''; (2, N) each."""
    lead, own = _drift(points, d)
    damping = np.array([[channel.proportional] for channel in dynamics]) * points[[5, 7]]  # K e'
    pull = np.array([[channel.integral] for channel in dynamics]) * points[[1, 3]]  # L e
    if compensation.leader_velocities:
        return np.zeros_like(lead), pull + damping - (lead - own)  # (20)
    if compensation.own_velocities:
        return lead - damping, pull + own
    return lead - own - damping, pull  # (28)


def _drift(points: FloatArray, d: float) -> tuple[FloatArray, FloatArray]:
    """The leader's and the follower's part of F, (2, N) each: F = lead - own."""
    l, psi = points[0] - points[1], points[2] - points[3]  # noqa: E741 (the paper's l)
    l_rate, zeta_rate = points[4] - points[5], points[6] - points[7] + points[9]
    v, w, phi = points[8:]
    along, across = v * np.cos(psi) + l_rate, l * zeta_rate - v * np.sin(psi)
    turn = (along * np.sin(phi) + across * np.cos(phi)) / d
    lead = (
        l * zeta_rate**2 - v * w * np.sin(psi),
        -(2.0 * l_rate * zeta_rate + v * w * np.cos(psi)) / l,
    )
    return np.stack(lead), np.stack([turn * across, -turn * along / l])


def _outside(points: FloatArray, motion: Motion, compensation: Compensation) -> FloatArray:
    """Greatest part of pushes and of an unknown leader's acceleration, (2, N)."""
    l, psi, phi = points[0] - points[1], points[2] - points[3], points[10]  # noqa: E741
    follower, leader = motion.follower, motion.leader
    lever = follower.camera_offset * follower.twist
    pushes = np.stack([np.abs(np.sin(phi)) * lever, np.abs(np.cos(phi)) * lever]) + follower.push
    if not compensation.leader_acceleration:
        pushes += leader.acceleration * np.abs(np.stack([np.cos(psi), np.sin(psi)]))
        pushes[1] += l * leader.angular_acceleration
    pushes[1] /= l
    return pushes


def _through_errors(
    points: FloatArray, fed: FloatArray, motion: Motion, compensation: Compensation, sign: float
) -> FloatArray:
    """Greatest part of the greatest model errors, the inertia's with a sign, (2, N)."""
    l, psi = points[0] - points[1], points[2] - points[3]  # noqa: E741 (the paper's l)
    follower, leader, reference = motion.follower, motion.leader, motion.reference
    m = np.array(gain_error(l, points[10], follower.mass_error, sign * follower.inertia_error))
    of_l, of_psi = m[:, 0], m[:, 1]  # columns, (2, N)
    part: FloatArray = np.abs(of_l * fed[0] + of_psi * fed[1])
    part += np.abs(of_l) * reference.distance_acceleration
    part += np.abs(of_psi) * reference.bearing_acceleration
    if compensation.leader_acceleration:
        forward = of_psi * np.sin(psi) / l - of_l * np.cos(psi)
        part += np.abs(forward) * leader.acceleration
        part += np.abs(of_psi) * leader.angular_acceleration
    return part


def _box(motion: Motion) -> FloatArray:
    """(11, 2) ranges of what ``worst_disturbance`` takes."""
    h, lead, (first, second) = motion.reference, motion.leader, motion.errors
    return np.array([
        h.distance,
        (first.low, first.high),
        h.bearing,
        (second.low, second.high),
        (-h.distance_rate, h.distance_rate),
        (first.rate_low, first.rate_high),
        (-h.bearing_rate, h.bearing_rate),
        (second.rate_low, second.rate_high),
        (-lead.speed, lead.speed),
        (-lead.turn_rate, lead.turn_rate),
        motion.heading,
    ])  # fmt: skip


def _maxima(measures: Measures, motion: Motion, resolution: int) -> list[float]:
    """Greatest value of each measure in Omega."""
    near = motion.spacing[0]
    if not near > 0.0:
        raise ControlError(
            f"the distance may reach {near:g} m, where P_bar has no bound: "
            "start nearer to the shape, or want a wider one"
        )
    if resolution < 4:
        raise ControlError(f"the grid needs at least 4 angles around a circle, got {resolution}")
    box = _box(motion)
    levels = np.array([2, 2, 2, 3, 2, 2, 2, 3, 3, 3, 2])
    angles = [2, 10]  # psi^d and phi
    turns = (box[angles, 1] - box[angles, 0]) / (2.0 * pi)
    levels[angles] = np.maximum(5, np.ceil(turns * resolution) + 1)
    return maxima(measures, box, levels)
