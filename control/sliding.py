"""The follower's law as a fold over samples: sliding variable, control, command.

A second-order law (24)-(27) needs the relative configuration and the follower's own velocities, a
first-order one (14), (16)-(20) also the leader's. Which one is a name in the gains.
"""

from math import inf

from control.actuation import require_finite
from control.channel import ChannelMemory, begin_channel, sample_channel
from control.compilable import compilable
from control.errors import ControlError
from control.follower import FollowerMemory, FollowerModel, FollowerSample, SlidingGains
from control.laws import Law, is_first_order, remembers
from control.output import FollowerOutput, WantedOutput, output_error
from control.reaching import reach, reaching_strength, super_twist
from control.relative import Vector2, apply
from control.twisting import twist
from control.unicycle import Twist

LOST = 0.1
"""A second-order law this far from s = 0 begins afresh: integrals of what nobody could help would
be paid back by as large an error of the other sign [m]; bearings count times l. Sampled twisting
is left as published."""

LOST_RATE = 0.4
"""The same of the first-order laws, whose s jumps with the leader's velocities [m/s]."""

LOST_ACCELERATION = 5.0
"""... and by what acceleration does in a period that no law saw coming [m/s^2]."""


@compilable
def begin(
    output: FollowerOutput, wanted: WantedOutput, rate: Vector2, gains: SlidingGains
) -> FollowerMemory:
    """Memory with s(0) = 0, and s'(0) = 0 for the second-order laws: no reaching phase (17), (25).

    Args:
        output: at the first sample.
        wanted: at the first sample.
        rate: h'(0): 0 for robots at rest, else from a differentiator (Remark 5); the first-order
            laws start from `output.rate` instead.
        gains: K and L.

    Returns:
        Memory for the step of this same first sample.
    """
    e1, e2 = output_error(output, wanted)
    r1, r2 = output.rate if is_first_order(gains.law) else rate
    return FollowerMemory(
        begin_channel(e1, wanted.rate[0] - r1, gains.distance),
        begin_channel(e2, wanted.rate[1] - r2, gains.bearing),
        (0.0, 0.0),
        True,
    )


def follower_step(
    memory: FollowerMemory,
    sample: FollowerSample,
    dt: float,
    gains: SlidingGains,
    model: FollowerModel,
) -> tuple[FollowerMemory, Twist]:
    """One sample of the law, refused if a number is no number.

    Args:
        memory: from ``begin`` or the step before.
        sample: predicted output and velocities, and the wanted output.
        dt: time since the step before, also how long the command will hold, > 0 [s].
        gains: law and gains.
        model: camera offset, motor lag, limits.

    Returns:
        The memory for the next step and the command within the limits [m/s, rad/s].

    Raises:
        ControlError: if a number of the sample is not finite or dt is not positive.
    """
    o, w = sample.output, sample.wanted
    require_finite("relative configuration", *o.h, *o.input_matrix[0], *o.input_matrix[1])
    require_finite("velocities", *o.rate, *o.drift, sample.own.v, sample.own.omega)
    require_finite("reference", *w.h, *w.rate, *w.acceleration)
    require_finite("leader's acceleration", *o.push)
    require_finite("drive gains", sample.gain.v, sample.gain.omega)
    if not 0.0 < dt < inf:
        raise ControlError(f"a step of the follower's law needs dt > 0 s, got {dt} s")
    return follow(memory, sample, dt, gains, model)


@compilable
def follow(
    memory: FollowerMemory,
    sample: FollowerSample,
    dt: float,
    gains: SlidingGains,
    model: FollowerModel,
) -> tuple[FollowerMemory, Twist]:
    """One sample of the law for finite numbers: (14) or (27), then the motors' lag inverted.

    Args:
        memory: from ``begin`` or the step before.
        sample: predicted output and velocities, and the wanted output.
        dt: time since the step before, also how long the command will hold, > 0 [s].
        gains: law and gains.
        model: camera offset, motor lag, limits.

    Returns:
        The memory for the next step and the command within the limits [m/s, rad/s].
    """
    o, wanted = sample.output, sample.wanted
    e = output_error(o, wanted)
    r = wanted.rate[0] - o.rate[0], wanted.rate[1] - o.rate[1]
    one, two = _sampled(memory, e, r, o.size, dt, gains)
    w = _feed_forward(o, wanted, e, gains)
    if is_first_order(gains.law):
        (v1, own1), (v2, own2) = _first_order(one, two, o, w, e, r, dt, gains)
    else:
        v1, own1 = twist(one, dt, gains.twisting, gains.law)
        v2, own2 = twist(two, dt, gains.twisting, gains.law)
    u1, u2 = apply(o.inverse, (w[0] - v1, w[1] - v2))  # (14), (27)
    wanted_u = u1 + o.own[0], u2 + o.own[1]
    command, given = model.actuation.command(sample.own, wanted_u, dt, sample.gain)
    g1, g2 = apply(o.input_matrix, (given[0] - o.own[0], given[1] - o.own[1]))
    one, two = _applied(one, w[0] - g1, own1), _applied(two, w[1] - g2, own2)
    return FollowerMemory(one, two, given, False), command


@compilable
def overruled(
    memory: FollowerMemory, sample: FollowerSample, acceleration: Vector2, gains: SlidingGains
) -> FollowerMemory:
    """The memory of a law whose command was replaced by another one.

    Args:
        memory: after the step.
        sample: of the step, with the velocities of the leaders.
        acceleration: what the other command gives [m/s^2, rad/s^2].
        gains: of the step.

    Returns:
        The memory with the v that is really applied (27), so that nothing winds up; laws whose own
        memory knows nothing of v begin afresh, with s = 0.
    """
    o, (a, b) = sample.output, memory.acceleration
    if remembers(gains.law):
        m = begin(o, sample.wanted, o.rate, gains)
        return FollowerMemory(m.distance, m.bearing, acceleration, True)
    g1, g2 = apply(o.input_matrix, (acceleration[0] - a, acceleration[1] - b))
    one, two = memory.distance, memory.bearing
    return FollowerMemory(
        _applied(one, one.applied - g1, one.own),
        _applied(two, two.applied - g2, two.own),
        acceleration,
        False,
    )


@compilable
def _sampled(
    memory: FollowerMemory,
    error: Vector2,
    rate: Vector2,
    size: float,
    dt: float,
    gains: SlidingGains,
) -> tuple[ChannelMemory, ChannelMemory]:
    """Both channels with s of now; from s = 0 again if the motors could not keep it near there."""
    first_order, step = is_first_order(gains.law), 0.0 if memory.fresh else dt
    one = sample_channel(memory.distance, error[0], rate[0], step, gains.distance, first_order)
    two = sample_channel(memory.bearing, error[1], rate[1], step, gains.bearing, first_order)
    away = max(abs(one.sliding), size * abs(two.sliding))
    most = LOST_RATE + LOST_ACCELERATION * dt if first_order else LOST
    if away > most and gains.law != Law.SAMPLED_TWISTING:
        one = begin_channel(error[0], rate[0], gains.distance)
        two = begin_channel(error[1], rate[1], gains.bearing)
    return one, two


@compilable
def _feed_forward(
    output: FollowerOutput, wanted: WantedOutput, error: Vector2, gains: SlidingGains
) -> Vector2:
    """What G u shall be but for v: h^d'' less the leaders' parts; L e of (27) or F_i of (14)."""
    a, p = wanted.acceleration, output.push
    if is_first_order(gains.law):
        return a[0] - p[0] - output.drift[0], a[1] - p[1] - output.drift[1]
    l1, l2 = gains.distance.integral, gains.bearing.integral
    return a[0] - p[0] + l1 * error[0], a[1] - p[1] + l2 * error[1]


@compilable
def _first_order(
    one: ChannelMemory,
    two: ChannelMemory,
    output: FollowerOutput,
    feed: Vector2,
    error: Vector2,
    rate: Vector2,
    dt: float,
    gains: SlidingGains,
) -> tuple[Vector2, Vector2]:
    """v of (18) and what the law remembers, of both channels."""
    k1, k2 = gains.distance, gains.bearing
    f1 = -k1.proportional * rate[0] - k1.integral * error[0]
    f2 = -k2.proportional * rate[1] - k2.integral * error[1]
    strength = reaching_strength((feed[0] - f1, feed[1] - f2), output, gains.reaching)
    d1, own1 = _reach(one, strength, 1.0, dt, gains)
    d2, own2 = _reach(two, strength, output.size, dt, gains)
    return (f1 + d1, own1), (f2 + d2, own2)


@compilable
def _reach(
    channel: ChannelMemory, strength: float, size: float, dt: float, gains: SlidingGains
) -> Vector2:
    """Delta v of a channel, and what the law remembers."""
    r, horizon = gains.reaching, gains.twisting.horizon
    if gains.law == Law.SUPER_TWISTING:
        return super_twist(channel.sliding, channel.own, r.lipschitz / size, max(horizon, dt))
    v = reach(channel.sliding, strength / size, dt, horizon, r.layer / size, gains.law)
    return v, 0.0


@compilable
def _applied(channel: ChannelMemory, v: float, own: float) -> ChannelMemory:
    """The memory with v as saturation left it, and what the law remembers."""
    m = channel
    return ChannelMemory(
        m.error, m.integral, m.double_integral, m.sliding, m.before, m.before_that, v, m.applied,
        own,
    )  # fmt: skip
