"""Conditions on the gains of every law, with numbers, and what would meet them.

They are sufficient: where one fails, nothing is proved, and nothing is proved to go wrong.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf

import numpy as np
import scipy

from control.demands import Demands
from control.follower import SlidingGains
from control.laws import Law, is_first_order
from control.relative import Vector2

CHANNELS = (("distance", "m/s^2"), ("bearing", "rad/s^2"))


@dataclass(frozen=True, slots=True)
class Doubt:
    """What is not known of a follower.

    Attributes:
        model_error: E, bound of |eps| and |eps'| of (5), in [0, 1) [1].
        push: length of pi of (4) at the camera point [m/s^2].
    """

    model_error: float = 0.0
    push: float = 0.0


@dataclass(frozen=True, slots=True)
class Condition:
    """One inequality: given > needed, or >= where that is enough to stay on s = 0.

    Attributes:
        name: what is asked, in the paper's symbols; its first word is the gain.
        channel: "distance", "bearing" or "both".
        given: the gain.
        needed: at the worst sample.
        unit: of both.
        strict: whether equality fails.
    """

    name: str
    channel: str
    given: float
    needed: float
    unit: str
    strict: bool = True

    @property
    def holds(self) -> bool:
        """Whether it holds."""
        return self.given > self.needed or (not self.strict and self.given == self.needed)


@dataclass(frozen=True, slots=True)
class Needs:
    """What alone would meet the conditions of a second-order law, all else as it is.

    Attributes:
        gains: least mu and nu, the same in both channels; None if none suffice [m/s^2, rad/s^2].
        uncoupled: the same if no channel's control disturbed the other, as in the paper.
        model_error: greatest E; None if not even exact robots help [1].
        pace: greatest pace of the leader, up to 1; None if not even standing helps [1].
        spacing: least added distance, up to three times the present one; None if none helps [m].
    """

    gains: Vector2 | None
    uncoupled: Vector2
    model_error: float | None
    pace: float | None
    spacing: float | None


def conditions(
    gains: SlidingGains, demand: Demands, doubt: Doubt, rate: float = inf
) -> tuple[Condition, ...]:
    """The conditions of the law in use over a tube of errors.

    Twisting in all its forms: those after (31). Suboptimal (Bartolini, Ferrara, Usai 1998) with
    V = mu and alpha* V = nu: V > rho/(alpha* delta) and V > 4 rho/(3 delta - alpha* delta'): every
    extremum of s is smaller than the one before. In them rho is that of (30) and what the other
    channel's control, at most mu, does to this one; the paper leaves that out. First order: lambda
    of (20) is computed at every sample, so that its margin eta alone must cover what the law is not
    told. Super-twisting: k1 = 1.5 Lip^(1/2), k2 = 1.1 Lip for k2 delta > Lip' and
    k1 delta > (k2 delta + Lip')^(1/2) (Seeber and Horn 2017), as if the gain were constant.

    Args:
        gains: law and gains.
        demand: what must be rejected.
        doubt: model errors and pushes.
        rate: of the disturbance, for super-twisting [m/s^3].

    Returns:
        The conditions, channel by channel.
    """
    if gains.law == Law.SUPER_TWISTING:
        given, g = gains.reaching.lipschitz, 1.0 - doubt.model_error
        spare = 2.25 * g * g - 1.1 * g
        needed = rate * max(1.0 / (1.1 * g), 1.0 / spare) if spare > 0.0 else inf
        return (Condition("Lip > rate of the disturbance", "both", given, needed, "m/s^3"),)
    if is_first_order(gains.law):
        needed = float(demand.untold(doubt.model_error).max())
        name = "eta >= what is not told of the leader's acceleration"
        return (Condition(name, "both", gains.reaching.margin, needed, "m/s^2", strict=False),)
    return _second_order(gains, demand, doubt)


def find_needs(
    gains: SlidingGains, doubt: Doubt, moved: Callable[[float, float], Demands]
) -> Needs | None:
    """What alone would meet the conditions of a second-order law.

    Args:
        gains: law and gains.
        doubt: model errors and pushes.
        moved: demands at a pace of the leader and with an added distance [1, m].

    Returns:
        The needs; None for first-order laws, whose conditions are one number.
    """
    if is_first_order(gains.law):
        return None

    def _slack(pace: float, added: float) -> float:
        met = conditions(gains, moved(pace, added), doubt)
        return min(1.0 - condition.needed / condition.given for condition in met)

    now = moved(1.0, 0.0)
    near = float(now.near.min())
    wider = (near * (share - 1.0) for share in np.geomspace(1.0, 4.0, 25))
    return Needs(
        _least_gains(gains.law, now, doubt, coupled=True),
        _least_gains(gains.law, now, doubt, coupled=False) or (inf, inf),
        _greatest_error(gains, now, doubt),
        _greatest_pace(lambda pace: _slack(pace, 0.0)),
        next((float(added) for added in wider if _slack(1.0, added) > 0.0), None),
    )


def _shape(law: Law) -> Vector2:
    """(p, q) of mu > (delta' nu + p rho)/(q delta)."""
    return (4.0, 3.0) if law == Law.SUBOPTIMAL else (2.0, 1.0)


def _second_order(gains: SlidingGains, demand: Demands, doubt: Doubt) -> tuple[Condition, ...]:
    mu, nu, (p, q) = gains.twisting.mu, gains.twisting.nu, _shape(gains.law)
    low, high = 1.0 - doubt.model_error, 1.0 + doubt.model_error
    name = f"mu > (delta' nu + {p:g} rho)/{'(3 delta)' if q > 1.0 else 'delta'}"
    loads = demand.disturbance(doubt.model_error, doubt.push)
    loads = loads + mu * demand.coupling(doubt.model_error)
    found: list[Condition] = []
    for (channel, unit), load in zip(CHANNELS, loads.max(axis=1).tolist(), strict=True):
        needed = (high * nu + p * load) / (q * low)
        found.append(Condition("nu > rho/delta", channel, nu, load / low, unit))
        found.append(Condition(name, channel, mu, needed, unit))
    return tuple(found)


def _least_gains(law: Law, demand: Demands, doubt: Doubt, coupled: bool) -> Vector2 | None:
    """mu and nu at the edge: mu = share (rho + coupling mu), nu = (rho + coupling mu)/delta."""
    low, high = 1.0 - doubt.model_error, 1.0 + doubt.model_error
    p, q = _shape(law)
    share = (p + high / low) / (q * low)
    rho = demand.disturbance(doubt.model_error, doubt.push)
    loop = 1.0 - share * demand.coupling(doubt.model_error if coupled else 0.0)
    if not loop.min() > 0.0:
        return None
    mu = float((share * rho / loop).max())
    return mu, mu / (share * low)


def _greatest_error(gains: SlidingGains, demand: Demands, doubt: Doubt) -> float | None:
    """All conditions are linear in E."""
    mu, nu, (p, q) = gains.twisting.mu, gains.twisting.nu, _shape(gains.law)
    still = demand.disturbance(0.0, doubt.push)
    grows = demand.disturbance(1.0, doubt.push) - still + mu * demand.coupling(1.0)
    by_nu = (nu - still) / (nu + grows)
    by_mu = (q * mu - nu - p * still) / (q * mu + nu + p * grows)
    most = float(min(by_nu.min(), by_mu.min()))
    return most if most > 0.0 else None


def _greatest_pace(slack: Callable[[float], float]) -> float | None:
    if slack(1.0) > 0.0:
        return 1.0
    return float(scipy.optimize.brentq(slack, 0.0, 1.0, xtol=1e-3)) if slack(0.0) > 0.0 else None
