"""The error of one channel in the sliding phase (23), in closed form, and the set Lambda it leaves.

e'' + K e' + L e = 0 with K, L > 0: two real poles, a double pole, or a complex pair.
"""

from math import atan2, atanh, inf, isfinite, pi, sqrt

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from control.actuation import require_finite
from control.channel import ChannelGains
from control.errors import ControlError
from control.relative import Vector2

FloatArray = NDArray[np.float64]


def nominal_error(
    gains: ChannelGains, error: float, rate: float, t: ArrayLike
) -> tuple[FloatArray, FloatArray]:
    """Error and rate at given times, equation (23).

    Args:
        gains: K and L, > 0.
        error: e(0) [m or rad].
        rate: e'(0) [m/s or rad/s].
        t: times of any shape, finite; below 0 the past that led to the pair [s].

    Returns:
        e(t) and e'(t), of the shape of t [m or rad, per s].
    """
    even, odd = _basis(gains, np.asarray(t, dtype=np.float64))
    sigma = 0.5 * gains.proportional
    return (
        error * (even + sigma * odd) + rate * odd,
        rate * (even - sigma * odd) - gains.integral * error * odd,
    )


def greatest(gains: ChannelGains, error: float, rate: float) -> Vector2:
    """Exact max |e| and max |e'| over all t >= 0, equation (23).

    Args:
        gains: K and L, > 0.
        error: e(0) [m or rad].
        rate: e'(0) [m/s or rad/s].

    Returns:
        The least alpha or beta of (9) that does [m or rad], and the same of the rate [per s].

    Raises:
        ControlError: if a number is not finite.
    """
    require_finite("initial error", error, rate)
    second = _next(gains, error, rate)
    turn = nominal_error(gains, error, rate, _first_zero(gains, rate, second))[0]
    bend = _first_zero(gains, second, _next(gains, rate, second))
    fastest = nominal_error(gains, error, rate, bend)[1]
    return max(abs(error), abs(float(turn))), max(abs(rate), abs(float(fastest)))


def half_width(gains: ChannelGains, bound: float, rate: float = 0.0) -> float:
    """Greatest w such that every e(0) in [-w, w] is in Lambda, a side of it.

    Lambda = {(e, e'): |e(t)| <= bound for all t >= 0}, invariant by (23).

    From rest in a shape at rest (Remark 5) w is the whole bound, for any K and L.

    Args:
        gains: K and L, > 0.
        bound: alpha or beta of (9), > 0 [m or rad].
        rate: e'(0), the same for all of the set [m/s or rad/s].

    Returns:
        The half width, 0 if not even e(0) = 0 stays [m or rad].

    Raises:
        ControlError: if a number is not finite or the bound is not positive.
    """
    _require_bound(bound)

    def _excess(width: float) -> float:
        return max(greatest(gains, end, rate)[0] for end in (width, -width)) - bound

    if _excess(0.0) >= 0.0:
        return 0.0
    return bound if _excess(bound) <= 0.0 else float(scipy.optimize.brentq(_excess, 0.0, bound))


def _next(gains: ChannelGains, value: float, rate: float) -> float:
    """Second derivative of a solution."""
    return -gains.proportional * rate - gains.integral * value


def _basis(gains: ChannelGains, t: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Even and odd solution times exp(-K t/2): cosh, sinh/eta or cos, sin/omega of (23)."""
    sigma = 0.5 * gains.proportional
    discriminant = sigma * sigma - gains.integral
    if discriminant < 0.0:
        omega = sqrt(-discriminant)
        decay = np.exp(-sigma * t)
        return decay * np.cos(omega * t), decay * t * np.sinc(omega * t / pi)
    eta = sqrt(discriminant)
    x = 2.0 * eta * t
    decay = np.exp(-gains.integral / (sigma + eta) * t)  # the slower pole, without cancellation
    ratio = np.where(x == 0.0, 1.0, -np.expm1(-x) / np.where(x == 0.0, 1.0, x))
    return 0.5 * decay * (1.0 + np.exp(-x)), decay * t * ratio


def _first_zero(gains: ChannelGains, value: float, rate: float) -> float:
    """The first time > 0 at which a solution is 0; 0 if there is none [s]."""
    sigma = 0.5 * gains.proportional
    odd, discriminant = rate + sigma * value, sigma * sigma - gains.integral
    if value == 0.0 and rate == 0.0:
        return 0.0
    if discriminant < 0.0:
        omega = sqrt(-discriminant)
        return (atan2(value * omega, -odd) % pi or pi) / omega
    ahead, eta = (-value / odd if odd else -1.0), sqrt(discriminant)
    if not (0.0 < ahead < inf and eta * ahead < 1.0):
        return 0.0
    return atanh(eta * ahead) / eta if eta > 0.0 else ahead


def _require_bound(bound: float) -> None:
    if not (isfinite(bound) and bound > 0.0):
        raise ControlError(f"the bound of an error must be > 0 and finite, got {bound}")
