"""The least gains with which each sliding-mode law rejects what it must: (20), (28), (31).

All laws act on s_j'' (first order: s_j') = g v_j + m v_other - P_j, one channel j each, with
delta <= g <= delta', |m| <= coupling and |P_j| <= rho. The other channel's control is a
disturbance here: the load of a channel is rho + coupling times the other's amplitude.
"""

from dataclasses import dataclass
from math import inf, isfinite
from typing import TypeAlias

from scipy.optimize import brentq

from control.disturbance import Compensation, Dynamics, channel_disturbances
from control.errors import ControlError
from control.model_errors import gain_bounds
from control.twisting import TwistingGains
from control.uncertainty import Motion

CHANNELS = (("distance", "m/s^2"), ("bearing", "rad/s^2"))
"""Names of the channels and units of their controls."""

MOST = 1e9
"""Amplitudes above this are no amplitudes [m/s^2, rad/s^2]."""


@dataclass(frozen=True, slots=True)
class SuboptimalGains:
    """Gains of the suboptimal law of Bartolini, Ferrara and Usai (Remark 6).

    Attributes:
        amplitude: V, > 0 [m/s^2, rad/s^2].
        share: alpha*, of V far from the last extremum, in (0, 1] [1].

    Raises:
        ControlError: if V is not positive or alpha* not in (0, 1].
    """

    amplitude: float
    share: float = 1.0

    def __post_init__(self) -> None:
        if not (0.0 < self.amplitude < inf and 0.0 < self.share <= 1.0):
            raise ControlError(
                f"the suboptimal law needs V > 0 and 0 < alpha* <= 1, got {self.amplitude}, "
                f"{self.share}"
            )


@dataclass(frozen=True, slots=True)
class FirstOrderGains:
    """Gains of the first-order law (19), (20).

    Attributes:
        reaching: lambda_k, > 0 [m/s^2, rad/s^2].
        margin: eta of (20), > 0 [m/s^2, rad/s^2].

    Raises:
        ControlError: if a gain is not positive.
    """

    reaching: float
    margin: float = 0.1

    def __post_init__(self) -> None:
        if not (0.0 < self.reaching < inf and 0.0 < self.margin < inf):
            raise ControlError(f"lambda and eta of (20) must be > 0, got {self}")


Law: TypeAlias = TwistingGains | SuboptimalGains | FirstOrderGains


@dataclass(frozen=True, slots=True)
class ChannelBounds:
    """What a law must reject in one channel, equation (28).

    Attributes:
        name: "distance" or "bearing".
        unit: of its control.
        low: delta of (29), or c of (13) [1].
        high: delta' of (29) [1].
        coupling: greatest share of the other channel's control [m or 1/m].
        disturbance: rho of (20) or (30) [m/s^2 or rad/s^2].
    """

    name: str
    unit: str
    low: float
    high: float
    coupling: float
    disturbance: float

    @property
    def spread(self) -> float:
        """delta'/delta, infinite unless delta > 0 [1]."""
        return _over(self.high, self.low)

    def load(self, amplitude: float) -> float:
        """Everything the channel's control must reject.

        Args:
            amplitude: of the other channel's control [its unit].

        Returns:
            rho + coupling times amplitude [m/s^2 or rad/s^2].
        """
        return self.disturbance + self.coupling * amplitude

    def least(self, amplitude: float) -> float:
        """The least control that can reject the load.

        Args:
            amplitude: of the other channel's control [its unit].

        Returns:
            Load over delta, infinite unless delta > 0 [m/s^2 or rad/s^2].
        """
        return _over(self.load(amplitude), self.low)


Channels: TypeAlias = tuple[ChannelBounds, ChannelBounds]


@dataclass(frozen=True, slots=True)
class LeastGains:
    """Gains at the very edge of the conditions; those for a slightly larger rho meet them.

    Attributes:
        amplitude: mu, V or lambda [m/s^2, rad/s^2].
        nu: of twisting, else None [m/s^2, rad/s^2].
    """

    amplitude: float
    nu: float | None = None


def channel_bounds(
    motion: Motion, dynamics: Dynamics, compensation: Compensation, resolution: int = 24
) -> Channels:
    """What a law must reject per channel, (28): delta, delta', coupling and rho.

    Args:
        motion: what may happen.
        dynamics: K and L of both channels.
        compensation: what the law takes out.
        resolution: angles of the search's grid around a full circle.

    Returns:
        Bounds of distance and bearing; infinite where the distance may reach 0.
    """
    g = gain_bounds(motion)
    rho = (inf, inf)
    if motion.spacing[0] > 0.0:
        rho = channel_disturbances(motion, dynamics, compensation, resolution)
    first, second = (
        ChannelBounds(*CHANNELS[j], g.low[j], g.high[j], g.coupling[j], rho[j]) for j in (0, 1)
    )
    return first, second


def amplitude_of(law: Law) -> float:
    """Greatest |v| a law can give.

    Args:
        law: its gains.

    Returns:
        mu, V or lambda [m/s^2, rad/s^2].
    """
    match law:
        case TwistingGains():
            return law.mu
        case SuboptimalGains():
            return law.amplitude
        case FirstOrderGains():
            return law.reaching


def least_gains(law: Law, channels: tuple[ChannelBounds, ...], amplitude: float) -> LeastGains:
    """Least gains that serve channels under a given amplitude of each one's other channel.

    Args:
        law: its kind, and alpha* or eta; its amplitudes do not matter.
        channels: what they must reject, at least one.
        amplitude: of the other channel's control [its unit].

    Returns:
        The gains, infinite if none suffice.
    """
    match law:
        case TwistingGains():
            nu = max(c.least(amplitude) for c in channels)
            return LeastGains(max(c.spread * nu + 2.0 * c.least(amplitude) for c in channels), nu)
        case SuboptimalGains():
            return LeastGains(max(_least_suboptimal(law.share, c, amplitude) for c in channels))
        case FirstOrderGains():
            return LeastGains(max(_over(c.load(amplitude) + law.margin, c.low) for c in channels))


def least_gains_apart(law: Law, channels: Channels) -> tuple[LeastGains, LeastGains] | None:
    """Least gains if each channel has its own.

    Args:
        law: its kind, and alpha* or eta; its amplitudes do not matter.
        channels: what they must reject.

    Returns:
        Gains of distance and bearing, None if the coupling lets no gains suffice.
    """
    base = [least_gains(law, (c,), 0.0).amplitude for c in channels]
    slope = [least_gains(law, (c,), 1.0).amplitude - b for c, b in zip(channels, base, strict=True)]
    loop = 1.0 - slope[0] * slope[1]
    if not (all(map(isfinite, (*base, *slope))) and loop > 0.0):
        return None
    # x_0 = base_0 + slope_0 x_1 and the other way round
    x = (base[0] + slope[0] * base[1]) / loop, (base[1] + slope[1] * base[0]) / loop
    return least_gains(law, (channels[0],), x[1]), least_gains(law, (channels[1],), x[0])


def least_gains_shared(law: Law, channels: Channels) -> LeastGains | None:
    """Least gains if both channels have the same numbers, as in the paper.

    Args:
        law: its kind, and alpha* or eta; its amplitudes do not matter.
        channels: what they must reject.

    Returns:
        The gains, None if the coupling lets no gains suffice.
    """

    def lack(amplitude: float) -> float:
        return least_gains(law, channels, amplitude).amplitude - amplitude

    if not lack(MOST) < 0.0:
        return None
    return least_gains(law, channels, float(brentq(lack, 0.0, MOST)))


def _least_suboptimal(share: float, channel: ChannelBounds, amplitude: float) -> float:
    load = channel.load(amplitude)
    return max(
        _over(load, share * channel.low),
        _over(4.0 * load, 3.0 * channel.low - share * channel.high),
    )


def _over(value: float, by: float) -> float:
    """Quotient; infinite where the gain may vanish."""
    return value / by if by > 0.0 else inf
