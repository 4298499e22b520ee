"""Derivatives from samples: Levant's robust exact differentiator (ref. [21]), and a line fit.

For h'(0) when robots already move at the start (Assumption 5, Remark 5 case 2). Plain floats.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, isfinite, prod
from statistics import pstdev

from control.errors import ControlError
from control.geometry import wrap_angle

_MAX_NEWTON = 60  # quadratic from above: a dozen steps suffice
_FIRST = 5  # samples over which an initial rate takes its first slope

# lambda~ of orders 1 to 5, index 0 to n: the non-recursive form of 1.1, 1.5, 2, 3, 5, 8
_LAMBDA: tuple[tuple[float, ...], ...] = (
    (1.1, 1.5),
    (1.1, 2.12, 2.0),
    (1.1, 3.06, 4.16, 3.0),
    (1.1, 4.57, 9.30, 10.03, 5.0),
    (1.1, 6.93, 21.37, 34.93, 26.39, 8.0),
)


@dataclass(frozen=True, slots=True)
class Differentiator:
    """Memory of an implicit homogeneous differentiator; its order n is len(z) - 1.

    Attributes:
        times: of the last samples, newest first; n + 1 of them after the first step [s].
        z: estimates of the signal and its derivatives, unit per s^i. While the differentiator
            slides they are i! times the divided differences of the last i + 1 samples.
        lipschitz: bound of the derivative after the last one estimated, > 0 [unit per s^(n+1)].
    """

    times: tuple[float, ...]
    z: tuple[float, ...]
    lipschitz: float

    @property
    def t(self) -> float:
        """Time of the last sample [s]."""
        return self.times[0]

    @property
    def rate(self) -> float:
        """First derivative at t [unit per s]."""
        # Newton's interpolation, differentiated; z_1 + tau z_2/2 + tau^2 z_3/3 for even periods
        result, weight = 0.0, 1.0
        for j, z in enumerate(self.z[1:], start=1):
            weight /= j
            result += weight * z
            weight *= self.times[0] - self.times[j] if j < len(self.times) else 0.0
        return result


def begin_differentiator(
    t: float, value: float, lipschitz: float, order: int = 2, rate: float = 0.0
) -> Differentiator:
    """Memory at the first sample: higher derivatives 0.

    Args:
        t: time of the sample [s].
        value: the signal.
        lipschitz: bound of the derivative of order + 1, > 0 [unit per s^(order + 1)].
        order: derivatives to estimate, 1 to 5.
        rate: what the first derivative is thought to be [unit per s].

    Returns:
        The memory.

    Raises:
        ControlError: if the order or the bound is out of range, or the sample is not finite.
    """
    if not (1 <= order <= len(_LAMBDA) and 0.0 < lipschitz < inf):
        raise ControlError(f"differentiator: order {order} not in 1..5 or bound {lipschitz} <= 0")
    if not (isfinite(t) and isfinite(value) and isfinite(rate)):
        raise ControlError(f"differentiator: sample {value} at {t} s is not finite")
    return Differentiator((t,), (value, rate) + (0.0,) * (order - 1), lipschitz)


def differentiate(memory: Differentiator, t: float, value: float) -> Differentiator:
    """Take one more sample; the period may vary, samples may be missing.

    Args:
        memory: the memory so far.
        t: time of the sample, after the last one [s].
        value: the signal; an angle must be unwrapped.

    Returns:
        The memory after the sample.

    Raises:
        ControlError: if the sample is not finite or not later than the last one.
    """
    tau = t - memory.t
    if not (isfinite(t) and isfinite(value) and tau > 0.0):
        raise ControlError(f"differentiator: sample {value} at {t} s after one at {memory.t} s")
    n = len(memory.z) - 1
    past = (
        memory.times if len(memory.times) > 1 else tuple(memory.t - k * tau for k in range(n + 1))
    )
    h = [(t - past[i]) / (i + 1) for i in range(n + 1)]  # all tau for even periods
    z = _implicit_step(memory.z, value, h, memory.lipschitz)
    return Differentiator((t, *past[:n]), z, memory.lipschitz)


def _implicit_step(
    z: tuple[float, ...], value: float, h: list[float], lipschitz: float
) -> tuple[float, ...]:
    """z after the step: z_i+ = z_i + h_i (psi_i(e) + z_(i+1)+), psi_i at the error e after it."""
    n = len(z) - 1
    gains = [_LAMBDA[n - 1][n - i] * lipschitz ** ((i + 1) / (n + 1)) for i in range(n + 1)]
    b = _unroll(z, h) - value
    p, xi = _implicit_error(abs(b), [prod(h[: i + 1]) * gains[i] for i in range(n + 1)])
    sign, result = 1.0 if b > 0.0 else -1.0, [0.0]  # z_(n+1) = 0
    for i in range(n, -1, -1):
        psi = -gains[i] * sign * (p ** (n - i) if i < n else xi)
        result.append(z[i] + h[i] * (psi + result[-1]))
    return tuple(reversed(result[1:]))


def _unroll(z: tuple[float, ...], h: list[float]) -> float:
    """z_0 after a step without correction."""
    result = 0.0
    for zi, hi in zip(reversed(z), reversed(h), strict=True):
        result = zi + hi * result
    return result


def _implicit_error(b: float, c: list[float]) -> tuple[float, float]:
    """p = |e|^(1/(n+1)) and |xi| of the sliding or reaching case; c_0 .. c_n of the step."""
    n = len(c) - 1
    if b <= c[n]:
        return 0.0, b / c[n]
    coefficients = (1.0, *c[:n], c[n] - b)  # of p^(n+1), p^n, ..., 1
    p = b ** (1.0 / (n + 1))  # above the root: there the polynomial is positive, and convex
    for _ in range(_MAX_NEWTON):
        value = slope = 0.0
        for coefficient in coefficients:
            slope = slope * p + value
            value = value * p + coefficient
        step = value / slope
        p -= step
        if step <= 1e-15 * p:
            break
    return p, 1.0


@dataclass(frozen=True, slots=True)
class InitialRate:
    """A rate and how well it is known.

    Attributes:
        rate: of the signal at the last sample [unit per s].
        spread: standard deviation of the estimate over the last third of the samples [unit per s].
    """

    rate: float
    spread: float


def initial_rate(times: Sequence[float], values: Sequence[float], lipschitz: float) -> InitialRate:
    """Rate of a signal that was watched for a moment, for h'(0) of (25): Remark 5, case 2.

    Args:
        times: (N,) capture times, N >= 2, ascending [s].
        values: (N,) the signal, angles unwrapped.
        lipschitz: bound of the signal's third derivative, > 0 [unit per s^3].

    Returns:
        The differentiator's last estimate, and how much the latest ones differ.

    Raises:
        ControlError: if there are fewer than 2 samples, the lengths differ or a sample is unusable.
    """
    if len(times) != len(values) or len(times) < 2:
        raise ControlError(f"a rate needs 2 samples, got {len(times)} times, {len(values)} values")
    first = min(_FIRST, len(times) - 1)
    if not times[first] > times[0]:
        raise ControlError(f"a rate needs ascending times, got {times[0]} and {times[first]} s")
    slope = (values[first] - values[0]) / (times[first] - times[0])
    # begun at its first slope it need not converge from 0, which takes longer than watching does
    memory = begin_differentiator(times[first], values[first], lipschitz, rate=slope)
    course = [slope]
    for t, value in zip(times[first + 1 :], values[first + 1 :], strict=True):
        memory = differentiate(memory, t, value)
        course.append(memory.rate)
    return InitialRate(course[-1], pstdev(course[-(len(course) // 3 or 1) :]))


def unwrapped(angles: Sequence[float]) -> tuple[float, ...]:
    """Make a sequence of wrapped angles continuous.

    Args:
        angles: (N,) angles [rad].

    Returns:
        (N,) angles that differ from those by whole turns, and from one another by at most half a
        turn from entry to entry [rad].
    """
    result: list[float] = []
    for angle in angles:
        result.append(result[-1] + wrap_angle(angle - result[-1]) if result else angle)
    return tuple(result)
