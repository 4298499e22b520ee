"""First-order laws of one channel: they bring s of (16) to zero, s' = v + p with |p| <= rho.

The control is Delta v of (18): a sign, its boundary layer, its implicit form, or super-twisting.
"""

from dataclasses import dataclass
from math import hypot, sqrt

from control.compilable import compilable
from control.errors import ControlError
from control.laws import Law
from control.output import FollowerOutput
from control.relative import Vector2, apply
from control.value import value


@value
@dataclass(frozen=True, slots=True)
class ReachingGains:
    """What the first-order laws assume and choose, for the distance; bearings times l are alike.

    Attributes:
        margin: eta of (20), > 0 [m/s^2].
        model_error: bound of |eps| and |eps'| of (5), 0 <= it <= 0.7 [1].
        disturbance: bounds of pi_v and pi_omega of (4), >= 0 [m/s^2, rad/s^2].
        layer: half width of the boundary layer about s = 0, > 0 [m/s].
        lipschitz: super-twisting: bound of the disturbance's derivative, > 0 [m/s^3].

    Raises:
        ControlError: if a number is out of its range.
    """

    margin: float = 0.5
    model_error: float = 0.15
    disturbance: tuple[float, float] = (0.2, 2.0)
    layer: float = 0.05
    lipschitz: float = 10.0

    def __post_init__(self) -> None:
        positive = min(self.margin, self.layer, self.lipschitz) > 0.0
        if not (positive and 0.0 <= self.model_error <= 0.7 and min(self.disturbance) >= 0.0):
            raise ControlError(
                f"first-order laws need a margin, layer and Lipschitz bound > 0, 0 <= model error "
                f"<= 0.7 and disturbances >= 0, got {self}"
            )


@compilable
def reach(s: float, strength: float, dt: float, horizon: float, layer: float, law: Law) -> float:
    """Delta v of (18) of one channel, by (19) or a smooth stand-in for it.

    Args:
        s: sliding variable of (16) [unit/s].
        strength: lambda of (20), > 0 [unit/s^2].
        dt: period [s].
        horizon: in which the implicit law brings s to 0, at least the period is used [s].
        layer: half width of the boundary layer [unit/s].
        law: FIRST_ORDER_SIGN, _LAYER or _IMPLICIT.

    Returns:
        Delta v, |it| <= lambda [unit/s^2].
    """
    if law == Law.FIRST_ORDER_SIGN:
        return -strength if s > 0.0 else strength if s < 0.0 else 0.0
    over = strength / layer if law == Law.FIRST_ORDER_LAYER else 1.0 / max(horizon, dt)
    return max(-strength, min(strength, -over * s))


@compilable
def super_twist(s: float, integral: float, lipschitz: float, tau: float) -> tuple[float, float]:
    """Super-twisting, solved for the end of the period: leaves |s| <= tau^2 lipschitz.

    s' = u + p, u = -k1 |s|^(1/2) sign s + z, z' = -k2 sign s, k1 = 1.5 sqrt(lipschitz) and
    k2 = 1.1 lipschitz (Levant 1998), s and its sign taken after the period, its size as if z
    cancelled p. Near s = 0 both settle within two periods.

    Args:
        s: sliding variable [unit/s].
        integral: z [unit/s^2].
        lipschitz: bound of |p'| [unit/s^3].
        tau: period or a longer horizon [s].

    Returns:
        u [unit/s^2], and z after the period.
    """
    k1, k2 = 1.5 * sqrt(lipschitz), 1.1 * lipschitz
    size = abs(s)
    if size <= tau * tau * k2:
        integral -= s / tau
        return integral - s / tau, integral
    sign = 1.0 if s > 0.0 else -1.0
    root = sqrt(0.25 * tau * tau * k1 * k1 + size - tau * tau * k2) - 0.5 * tau * k1
    integral -= tau * k2 * sign
    return integral - (k1 * root + tau * k2) * sign, integral


@compilable
def reaching_strength(nominal: Vector2, output: FollowerOutput, gains: ReachingGains) -> float:
    """lambda of (20) for the distance; by the size of the second entry for that.

    In metres, bearings times l, G Delta G^-1 is a rotated Delta: its norm is the larger of |eps|
    and |eps'|. With G own the nominal part is h^d'' - F + K e_2 + L e_1: the proof of Theorem 1
    needs this sum, where (20) prints F - h^d'' + K e_2 + L e_1. It also takes the vector Sign(s)
    for one of length 1; for any s, c = 1 - 2^(1/2) |Delta| is needed.

    Args:
        nominal: h^d'' - F_i + K e_2 + L e_1 [m/s^2, rad/s^2].
        output: G, own-velocity terms and size at this moment.
        gains: what is assumed of the disturbances.

    Returns:
        lambda [m/s^2].
    """
    o1, o2 = apply(output.input_matrix, output.own)
    size = output.size
    asked = hypot(nominal[0] + o1, size * (nominal[1] + o2))
    push_v, push_omega = gains.disturbance
    (a, b), (c, d) = output.input_matrix
    pushed = hypot(
        abs(a) * push_v + abs(b) * push_omega, size * (abs(c) * push_v + abs(d) * push_omega)
    )
    rho = gains.model_error * asked + pushed
    return (rho + gains.margin) / (1.0 - sqrt(2.0) * gains.model_error)  # |Sign| is 2^1/2
