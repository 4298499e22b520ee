"""Conditions on the gains of every sliding-mode law, each with its numbers and its remedy."""

from dataclasses import dataclass
from math import inf, isfinite, sqrt

from control.demands import (
    ChannelBounds,
    Channels,
    FirstOrderGains,
    Law,
    SuboptimalGains,
    amplitude_of,
    least_gains,
)
from control.errors import ControlError
from control.relative import Vector2
from control.twisting import TwistingGains
from control.uncertainty import Motion


@dataclass(frozen=True, slots=True)
class SuperTwistingGains:
    """Gains of super-twisting on the first-order sliding variable.

    Attributes:
        root: k1, of sqrt|s|, > 0 [the root of the unit of s, per s].
        integral: k2, of the integral of sign(s), > 0 [unit of s, per s^2].

    Raises:
        ControlError: if a gain is not positive.
    """

    root: float
    integral: float

    def __post_init__(self) -> None:
        if not (0.0 < self.root < inf and 0.0 < self.integral < inf):
            raise ControlError(f"super-twisting needs k1, k2 > 0, got {self}")


@dataclass(frozen=True, slots=True)
class Condition:
    """One inequality, with its numbers: left > right, or left >= right for (20).

    Attributes:
        name: what is asked of what.
        channel: "distance", "bearing" or "pair".
        holds: whether it holds.
        left: what there is [unit].
        right: what is needed; infinite if nothing suffices [unit].
        unit: of both.
        remedy: what would make it hold, all else left as it is.
    """

    name: str
    channel: str
    holds: bool
    left: float
    right: float
    unit: str
    remedy: str

    @property
    def slack(self) -> float:
        """(left - right)/(left + right), from -1, hopeless, to 1; > 0 where it holds."""
        if not isfinite(self.right):
            return -1.0
        total = abs(self.left) + abs(self.right)
        return (self.left - self.right) / total if total else 0.0


def condition(
    name: str, channel: str, left: float, right: float, unit: str, strict: bool = True
) -> Condition:
    """An inequality with its verdict and its remedy.

    Args:
        name: what is asked; its first word is what there is to change.
        channel: where.
        left: what there is.
        right: what is needed.
        unit: of both.
        strict: whether equality fails.

    Returns:
        The condition.
    """
    holds = left > right or (not strict and left == right)
    what, sign = f"{name.split()[0]} of the {channel}", ">" if strict else ">="
    if holds:
        remedy = "nothing: it holds"
    elif isfinite(right):
        remedy = f"{what} {sign} {right:.4g} {unit} instead of {left:.4g} {unit}"
    else:
        remedy = f"no {what} suffices; smaller errors or another motion"
    return Condition(name, channel, holds, left, right, unit, remedy)


def spacing_condition(motion: Motion) -> Condition:
    """Constraint 1 of the paper: the distance stays away from 0 in Omega.

    Args:
        motion: the wanted distances and the error's extremes.

    Returns:
        The condition, in metres.
    """
    low = motion.reference.distance[0]
    return condition("spacing > error", "pair", low, motion.errors[0].high, "m")


def law_conditions(law: Law, channels: Channels) -> tuple[Condition, ...]:
    """The conditions of a law in both channels.

    Twisting: nu > rho/delta and mu > delta' nu/delta + 2 rho/delta, after (31). First order:
    lambda >= (rho + eta)/c, (20). Suboptimal (Bartolini, Ferrara, Usai, "Chattering avoidance by
    second-order sliding mode control", 1998): V > rho/(alpha* delta) and
    V > 4 rho/(3 delta - alpha* delta'). The second one makes every extremum of s smaller than the
    one before: half the way at alpha* delta' V + rho at most, stopped by delta V - rho at least.

    Args:
        law: gains, the same in both channels.
        channels: what they must reject; rho is taken with the load of the coupling.

    Returns:
        Conditions, channel by channel.
    """
    return tuple(
        item for channel in channels for item in _of_channel(law, channel, amplitude_of(law))
    )


def super_twisting_conditions(
    gains: SuperTwistingGains, lipschitz: Vector2, low: Vector2 = (1.0, 1.0)
) -> tuple[Condition, ...]:
    """k2 > Lip/delta and k1 > sqrt(k2/delta + Lip/delta^2), sufficient (Seeber and Horn, 2017).

    Checked against the exact worst case, two arcs of a linear system. The usual k1 = 1.5 sqrt(Lip),
    k2 = 1.1 Lip meet them for delta = 1. What a changing gain g adds belongs to Lip; it is asked
    for, since Omega bounds no third derivatives.

    Args:
        gains: k1 and k2, the same in both channels.
        lipschitz: greatest rate of the first-order disturbance [m/s^3, rad/s^3].
        low: delta of both channels [1].

    Returns:
        Conditions, channel by channel.
    """
    k1, k2 = gains.root, gains.integral
    found: list[Condition] = []
    for name, unit, lip, g in zip(
        ("distance", "bearing"), ("m", "rad"), lipschitz, low, strict=True
    ):
        found += (
            condition("k2 > Lip/delta", name, k2, lip / g, f"{unit}/s^3"),
            condition(
                "k1 > sqrt(k2/delta + Lip/delta^2)",
                name,
                k1,
                sqrt(k2 / g + lip / (g * g)),
                f"{unit}^0.5/s^1.5",
            ),
        )
    return tuple(found)


def sampled_accuracy(gains: TwistingGains, channel: ChannelBounds) -> float | None:
    """a in |s| <= a tau^2 of sampled twisting (31) that starts at rest on s = 0.

    The order is Levant's (1993); the constant is derived here. Let A = delta' mu + rho,
    B = delta' nu + rho and D = delta mu - rho. From speed Y tau at s = 0 the old sign may last for
    one period, at B; then D stops s; its turn may go unseen for two periods, at A; then s falls
    at B at most, so that it comes back with

        Y^2 <= 4 A^2 + B (2 Y + B) + (B/D) (Y + B)^2.

    B < D is the condition on mu. Y where both sides are equal bounds all speeds at s = 0.

    Args:
        gains: mu and nu.
        channel: bounds; v held over a period must act as if G were right throughout.

    Returns:
        a, None if the conditions of twisting fail [m/s^2 or rad/s^2].
    """
    load = channel.load(gains.mu)
    a, b = channel.high * gains.mu + load, channel.high * gains.nu + load
    stop = channel.low * gains.mu - load
    if not (b < stop and channel.low * gains.nu > load):
        return None
    q = b / stop
    half = b * (1.0 + q)
    speed = (half + sqrt(half * half + (1.0 - q) * (4.0 * a * a + b * b * (1.0 + q)))) / (1.0 - q)
    return speed + 0.5 * b + 0.5 * (speed + b) ** 2 / stop


def _of_channel(law: Law, channel: ChannelBounds, amplitude: float) -> tuple[Condition, ...]:
    where, unit = channel.name, channel.unit
    most = least_gains(law, (channel,), amplitude).amplitude
    match law:
        case TwistingGains():
            nu = channel.least(amplitude)
            needed = channel.spread * law.nu + 2.0 * nu
            return (
                condition("nu > rho/delta", where, law.nu, nu, unit),
                condition("mu > (delta' nu + 2 rho)/delta", where, law.mu, needed, unit),
            )
        case SuboptimalGains():
            both = "V > max(rho/(alpha* delta), 4 rho/(3 delta - alpha* delta'))"
            return (condition(both, where, law.amplitude, most, unit),)
        case FirstOrderGains():
            what = "lambda >= (rho + eta)/c"
            return (condition(what, where, law.reaching, most, unit, strict=False),)
