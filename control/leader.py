"""The formation's leader: the first-order law with which it tracks its plan, or another by name."""

from dataclasses import dataclass
from math import cos, sin

from control.actuation import NOMINAL_GAIN, Actuation, DriveGain, require_finite
from control.compilable import compilable
from control.errors import ControlError
from control.laws import LeaderLaw
from control.plan import PlannedMotion
from control.relative import Vector2
from control.tracking import linearising_input, saturated_input
from control.unicycle import Twist, UnicycleState
from control.value import value

LOST_RATE = 1.0
"""A leader this far from s = 0 was held, and begins afresh, so that nothing winds up [m/s]."""


@value
@dataclass(frozen=True, slots=True)
class LeaderGains:
    """Law and gains of the leader, both floor axes alike.

    Attributes:
        proportional: K of (16), > 0 [1/s].
        integral: L of (16), > 0 [1/s^2].
        reaching: lambda of (19), the disturbance it can reject, > 0 [m/s^2].
        horizon: in which s is brought to 0, or the other laws' velocities are reached; at least
            the period is used [s].
        point_offset: from the axle forward to the point that is tracked, d > 0 [m].
        law: SLIDING; the others take K, L and the horizon alone (`control.tracking`).

    Raises:
        ControlError: if a gain is not positive.
    """

    proportional: float = 8.0
    integral: float = 16.0
    reaching: float = 3.0
    horizon: float = 0.1
    point_offset: float = 0.1
    law: LeaderLaw = LeaderLaw.SLIDING

    def __post_init__(self) -> None:
        gains = (self.proportional, self.integral, self.reaching, self.horizon, self.point_offset)
        if not min(gains) > 0.0:
            raise ControlError(f"the leader's gains must be > 0, got {self}")


@value
@dataclass(frozen=True, slots=True)
class LeaderMemory:
    """What the leader's law carries from sample to sample, in floor axes.

    Attributes:
        error: e_1 = c^d - c of the point ahead [m, m].
        integral: d of (17) [m s, m s].
        sliding: s of (16) [m/s, m/s].
        acceleration: forward and angular, that the last command gives [m/s^2, rad/s^2].
        fresh: True until the first step.
    """

    error: Vector2
    integral: Vector2
    sliding: Vector2 = (0.0, 0.0)
    acceleration: Vector2 = (0.0, 0.0)
    fresh: bool = True


@value
@dataclass(frozen=True, slots=True)
class _PointAhead:
    """Motion of the point c = p + d e(theta) on the floor."""

    position: Vector2
    velocity: Vector2
    acceleration: Vector2


@compilable
def begin_leader(state: UnicycleState, planned: PlannedMotion, gains: LeaderGains) -> LeaderMemory:
    """Memory with s(0) = 0, equation (17): no reaching phase.

    Args:
        state: predicted state at the first sample.
        planned: wanted motion at the first sample.
        gains: K, L and the point's offset.

    Returns:
        Memory for the step of this same first sample.
    """
    (e1, e2), (r1, r2) = _errors(state, planned, gains.point_offset)
    k, l = gains.proportional, gains.integral  # noqa: E741 (the paper's L)
    integral = (-r1 - k * e1) / l, (-r2 - k * e2) / l
    return LeaderMemory((e1, e2), integral, (0.0, 0.0), (0.0, 0.0), True)


def leader_step(
    memory: LeaderMemory,
    state: UnicycleState,
    planned: PlannedMotion,
    dt: float,
    gains: LeaderGains,
    actuation: Actuation,
    gain: DriveGain = NOMINAL_GAIN,
) -> tuple[LeaderMemory, Twist]:
    """One sample of the law, refused if a number is no number.

    Args:
        memory: from ``begin_leader`` or the step before.
        state: predicted state when the command takes effect.
        planned: wanted motion at that moment.
        dt: time since the step before, also how long the command will hold, > 0 [s].
        gains: K, L, lambda.
        actuation: motor lag and limits.
        gain: the robot's drive gains.

    Returns:
        The memory for the next step and the command within the limits [m/s, rad/s].

    Raises:
        ControlError: if a number is not finite or dt is not positive.
    """
    _require_usable(state, planned, dt)
    return lead(memory, state, planned, dt, gains, actuation, gain)


@compilable
def lead(
    memory: LeaderMemory,
    state: UnicycleState,
    planned: PlannedMotion,
    dt: float,
    gains: LeaderGains,
    actuation: Actuation,
    gain: DriveGain,
) -> tuple[LeaderMemory, Twist]:
    """One sample for finite numbers: of the first-order law (14), (16)-(19) on the point ahead.

    The output is the point c = p + d e(theta) against the planned c^d; there l and psi of a
    follower have no counterpart, but G and F do: c'' = G u + F with G = R(theta) diag(1, d).
    (19) is solved for the end of the horizon, which takes the chatter out of Sign. Or of another
    law, by the gains.

    Args:
        memory: from ``begin_leader`` or the step before.
        state: predicted state when the command takes effect.
        planned: wanted motion at that moment.
        dt: time since the step before, also how long the command will hold, > 0 [s].
        gains: law, K, L, lambda.
        actuation: motor lag and limits.
        gain: the robot's drive gains.

    Returns:
        The memory for the next step and the command within the limits [m/s, rad/s].
    """
    error, rate = _errors(state, planned, gains.point_offset)
    integral = _integral(memory, error, dt)
    k, l = gains.proportional, gains.integral  # noqa: E741 (the paper's L)
    s = rate[0] + k * error[0] + l * integral[0], rate[1] + k * error[1] + l * integral[1]  # (16)
    if max(abs(s[0]), abs(s[1])) > LOST_RATE:
        integral, s = begin_leader(state, planned, gains).integral, (0.0, 0.0)
    horizon = max(gains.horizon, dt)
    if gains.law == LeaderLaw.SATURATED:
        u = saturated_input(state, planned, k, horizon)
    elif gains.law == LeaderLaw.LINEARISING:
        u = linearising_input(state, planned, k, l, horizon)
    else:
        v = _control(s, rate, error, horizon, gains)
        u = _point_input(state, planned, v, gains.point_offset)
    command, given = actuation.command(state.twist, u, dt, gain)
    return LeaderMemory(error, integral, s, given, False), command


@compilable
def _control(
    s: Vector2, rate: Vector2, error: Vector2, horizon: float, gains: LeaderGains
) -> Vector2:
    """v of (18) with (19) solved for the end of the horizon [m/s^2]."""
    k, l, most = gains.proportional, gains.integral, gains.reaching  # noqa: E741 (the paper's L)
    r1, r2 = s[0] / horizon, s[1] / horizon
    return (
        -k * rate[0] - l * error[0] - max(-most, min(most, r1)),
        -k * rate[1] - l * error[1] - max(-most, min(most, r2)),
    )


def _require_usable(state: UnicycleState, planned: PlannedMotion, dt: float) -> None:
    p = planned.state
    require_finite("leader's state", state.x, state.y, state.theta, state.v, state.omega)
    require_finite("plan", p.x, p.y, p.theta, p.v, p.omega, planned.v_rate, planned.omega_rate)
    if not 0.0 < dt < float("inf"):
        raise ControlError(f"a step of the leader's law needs dt > 0 s, got {dt} s")


@compilable
def _point(state: UnicycleState, v_rate: float, omega_rate: float, d: float) -> _PointAhead:
    c, s = cos(state.theta), sin(state.theta)
    v, w = state.v, state.omega
    a1, a2 = v_rate - d * w * w, v * w + d * omega_rate  # forward and to the left
    return _PointAhead(
        (state.x + d * c, state.y + d * s),
        (v * c - d * w * s, v * s + d * w * c),
        (a1 * c - a2 * s, a1 * s + a2 * c),
    )


@compilable
def _errors(state: UnicycleState, planned: PlannedMotion, d: float) -> tuple[Vector2, Vector2]:
    """e_1 and e_2 of (11) for the point ahead [m, m/s]."""
    actual, wanted = _point(state, 0.0, 0.0, d), _point(planned.state, 0.0, 0.0, d)
    (x, y), (vx, vy) = actual.position, actual.velocity
    return (
        (wanted.position[0] - x, wanted.position[1] - y),
        (wanted.velocity[0] - vx, wanted.velocity[1] - vy),
    )


@compilable
def _integral(memory: LeaderMemory, error: Vector2, dt: float) -> Vector2:
    """d of (17), by trapezoids [m s]."""
    step = 0.0 if memory.fresh else 0.5 * dt
    (e1, e2), (d1, d2) = memory.error, memory.integral
    return d1 + step * (e1 + error[0]), d2 + step * (e2 + error[1])


@compilable
def _point_input(state: UnicycleState, planned: PlannedMotion, v: Vector2, d: float) -> Vector2:
    """u of (14): the accelerations that give the point ahead those of its plan less v."""
    wanted = _point(planned.state, planned.v_rate, planned.omega_rate, d).acceleration
    ax, ay = wanted[0] - v[0], wanted[1] - v[1]
    c, s = cos(state.theta), sin(state.theta)
    forward, left = ax * c + ay * s, ay * c - ax * s
    return forward + d * state.omega**2, (left - state.v * state.omega) / d
