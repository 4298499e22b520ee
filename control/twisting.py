"""Second-order sliding-mode laws of one channel: they know s of (24) and nothing of its rate.

They act on s'' = v + p with |p| <= rho, equation (28), and bring s and s' to zero. Plain floats:
two channels of every follower call this at command rate.
"""

from dataclasses import dataclass

from control.channel import ChannelMemory
from control.compilable import compilable
from control.errors import ControlError
from control.laws import Law
from control.value import value


@value
@dataclass(frozen=True, slots=True)
class TwistingGains:
    """Gains of a twisting law, for s'' in units per second squared.

    Attributes:
        mu: control while |s| grows [1/s^2 times the unit of s].
        nu: control while |s| shrinks, 0 < nu < mu [the same].
        horizon: over which the implicit laws plan to stop, at least the period is used [s].

    Raises:
        ControlError: unless 0 < nu < mu and horizon > 0.
    """

    mu: float = 20.0
    nu: float = 4.0
    horizon: float = 0.05

    def __post_init__(self) -> None:
        if not (0.0 < self.nu < self.mu and self.horizon > 0.0):
            raise ControlError(
                f"twisting needs 0 < nu < mu and horizon > 0 s, got nu {self.nu}, mu {self.mu}, "
                f"horizon {self.horizon} s"
            )


@compilable
def twist(memory: ChannelMemory, dt: float, gains: TwistingGains, law: Law) -> tuple[float, float]:
    """Control of one channel by one of the second-order laws.

    Args:
        memory: with s of this sample.
        dt: period [s].
        gains: gains of the law.
        law: one of the four.

    Returns:
        v of (27) [unit/s^2], and what the law remembers (`ChannelMemory.own`).
    """
    if law == Law.SAMPLED_TWISTING:
        return sampled_twisting(memory.sliding, memory.change, gains), 0.0
    if law == Law.SUBOPTIMAL:
        extremum = last_extremum(memory)
        return suboptimal(memory.sliding, extremum, gains), extremum
    rate = memory.change / dt + 0.5 * dt * memory.applied  # at the sample, from s'' = v
    if law == Law.COMPENSATED_TWISTING:
        p = disturbance(memory, dt, gains)
        return implicit_twisting(memory.sliding, rate + 0.5 * dt * p, p, dt, gains), p
    return implicit_twisting(memory.sliding, rate, 0.0, dt, gains), 0.0


@compilable
def implicit_twisting(s: float, rate: float, p: float, dt: float, gains: TwistingGains) -> float:
    """Twisting solved for the end of the horizon T instead of its start: no chatter.

    The unique v in -a Sgn(s + 1.5 T s' + T^2 (v + p)) - b Sgn(s' + T (v + p)) with
    a = (mu + nu)/2 and b = (mu - nu)/2. T equal to the period is the exact implicit discretisation.

    Args:
        s: sliding variable [unit].
        rate: s' [unit/s].
        p: known part of the disturbance [unit/s^2].
        dt: period [s].
        gains: gains of the law.

    Returns:
        v of (27), |v| <= mu [unit/s^2].
    """
    horizon = max(gains.horizon, dt)
    a, b = 0.5 * (gains.mu + gains.nu), 0.5 * (gains.mu - gains.nu)
    # v at which the first, and the second, sign changes
    p1 = -(s + 1.5 * horizon * rate) / (horizon * horizon) - p
    p2 = -rate / horizon - p
    low, high, between = (p1, p2, b - a) if p1 <= p2 else (p2, p1, a - b)
    # the middle one of low, high, between, mu, -mu
    return max(-gains.mu, min(gains.mu, max(low, min(high, between))))


@compilable
def disturbance(memory: ChannelMemory, dt: float, gains: TwistingGains) -> float:
    """Disturbance of s'' = v + p, from three samples of s and the v between them.

    Args:
        memory: with s of this sample.
        dt: period [s].
        gains: |p| <= nu; periods shorter than the horizon smooth the estimate over it.

    Returns:
        p [unit/s^2].
    """
    m = memory
    bend = (m.sliding - 2.0 * m.before + m.before_that) / (dt * dt)
    latest = bend - 0.5 * (m.applied + m.applied_before)
    smooth = m.own + min(1.0, dt / gains.horizon) * (latest - m.own)
    return max(-gains.nu, min(gains.nu, smooth))


@compilable
def sampled_twisting(s: float, change: float, gains: TwistingGains) -> float:
    """The sampled twisting algorithm exactly as published, equation (31).

    Stable only for short periods: about 5 ms with the paper's gains and a 5 cm camera offset.

    Args:
        s: sliding variable [unit].
        change: Delta of (31), 0 at the first sample [unit].
        gains: mu and nu.

    Returns:
        v of (27): -mu sign(s), -nu sign(s), or 0 for s = 0 [unit/s^2].
    """
    gain = gains.mu if s * change > 0.0 else gains.nu
    return -gain if s > 0.0 else gain if s < 0.0 else 0.0


@compilable
def suboptimal(s: float, extremum: float, gains: TwistingGains) -> float:
    """The suboptimal algorithm of Remark 6 (Bartolini, Ferrara, Usai 1998; ref. [24]).

    Args:
        s: sliding variable [unit].
        extremum: s_M, its value when s' was last 0 [unit].
        gains: mu is the greater control, nu the one between s_M and half of it.

    Returns:
        v of (27) = -alpha mu sign(s - s_M/2), alpha = nu/mu on the way back from s_M to s_M/2, else
        1; 0 where s = s_M/2 [unit/s^2].
    """
    off = s - 0.5 * extremum
    gain = gains.nu if off * (extremum - s) > 0.0 else gains.mu
    return -gain if off > 0.0 else gain if off < 0.0 else 0.0


@compilable
def last_extremum(memory: ChannelMemory) -> float:
    """s_M of Remark 6: s one sample earlier where its change turns round, else as before.

    Args:
        memory: with s of this sample.

    Returns:
        s_M [unit].
    """
    turned = memory.change * (memory.before - memory.before_that) < 0.0
    return memory.before if turned else memory.own
