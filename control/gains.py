"""The certificate of a formation law: what holds for a pair, with numbers, before anything moves.

Omega (9) from the nominal response (23), the gains' error (13), (29), the disturbances (20), (30),
the conditions after (31), and what would be needed where one of them fails.
"""

from dataclasses import dataclass
from math import inf

import numpy as np

from control.conditions import Condition, law_conditions, sampled_accuracy, spacing_condition
from control.demands import (
    CHANNELS,
    ChannelBounds,
    Channels,
    FirstOrderGains,
    Law,
    channel_bounds,
)
from control.disturbance import DEFAULT_DESIGN, Compensation, Dynamics, disturbance_norm
from control.errors import ControlError
from control.model_errors import NormBounds, norm_bounds
from control.needs import Needs, find_needs
from control.nominal import ErrorDynamics, Extremes, FloatArray, half_width, invariant_polygon
from control.relative import Vector2
from control.sliding import SlidingGains
from control.twisting import TwistingGains
from control.uncertainty import Motion


@dataclass(frozen=True, slots=True)
class Certificate:
    """What is certain of one pair under one law, and on which numbers it rests.

    The maxima behind ``channels`` and ``norm_disturbance`` are searched, not proved; the law is
    taken at its ideal, without sampling, motor lag or saturation.

    Attributes:
        alpha: bound of the distance error in Omega, (9) [m].
        beta: bound of the bearing error in Omega, (9) [rad].
        least_distance: min l^d - alpha, what (9) guarantees [m].
        nominal_least_distance: min l^d - max e_l, with the sign the error really has [m].
        channels: delta, delta', coupling and rho per channel: the sound ones.
        norm: 1 - c, delta and delta' of (13), (29) as norms: the paper's.
        norm_disturbance: rho of (20) or (30) as a norm, the paper's [m/s^2].
        conditions: all must hold; per channel, coupling included.
        published: the paper's conditions with its norms, for comparison; they leave out that the
            law acts per channel.
        accuracy: a in |s| <= a tau^2 of sampled twisting, both channels; None where no bound is
            known [m/s^2, rad/s^2].
        needs: what would make it hold; None if not asked for.
    """

    alpha: float
    beta: float
    least_distance: float
    nominal_least_distance: float
    channels: Channels
    norm: NormBounds
    norm_disturbance: float
    conditions: tuple[Condition, ...]
    published: tuple[Condition, ...]
    accuracy: tuple[float | None, float | None]
    needs: Needs | None

    @property
    def holds(self) -> bool:
        """Whether every condition that is sound holds."""
        return all(item.holds for item in self.conditions)


@dataclass(frozen=True, slots=True)
class CertificateCurves:
    """Outlines for a picture, each closed and read-only.

    Attributes:
        omega: (5, 2) the box (9) of errors: distance, bearing [m, rad].
        rest: (5, 2) Lambda of robots at rest (Remark 5): initial errors kept in Omega [m, rad].
        distance: (N, 2) invariant set of the distance: e_l, e_l' [m, m/s].
        bearing: (N, 2) invariant set of the bearing: e_psi, e_psi' [rad, rad/s].
    """

    omega: FloatArray
    rest: FloatArray
    distance: FloatArray
    bearing: FloatArray


def error_dynamics(gains: SlidingGains) -> Dynamics:
    """The sliding phase (23) of both channels.

    Args:
        gains: K and L.

    Returns:
        Dynamics of distance and bearing.
    """
    (k1, k2), (l1, l2) = gains.proportional, gains.integral
    return ErrorDynamics(k1, l1), ErrorDynamics(k2, l2)


def nominal_extremes(
    gains: SlidingGains, error: Vector2, rate: Vector2 = (0.0, 0.0)
) -> tuple[Extremes, Extremes]:
    """Omega (9) and its rates from an initial pair of errors: extremes of the sliding phase (23).

    Args:
        gains: K and L.
        error: e_1(0) of distance and bearing, the bearing wrapped [m, rad].
        rate: e_2(0); h^d'(0) for robots at rest (Remark 5) [m/s, rad/s].

    Returns:
        Extremes of distance and bearing.
    """
    first, second = error_dynamics(gains)
    return first.extremes(error[0], rate[0]), second.extremes(error[1], rate[1])


def certify(
    gains: SlidingGains,
    motion: Motion,
    compensation: Compensation = DEFAULT_DESIGN,
    law: Law | None = None,
    scale: float | None = None,
    search_needs: bool = True,
) -> Certificate:
    """Certificate of one pair: bounds, conditions, and what would be needed.

    Args:
        gains: K and L, and the twisting gains if no other law is given.
        motion: Omega and all that happens in it; ``nominal_extremes`` gives its errors.
        compensation: what the law takes out of the disturbance.
        law: gains of the law, those of twisting by default.
        scale: metres that count as a radian in the paper's norms, the mean wanted distance by
            default [m].
        search_needs: whether to look for the pace and the spacing that would do; about a second.

    Returns:
        The certificate. A distance that may reach 0 fails its condition, and with it all others.

    Raises:
        ControlError: if the law and the compensation do not belong together.
    """
    law = law or gains.twisting
    if isinstance(law, FirstOrderGains) is not compensation.leader_velocities:
        raise ControlError(
            "the first-order law (14) takes out the leader's velocities, the others cannot: "
            f"got {type(law).__name__} and leader_velocities={compensation.leader_velocities}"
        )
    dynamics = error_dynamics(gains)
    channels = channel_bounds(motion, dynamics, compensation)
    if scale is None:
        scale = 0.5 * sum(motion.reference.distance)
    norm = norm_bounds(motion, scale)
    apart = motion.spacing[0] > 0.0
    rho = disturbance_norm(motion, dynamics, compensation, scale) if apart else inf
    first, second = motion.errors
    least = motion.reference.distance[0]
    return Certificate(
        alpha=first.greatest,
        beta=second.greatest,
        least_distance=least - first.greatest,
        nominal_least_distance=motion.spacing[0],
        channels=channels,
        norm=norm,
        norm_disturbance=rho,
        conditions=(spacing_condition(motion), *law_conditions(law, channels)),
        published=law_conditions(law, _as_channels(norm, rho, law)),
        accuracy=_accuracy(law, channels),
        needs=find_needs(law, motion, dynamics, compensation, channels) if search_needs else None,
    )


def certificate_curves(
    gains: SlidingGains, alpha: float, beta: float, rate: Vector2 = (0.0, 0.0), points: int = 100
) -> CertificateCurves:
    """Omega (9) and Lambda of both channels, for a picture.

    Args:
        gains: K and L.
        alpha: bound of the distance error, > 0 [m].
        beta: bound of the bearing error, > 0 [rad].
        rate: h^d'(0) of robots at rest [m/s, rad/s].
        points: vertices on either side of an invariant set.

    Returns:
        The outlines.
    """
    first, second = error_dynamics(gains)
    return CertificateCurves(
        _box(alpha, beta),
        _box(half_width(first, alpha, rate[0]), half_width(second, beta, rate[1])),
        invariant_polygon(first, alpha, points),
        invariant_polygon(second, beta, points),
    )


def _box(a: float, b: float) -> FloatArray:
    outline = np.array([(a, b), (-a, b), (-a, -b), (a, -b), (a, b)])
    outline.setflags(write=False)
    return outline


def _as_channels(norm: NormBounds, rho: float, law: Law) -> Channels:
    """The paper's norms, as if they were channels without coupling; c in place of delta in (20)."""
    low = 1.0 - norm.gain_error if isinstance(law, FirstOrderGains) else norm.low
    first, second = (
        ChannelBounds(*names, low, norm.high, 0.0, rho / length)
        for names, length in zip(CHANNELS, (1.0, norm.scale), strict=True)
    )
    return first, second


def _accuracy(law: Law, channels: Channels) -> tuple[float | None, float | None]:
    if not isinstance(law, TwistingGains):
        return None, None
    return sampled_accuracy(law, channels[0]), sampled_accuracy(law, channels[1])
