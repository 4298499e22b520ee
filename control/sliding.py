"""The follower's second-order sliding-mode law, equations (24)-(27), as a fold over samples.

It needs the relative configuration (l, psi, theta_ik) and the follower's own velocities; no
velocity of the leader. Channel 0 is the distance, channel 1 the bearing.
"""

from dataclasses import dataclass, field

from control.actuation import NOMINAL_GAIN, Actuation, DriveGain, require_finite
from control.errors import ControlError
from control.formation import ShapeReference
from control.geometry import wrap_angle
from control.relative import (
    RelativeRates,
    RelativeState,
    Vector2,
    apply,
    input_matrix,
    inverse_input_matrix,
    leader_matrix,
    own_velocity_terms,
)
from control.twisting import TwistingGains, twisting_law
from control.unicycle import Twist

MIN_DISTANCE = 0.05
"""Distances below this are taken for this in G, which is singular at 0 [m]."""


@dataclass(frozen=True, slots=True)
class SlidingGains:
    """Gains of the sliding variable (24) and of the twisting law; the paper's by default.

    Attributes:
        proportional: diagonal of K_k, > 0 [1/s].
        integral: diagonal of L_k, > 0 [1/s^2].
        twisting: mu, nu and the horizon.
        law: name of the twisting law.

    Raises:
        ControlError: if K or L is not positive or the law is unknown.
    """

    proportional: Vector2 = (2.0, 2.0)
    integral: Vector2 = (1.0, 1.0)
    twisting: TwistingGains = field(default_factory=TwistingGains)
    law: str = "implicit-twisting"

    def __post_init__(self) -> None:
        twisting_law(self.law)
        if not min(*self.proportional, *self.integral) > 0.0:
            raise ControlError(f"K and L must be > 0, got {self.proportional}, {self.integral}")


@dataclass(frozen=True, slots=True)
class FollowerModel:
    """What the law knows of its robot.

    Attributes:
        camera_offset: from the axle forward to the camera point, d > 0 [m].
        actuation: motor lag and limits.

    Raises:
        ControlError: if the camera offset is not positive.
    """

    camera_offset: float = 0.05
    actuation: Actuation = field(default_factory=Actuation)

    def __post_init__(self) -> None:
        if not self.camera_offset > 0.0:
            raise ControlError(f"the camera offset must be > 0 m, got {self.camera_offset} m")


@dataclass(frozen=True, slots=True)
class FollowerSample:
    """One sample: all at the moment the command will take effect.

    Attributes:
        relative: predicted relative state [m, rad, rad].
        own: the follower's predicted velocities [m/s, rad/s].
        reference: wanted distance and bearing with derivatives.
        leader_acceleration: forward and angular, if the leader's commands are known (a leader of
            a cascade is itself a follower); (0, 0) as published [m/s^2, rad/s^2].
        gain: the follower's drive gains.
    """

    relative: RelativeState
    own: Twist
    reference: ShapeReference
    leader_acceleration: Vector2 = (0.0, 0.0)
    gain: DriveGain = NOMINAL_GAIN


@dataclass(frozen=True, slots=True)
class FollowerMemory:
    """What the law carries from sample to sample, one entry per channel.

    Attributes:
        error: e = h^d - h [m, rad].
        integral: d_bar of (25) [m s, rad s].
        double_integral: c_bar of (25) [m s^2, rad s^2].
        sliding: s of (24) [m, rad].
        applied: v that the saturated command really applied [m/s^2, rad/s^2].
        acceleration: forward and angular, that the last command gives [m/s^2, rad/s^2].
        fresh: True until the first step.
    """

    error: Vector2
    integral: Vector2
    double_integral: Vector2
    sliding: Vector2
    applied: Vector2 = (0.0, 0.0)
    acceleration: Vector2 = (0.0, 0.0)
    fresh: bool = True


def begin(
    relative: RelativeState,
    reference: ShapeReference,
    gains: SlidingGains,
    initial_rates: RelativeRates | None = None,
) -> FollowerMemory:
    """Memory with s(0) = 0 and s'(0) = 0, equation (25): no reaching phase.

    Args:
        relative: relative state at the first sample [m, rad, rad].
        reference: wanted shape at the first sample.
        gains: K and L.
        initial_rates: h'(0), from a differentiator; None for robots at rest (Remark 5).

    Returns:
        Memory for the step of this same first sample.
    """
    error = _error(relative, reference)
    rates = (initial_rates.distance, initial_rates.bearing) if initial_rates else (0.0, 0.0)
    error_rate = (reference.distance_rate - rates[0], reference.bearing_rate - rates[1])
    (k1, k2), (l1, l2) = gains.proportional, gains.integral
    d1 = (-error_rate[0] - k1 * error[0]) / l1
    d2 = (-error_rate[1] - k2 * error[1]) / l2
    double = (-error[0] - k1 * d1) / l1, (-error[1] - k2 * d2) / l2
    return FollowerMemory(error, (d1, d2), double, (0.0, 0.0))


def follower_step(
    memory: FollowerMemory,
    sample: FollowerSample,
    dt: float,
    gains: SlidingGains,
    model: FollowerModel,
) -> tuple[FollowerMemory, Twist]:
    """One sample of the law: (24), (25), a twisting law for (31), (27), lag inversion.

    Args:
        memory: from ``begin`` or the step before.
        sample: predicted configuration and velocities, and the reference.
        dt: time since the step before, also how long the command will hold, > 0 [s].
        gains: K, L and the twisting law.
        model: camera offset, motor lag, limits.

    Returns:
        The memory for the next step and the command within the limits [m/s, rad/s].

    Raises:
        ControlError: if a number of the sample is not finite or dt is not positive.
    """
    _require_usable(sample, dt)
    moved = _integrate(memory, _error(sample.relative, sample.reference), dt, gains)
    v = _twist(memory, moved.sliding, dt, gains)
    return _act(moved, v, sample, dt, gains, model)


def _require_usable(sample: FollowerSample, dt: float) -> None:
    r, own, h = sample.relative, sample.own, sample.reference
    require_finite("relative state", r.distance, r.bearing, r.heading)
    require_finite("own velocities", own.v, own.omega)
    require_finite("reference", h.distance, h.bearing, h.distance_rate, h.bearing_rate)
    require_finite(
        "accelerations of the reference", h.distance_acceleration, h.bearing_acceleration
    )
    require_finite("leader's acceleration", *sample.leader_acceleration)
    require_finite("drive gains", sample.gain.v, sample.gain.omega)
    if not 0.0 < dt < float("inf"):
        raise ControlError(f"a step of the follower's law needs dt > 0 s, got {dt} s")


def _error(relative: RelativeState, reference: ShapeReference) -> Vector2:
    """e_1 of (11), the bearing wrapped [m, rad]."""
    return (
        reference.distance - relative.distance,
        wrap_angle(reference.bearing - relative.bearing),
    )


def _integrate(
    memory: FollowerMemory, error: Vector2, dt: float, gains: SlidingGains
) -> FollowerMemory:
    """Integrals (25) by trapezoids and the sliding variable (24)."""
    step = 0.0 if memory.fresh else 0.5 * dt
    (e1, e2), (d1, d2), (c1, c2) = memory.error, memory.integral, memory.double_integral
    d = d1 + step * (e1 + error[0]), d2 + step * (e2 + error[1])
    c = c1 + step * (d1 + d[0]), c2 + step * (d2 + d[1])
    (k1, k2), (l1, l2) = gains.proportional, gains.integral
    s = error[0] + k1 * d[0] + l1 * c[0], error[1] + k2 * d[1] + l2 * c[1]
    return FollowerMemory(error, d, c, s, memory.applied, memory.acceleration, fresh=False)


def _twist(memory: FollowerMemory, s: Vector2, dt: float, gains: SlidingGains) -> Vector2:
    """v of both channels from s, its change, and the rate that s'' = v gives from outputs alone."""
    law, old, applied = twisting_law(gains.law), memory.sliding, memory.applied
    change = (0.0, 0.0) if memory.fresh else (s[0] - old[0], s[1] - old[1])
    rate = change[0] / dt + 0.5 * dt * applied[0], change[1] / dt + 0.5 * dt * applied[1]
    return (
        law(s[0], rate[0], change[0], dt, gains.twisting),
        law(s[1], rate[1], change[1], dt, gains.twisting),
    )


def _act(
    memory: FollowerMemory,
    v: Vector2,
    sample: FollowerSample,
    dt: float,
    gains: SlidingGains,
    model: FollowerModel,
) -> tuple[FollowerMemory, Twist]:
    """Control (27) with own-velocity terms; v as saturation left it goes into the memory."""
    relative, d = _away_from_zero(sample.relative), model.camera_offset
    w1, w2 = _feed_forward(memory.error, relative, sample, gains)
    o1, o2 = own_velocity_terms(sample.own, d)
    u1, u2 = apply(inverse_input_matrix(relative, d), (w1 - v[0], w2 - v[1]))  # (27)
    wanted = u1 + o1, u2 + o2
    command, given = model.actuation.command(sample.own, wanted, dt, sample.gain)
    g1, g2 = apply(input_matrix(relative, d), (given[0] - o1, given[1] - o2))
    m, applied = memory, (w1 - g1, w2 - g2)
    moved = FollowerMemory(
        m.error, m.integral, m.double_integral, m.sliding, applied, given, m.fresh
    )
    return moved, command


def _feed_forward(
    error: Vector2, relative: RelativeState, sample: FollowerSample, gains: SlidingGains
) -> Vector2:
    """L e + h^d'' of (27), less what the leader's known acceleration does to h''."""
    h, l = sample.reference, gains.integral  # noqa: E741 (the paper's L)
    p1, p2 = apply(leader_matrix(relative), sample.leader_acceleration)
    return (
        l[0] * error[0] + h.distance_acceleration - p1,
        l[1] * error[1] + h.bearing_acceleration - p2,
    )


def _away_from_zero(relative: RelativeState) -> RelativeState:
    if relative.distance >= MIN_DISTANCE:
        return relative
    return RelativeState(MIN_DISTANCE, relative.bearing, relative.heading)
