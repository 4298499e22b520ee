"""Second-order sliding-mode laws for one channel: twisting, implicit and sampled.

Plain floats: two channels of every follower call this at command rate. The laws act on
s'' = v + p with |p| <= rho, equation (28), and bring s and s' to zero.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Protocol

from control.errors import ControlError


@dataclass(frozen=True, slots=True)
class TwistingGains:
    """Gains of a twisting law, for s'' in units per second squared.

    Attributes:
        mu: control while |s| grows [1/s^2 times the unit of s].
        nu: control while |s| shrinks, 0 < nu < mu [the same].
        horizon: over which the implicit law plans to stop, at least the period is used [s].

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


class TwistingLaw(Protocol):
    """What every twisting law is: a function of one channel's sample."""

    def __call__(
        self, s: float, s_rate: float, s_change: float, dt: float, gains: TwistingGains
    ) -> float:
        """Control of one channel.

        Args:
            s: sliding variable.
            s_rate: its rate, estimated from samples of s alone [1/s].
            s_change: its change since the last sample, 0 at the first.
            dt: period [s].
            gains: gains of the law.

        Returns:
            v of (27) [1/s^2].
        """
        ...


def implicit_twisting(
    s: float, s_rate: float, s_change: float, dt: float, gains: TwistingGains
) -> float:
    """Twisting solved for the end of the horizon T instead of its start: no chatter.

    The unique v in -a Sgn(s + 1.5 T s' + T^2 v) - b Sgn(s' + T v) with a = (mu + nu)/2 and
    b = (mu - nu)/2. T equal to the period is the exact implicit discretisation of twisting.

    Args:
        s: sliding variable.
        s_rate: its rate [1/s].
        s_change: unused.
        dt: period [s].
        gains: gains of the law.

    Returns:
        v of (27), |v| <= mu [1/s^2].
    """
    del s_change
    horizon = max(gains.horizon, dt)
    a, b = 0.5 * (gains.mu + gains.nu), 0.5 * (gains.mu - gains.nu)
    # v at which the first, and the second, sign changes
    p1 = -(s + 1.5 * horizon * s_rate) / (horizon * horizon)
    p2 = -s_rate / horizon
    low, high, between = (p1, p2, b - a) if p1 <= p2 else (p2, p1, a - b)
    # the middle one of low, high, between, mu, -mu
    return max(-gains.mu, min(gains.mu, max(low, min(high, between))))


def sampled_twisting(
    s: float, s_rate: float, s_change: float, dt: float, gains: TwistingGains
) -> float:
    """The sampled twisting algorithm exactly as published, equation (31).

    Stable only for short periods: about 5 ms with the paper's gains and a 5 cm camera offset.

    Args:
        s: sliding variable.
        s_rate: unused.
        s_change: Delta of (31).
        dt: unused.
        gains: mu and nu.

    Returns:
        v of (27): -mu sign(s), -nu sign(s), or 0 for s = 0 [1/s^2].
    """
    del s_rate, dt
    gain = gains.mu if s * s_change > 0.0 else gains.nu
    return -gain if s > 0.0 else gain if s < 0.0 else 0.0


_LAWS: Mapping[str, TwistingLaw] = MappingProxyType(
    {"implicit-twisting": implicit_twisting, "sampled-twisting": sampled_twisting}
)

TWISTING_LAWS: tuple[str, ...] = tuple(_LAWS)


def twisting_law(name: str) -> TwistingLaw:
    """Find a law by its name.

    Args:
        name: one of TWISTING_LAWS.

    Returns:
        The law.

    Raises:
        ControlError: if there is no law of that name.
    """
    if name not in _LAWS:
        raise ControlError(f"no twisting law {name!r}; there are: {', '.join(TWISTING_LAWS)}")
    return _LAWS[name]
