"""The certificate of a follower: Omega and Lambda of (9), and whether its law holds s = 0 in them.

It is for ideal sliding: without sampling, motor lag or saturation.
"""

from dataclasses import dataclass, replace
from math import inf, isfinite

import numpy as np

from control.conditions import Condition, Doubt, Needs, conditions, find_needs
from control.course import IdealFollower, PairCourse
from control.demands import ON_COURSE, Demands, demands, disturbance_rate, push_length
from control.follower import SlidingGains
from control.nominal import greatest, half_width
from control.relative import Vector2

ROOM = 1.1  # Omega over the greatest nominal error
LEAST_OMEGA = (0.02, 0.1)  # of a follower that starts in its place [m, rad]


@dataclass(frozen=True, slots=True)
class Verdict:
    """The conditions of a law over some errors.

    Attributes:
        rho: greatest |P_bar| per channel, (30); infinite if they reach the leader [m/s^2, rad/s^2].
        conditions: all must hold.
    """

    rho: Vector2
    conditions: tuple[Condition, ...]

    @property
    def holds(self) -> bool:
        """Whether rho has a bound and all conditions hold."""
        return isfinite(max(self.rho)) and all(condition.holds for condition in self.conditions)


@dataclass(frozen=True, slots=True)
class Omega:
    """Omega of (9) and Lambda for a start.

    Attributes:
        bounds: alpha and beta: a tenth more than the nominal path needs [m, rad].
        invariant: half widths of Lambda: starts with the same rates that stay in Omega [m, rad].
        rates: greatest |e'| of these starts [m/s, rad/s].
    """

    bounds: Vector2
    invariant: Vector2
    rates: Vector2


@dataclass(frozen=True, slots=True)
class Certificate:
    """What is proved of one follower, and on which numbers it rests.

    Attributes:
        omega: where its errors stay if s = 0.
        least_distance: on the nominal path from the start [m].
        doubt: model errors and pushes that are covered.
        exact: this start, exact robots without pushes.
        run: this start, with model errors and pushes.
        everywhere: every start in Lambda, at any time. Never holds for super-twisting, for Omega
            does not bound how fast its disturbance changes.
        needs: what would meet the conditions of `run`; None where they hold or are one number.
    """

    omega: Omega
    least_distance: float
    doubt: Doubt
    exact: Verdict
    run: Verdict
    everywhere: Verdict
    needs: Needs | None


def omega_for(course: PairCourse, gains: SlidingGains) -> Omega:
    """Omega and Lambda for the start of a course.

    Args:
        course: of the pair.
        gains: K and L.

    Returns:
        The sets.
    """
    found = []
    for j, channel in enumerate((gains.distance, gains.bearing)):
        start, rate = course.error[:2, j, 0].tolist()
        bound = max(LEAST_OMEGA[j], ROOM * greatest(channel, start, rate)[0])
        width = half_width(channel, bound, rate)
        fastest = max(greatest(channel, end, rate)[1] for end in (width, -width))
        found.append((bound, width, fastest))
    (alpha, width, rate), (beta, width_2, rate_2) = found
    return Omega((alpha, beta), (width, width_2), (rate, rate_2))


def certify(
    course: PairCourse,
    ideal: IdealFollower,
    gains: SlidingGains,
    camera_offset: float,
    leader_known: bool,
) -> Certificate:
    """The certificate of a follower of one leader; model errors and pushes are those of its gains.

    Args:
        course: of the pair.
        ideal: the follower if it slides ideally.
        gains: law and gains.
        camera_offset: d [m].
        leader_known: whether it is told its leader's acceleration.

    Returns:
        The certificate.
    """
    assumed, (v, turn) = gains.reaching, ideal.motion.twist
    own = np.abs(turn) * np.hypot(v, camera_offset * turn)
    doubt = Doubt(assumed.model_error, push_length(assumed.disturbance, camera_offset))

    def _moved(pace: float, added: float) -> Demands:
        changed = course.moved(pace, added)
        return demands(changed, ON_COURSE, gains, camera_offset, leader_known, own)

    def _along(doubt: Doubt) -> Verdict:
        error = doubt.model_error
        rate = disturbance_rate(course, ideal, camera_offset, error, leader_known)
        return _verdict(gains, _moved(1.0, 0.0), doubt, rate)

    omega, run = omega_for(course, gains), _along(doubt)
    centered = replace(course, error=np.zeros_like(course.error))
    over = demands(centered, (omega.bounds, omega.rates), gains, camera_offset, leader_known)
    return Certificate(
        omega,
        float(course.output[0, 0].min()),
        doubt,
        _along(Doubt()),
        run,
        _verdict(gains, over, doubt, inf),
        find_needs(gains, doubt, _moved) if not run.holds else None,
    )


def _verdict(gains: SlidingGains, demand: Demands, doubt: Doubt, rate: float) -> Verdict:
    rho = demand.disturbance(doubt.model_error, doubt.push).max(axis=1)
    return Verdict((float(rho[0]), float(rho[1])), conditions(gains, demand, doubt, rate))
