"""One channel of a follower's law: its error, the integrals (17) and (25), its sliding variable."""

from dataclasses import dataclass

from control.compilable import compilable
from control.value import value


@value
@dataclass(frozen=True, slots=True)
class ChannelGains:
    """Gains of the sliding phase (23) of one channel: e'' + K e' + L e = 0.

    Attributes:
        proportional: K, > 0 [1/s].
        integral: L, > 0 [1/s^2].
    """

    proportional: float
    integral: float


@value
@dataclass(frozen=True, slots=True)
class ChannelMemory:
    """What one channel carries from sample to sample; its unit is m or rad.

    Attributes:
        error: e_1 = h^d - h [unit].
        integral: d of (17), d_bar of (25) [unit s].
        double_integral: c_bar of (25) [unit s^2].
        sliding: s of (24) [unit] or of (16) [unit/s].
        before: s one sample earlier.
        before_that: s two samples earlier.
        applied: v that the saturated command really applied [unit/s^2].
        applied_before: v one sample earlier [unit/s^2].
        own: what the law itself remembers, 0 at first: the last extremum of s (suboptimal), the
            integral term (super-twisting), the estimated disturbance (compensated twisting).
    """

    error: float
    integral: float
    double_integral: float
    sliding: float = 0.0
    before: float = 0.0
    before_that: float = 0.0
    applied: float = 0.0
    applied_before: float = 0.0
    own: float = 0.0

    @property
    def change(self) -> float:
        """Delta of (31): s less s one sample earlier."""
        return self.sliding - self.before


@compilable
def begin_channel(error: float, error_rate: float, gains: ChannelGains) -> ChannelMemory:
    """Memory with s(0) = 0, and s'(0) = 0 for (24): no reaching phase; (17), (25).

    Args:
        error: e_1(0) [unit].
        error_rate: e_2(0) [unit/s].
        gains: K and L.

    Returns:
        Memory for the sample of this same moment.
    """
    k, l = gains.proportional, gains.integral  # noqa: E741 (the paper's L)
    d = (-error_rate - k * error) / l
    c = (-error - k * d) / l
    return ChannelMemory(error, d, c, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@compilable
def sample_channel(
    memory: ChannelMemory,
    error: float,
    error_rate: float,
    dt: float,
    gains: ChannelGains,
    first_order: bool,
) -> ChannelMemory:
    """Take a sample: integrals by trapezoids, then the sliding variable.

    Args:
        memory: of the sample before.
        error: e_1 now, an angle wrapped [unit].
        error_rate: e_2 now; only (16) needs it [unit/s].
        dt: time since the sample before, 0 at the first [s].
        gains: K and L.
        first_order: whether s is that of (16) instead of (24).

    Returns:
        The memory with s of now; `applied` and `own` are left to the law.
    """
    m, k, l = memory, gains.proportional, gains.integral  # noqa: E741 (the paper's L)
    d = m.integral + 0.5 * dt * (m.error + error)
    c = m.double_integral + 0.5 * dt * (m.integral + d)
    s = error_rate + k * error + l * d if first_order else error + k * d + l * c
    before = m.sliding if dt > 0.0 else s  # Delta = 0 at the first sample (31)
    return ChannelMemory(error, d, c, s, before, m.before, m.applied, m.applied_before, m.own)
