"""The error of one channel in the sliding phase, equation (23), in closed form.

e'' + K e' + L e = 0 with K, L > 0: two real poles, a double pole, or a complex pair. The set of
initial pairs (e, e') whose error never leaves a bound is what Lambda of the paper is made of.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import atan2, atanh, ceil, inf, isfinite, log, pi, sqrt

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq

from control.actuation import require_finite
from control.errors import ControlError

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Extremes:
    """Least and greatest error and rate of one channel; 0, where every error ends, included.

    Attributes:
        low: least error, <= 0 [m or rad].
        high: greatest error, >= 0 [m or rad].
        rate_low: least rate, <= 0 [m/s or rad/s].
        rate_high: greatest rate, >= 0 [m/s or rad/s].

    Raises:
        ControlError: if a number is not finite or has the wrong sign.
    """

    low: float
    high: float
    rate_low: float = 0.0
    rate_high: float = 0.0

    def __post_init__(self) -> None:
        require_finite("extremes", self.low, self.high, self.rate_low, self.rate_high)
        if not (self.low <= 0.0 <= self.high and self.rate_low <= 0.0 <= self.rate_high):
            raise ControlError(f"extremes of an error must include 0, got {self}")

    @property
    def greatest(self) -> float:
        """Greatest magnitude of the error: alpha or beta of (9) [m or rad]."""
        return max(abs(self.low), self.high)


@dataclass(frozen=True, slots=True)
class ErrorDynamics:
    """One channel of (23): e'' + K e' + L e = 0.

    Attributes:
        proportional: K, > 0 [1/s].
        integral: L, > 0 [1/s^2].

    Raises:
        ControlError: unless both are positive and finite.
    """

    proportional: float
    integral: float

    def __post_init__(self) -> None:
        if not (0.0 < self.proportional < inf and 0.0 < self.integral < inf):
            raise ControlError(
                "the sliding phase needs K > 0 1/s and L > 0 1/s^2, "
                f"got {self.proportional} 1/s, {self.integral} 1/s^2"
            )

    def at(self, error: float, rate: float, t: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Error and rate at given times, equation (23).

        Args:
            error: e(0) [m or rad].
            rate: e'(0) [m/s or rad/s].
            t: times of any shape, finite; below 0 the past that led to the pair [s].

        Returns:
            e(t) and e'(t), of the shape of t [m or rad, per s].
        """
        even, odd = self._basis(np.asarray(t, dtype=np.float64))
        sigma = 0.5 * self.proportional
        return (
            error * (even + sigma * odd) + rate * odd,
            rate * (even - sigma * odd) - self.integral * error * odd,
        )

    def extremes(self, error: float, rate: float) -> Extremes:
        """Exact extremes of error and rate over all t >= 0, equation (23).

        Args:
            error: e(0) [m or rad].
            rate: e'(0) [m/s or rad/s].

        Returns:
            Extremes; (9) needs their greatest magnitude.

        Raises:
            ControlError: if a number is not finite.
        """
        require_finite("initial error", error, rate)
        jerk = self._next(rate, self._next(error, rate))
        values, _ = self.at(error, rate, (0.0, *self._turns(error, rate)))
        _, rates = self.at(error, rate, (0.0, *self._zeros(self._next(error, rate), jerk)))
        return Extremes(
            min(0.0, float(values.min())),
            max(0.0, float(values.max())),
            min(0.0, float(rates.min())),
            max(0.0, float(rates.max())),
        )

    def settling_time(self, error: float, rate: float, band: float) -> float:
        """Time after which the error never leaves a band again, equation (23).

        Args:
            error: e(0) [m or rad].
            rate: e'(0) [m/s or rad/s].
            band: half width of the band, > 0 [m or rad].

        Returns:
            The time, 0 if the error never leaves the band [s].

        Raises:
            ControlError: if a number is not finite or the band is not positive.
        """
        if not 0.0 < band < inf:
            raise ControlError(f"an error settles into a band > 0, got {band}")
        if self.extremes(error, rate).greatest <= band:
            return 0.0

        def outside(t: float) -> float:
            return abs(float(self.at(error, rate, t)[0])) - band

        start, end = self._last_crossing(outside, error, rate, band)
        if outside(start) <= 0.0:  # a peak as high as the band, but for rounding
            return start
        return end if outside(end) >= 0.0 else float(brentq(outside, start, end))

    def _basis(self, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Even and odd solution times exp(-K t/2): cosh, sinh/eta or cos, sin/omega of (23)."""
        sigma = 0.5 * self.proportional
        discriminant = sigma * sigma - self.integral
        if discriminant < 0.0:
            omega = sqrt(-discriminant)
            decay = np.exp(-sigma * t)
            return decay * np.cos(omega * t), decay * t * np.sinc(omega * t / pi)
        eta = sqrt(discriminant)
        x = 2.0 * eta * t
        decay = np.exp(-self.integral / (sigma + eta) * t)  # the slower pole, without cancellation
        ratio = np.where(x == 0.0, 1.0, -np.expm1(-x) / np.where(x == 0.0, 1.0, x))
        return 0.5 * decay * (1.0 + np.exp(-x)), decay * t * ratio

    def _next(self, value: float, rate: float) -> float:
        """Second derivative of a solution."""
        return -self.proportional * rate - self.integral * value

    def _turns(self, error: float, rate: float) -> tuple[float, ...]:
        """The first times at which e' = 0 [s]."""
        return self._zeros(rate, self._next(error, rate))

    def _zeros(self, value: float, rate: float) -> tuple[float, ...]:
        """The first two times > 0 at which a solution is 0; fewer where there are fewer [s]."""
        sigma = 0.5 * self.proportional
        odd, discriminant = rate + sigma * value, sigma * sigma - self.integral
        if value == 0.0 and rate == 0.0:
            return ()
        if discriminant < 0.0:
            omega = sqrt(-discriminant)
            phase = atan2(value * omega, -odd) % pi or pi
            return phase / omega, (phase + pi) / omega
        ahead = -value / odd if odd else -1.0
        eta = sqrt(discriminant)
        if not (0.0 < ahead < inf and eta * ahead < 1.0):
            return ()
        return (atanh(eta * ahead) / eta if eta > 0.0 else ahead,)

    def _last_crossing(
        self, outside: Callable[[float], float], error: float, rate: float, band: float
    ) -> tuple[float, float]:
        """Times between which |e| falls into the band for good, e monotone between them [s]."""
        turns = self._turns(error, rate)
        if len(turns) == 2:
            sigma, half = 0.5 * self.proportional, turns[1] - turns[0]
            first = outside(turns[0]) + band
            # peaks shrink by exp(-sigma half) from one to the next
            last = ceil(log(first / band) / (sigma * half)) - 1 if first > band else -1
            return (turns[0] + last * half if last >= 0 else 0.0), turns[0] + (last + 1) * half
        if turns and outside(turns[0]) <= 0.0:
            return 0.0, turns[0]
        start, length = (turns[0] if turns else 0.0), 1.0 / sqrt(self.integral)
        while outside(start + length) > 0.0:
            length *= 2.0
        return start, start + length


def stays_within(dynamics: ErrorDynamics, error: float, rate: float, bound: float) -> bool:
    """Whether a pair is in the invariant set {(e, e'): |e(t)| <= bound for all t >= 0} of (23).

    Args:
        dynamics: K and L of the channel.
        error: e(0) [m or rad].
        rate: e'(0) [m/s or rad/s].
        bound: alpha or beta of (9), > 0 [m or rad].

    Returns:
        True if the error never exceeds the bound.

    Raises:
        ControlError: if a number is not finite or the bound is not positive.
    """
    _require_bound(bound)
    return dynamics.extremes(error, rate).greatest <= bound


def half_width(dynamics: ErrorDynamics, bound: float, rate: float = 0.0) -> float:
    """Greatest w such that every e(0) in [-w, w] keeps |e| <= bound: one side of Lambda.

    Robots that start at rest have e'(0) = h^d'(0) (Remark 5), 0 for a shape at rest; then w is the
    whole bound, for any K and L.

    Args:
        dynamics: K and L of the channel.
        bound: alpha or beta of (9), > 0 [m or rad].
        rate: e'(0), the same for all of the set [m/s or rad/s].

    Returns:
        The half width, 0 if not even e(0) = 0 keeps within the bound [m or rad].

    Raises:
        ControlError: if a number is not finite or the bound is not positive.
    """
    _require_bound(bound)

    def excess(width: float) -> float:
        ends = dynamics.extremes(width, rate), dynamics.extremes(-width, rate)
        return max(end.greatest for end in ends) - bound

    if excess(0.0) >= 0.0:
        return 0.0
    return bound if excess(bound) <= 0.0 else float(brentq(excess, 0.0, bound))


def invariant_polygon(dynamics: ErrorDynamics, bound: float, points: int = 100) -> FloatArray:
    """Boundary of the invariant set {(e, e'): |e(t)| <= bound for all t >= 0}, for a picture.

    The set is convex and symmetric. Its upper side is the path that led to (bound, 0), its lower
    side the mirrored one; the straight sides e = +-bound join them. Every vertex is on the
    boundary, the polygon inside the set.

    Args:
        dynamics: K and L of the channel.
        bound: alpha or beta of (9), > 0 [m or rad].
        points: vertices on each of the two paths, >= 2.

    Returns:
        (2 points + 1, 2) read-only pairs e, e', closed, counter-clockwise [m or rad, per s].

    Raises:
        ControlError: if the bound is not positive and finite or there are too few points.
    """
    _require_bound(bound)
    if points < 2:
        raise ControlError(f"a path needs at least 2 points, got {points}")
    past = np.linspace(0.0, -_time_across(dynamics), points)
    upper = bound * np.column_stack(dynamics.at(1.0, 0.0, past))
    upper[-1, 0] = -bound
    polygon = np.concatenate([upper, -upper, upper[:1]])
    polygon.setflags(write=False)
    return polygon


def _time_across(dynamics: ErrorDynamics) -> float:
    """Time from (-1, some rate) to (1, 0) [s]."""
    discriminant = 0.25 * dynamics.proportional**2 - dynamics.integral
    half_turn = pi / sqrt(-discriminant) if discriminant < 0.0 else inf

    def beyond(t: float) -> float:
        return 1.0 + float(dynamics.at(1.0, 0.0, -t)[0])

    t = min(0.5 / sqrt(dynamics.integral), half_turn)
    while beyond(t) > 0.0 and t < half_turn:
        t = min(2.0 * t, half_turn)
    return float(brentq(beyond, 0.0, t)) if beyond(t) < 0.0 else t


def _require_bound(bound: float) -> None:
    if not (isfinite(bound) and bound > 0.0):
        raise ControlError(f"the bound of an error must be > 0 and finite, got {bound}")
