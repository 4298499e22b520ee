"""What would be needed where a condition fails: gains, a slower leader, a wider shape."""

from collections.abc import Callable
from dataclasses import dataclass, replace

from scipy.optimize import brentq

from control.conditions import law_conditions, spacing_condition
from control.demands import (
    Channels,
    Law,
    LeastGains,
    channel_bounds,
    least_gains_apart,
    least_gains_shared,
)
from control.disturbance import Compensation, Dynamics
from control.uncertainty import Motion

FASTEST = 16.0
"""Greatest pace of the leader that is tried, over the pace it has [1]."""

SPACINGS: tuple[float, ...] = tuple(0.25 * 2.0 ** (0.5 * i) for i in range(11))
"""Least distances that are tried, over the least wanted one [1]."""

PRECISION = 1e-3
"""Of paces and spacings that are searched, relative [1]."""


@dataclass(frozen=True, slots=True)
class Needs:
    """What would meet the conditions that act per channel; gains and motion at their very edge.

    Attributes:
        apart: least gains if each channel had its own; None if none suffice.
        shared: least gains if both have the same numbers; None if none suffice.
        pace: greatest pace of the leader for the given gains, on the same path: its speed over the
            speed bound, at most 16; None if not even a leader at rest helps [1].
        leader_speed: the leader's speed bound at that pace [m/s].
        spacing: least wanted distance, all else as it is, for the given gains; a quarter of the
            present one to eight times it are tried; None if none helps [m].
    """

    apart: tuple[LeastGains, LeastGains] | None
    shared: LeastGains | None
    pace: float | None
    leader_speed: float | None
    spacing: float | None


def find_needs(
    law: Law, motion: Motion, dynamics: Dynamics, compensation: Compensation, channels: Channels
) -> Needs:
    """What would meet the conditions that act per channel.

    Args:
        law: the given gains.
        motion: what may happen.
        dynamics: K and L of both channels.
        compensation: what the law takes out.
        channels: what the law must reject in this motion.

    Returns:
        Least gains for this motion, and the greatest pace and least spacing for these gains.
    """

    def slack(moved: Motion) -> float:
        # what fails most; the spacing first, without which nothing else has a bound
        if not spacing_condition(moved).holds:
            return -1.0
        bounds = channel_bounds(moved, dynamics, compensation)
        return min(item.slack for item in law_conditions(law, bounds))

    pace = _greatest_pace(lambda k: slack(replace(motion, leader=motion.leader.scaled(k))))
    low = motion.reference.distance[0]

    def spaced(share: float) -> float:
        return slack(replace(motion, reference=motion.reference.moved((share - 1.0) * low)))

    share = _least_share(spaced)
    return Needs(
        least_gains_apart(law, channels),
        least_gains_shared(law, channels),
        pace,
        None if pace is None else pace * motion.leader.speed,
        None if share is None else share * low,
    )


def _greatest_pace(slack: Callable[[float], float]) -> float | None:
    """Greatest pace with a positive slack, which falls with the pace."""
    if not slack(0.0) > 0.0:
        return None
    if slack(FASTEST) > 0.0:
        return FASTEST
    edge = float(brentq(slack, 0.0, FASTEST, rtol=PRECISION, xtol=1e-9))
    return edge * (1.0 - 2.0 * PRECISION)


def _least_share(slack: Callable[[float], float]) -> float | None:
    """Least share of the spacing tried with a positive slack, then where the slack begins."""
    failing = None
    for share in SPACINGS:
        if slack(share) > 0.0:
            if failing is None:
                return share
            edge = float(brentq(slack, failing, share, rtol=PRECISION, xtol=1e-9))
            return min(share, edge * (1.0 + 2.0 * PRECISION))
        failing = share
    return None
