"""Robust exact differentiators of Levant (ref. [21]): derivatives of orders 1 to n from samples.

Implicit, or explicit and homogeneous (Livne and Levant). Periods may vary, samples may be missing.
Plain floats.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import factorial, inf, isfinite, isnan, prod

from control.errors import ControlError
from control.geometry import wrap_angle

MAX_ORDER = 5
"""Highest order of a differentiator."""

_MAX_NEWTON = 60  # quadratic from above: a dozen steps suffice

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
    """Memory of a differentiator of order n: the polynomial of degree n that it takes for f.

    Attributes:
        t: time of the last sample, seen or missed [s].
        nodes: (n + 1,) times of the last samples seen, newest first; the explicit form has its last
            one in all places [s].
        z: (n + 1,) z_i is i! times the divided difference over the first i + 1 nodes: of the
            samples while the implicit form slides, and plain derivatives where all nodes are one
            [unit per s^i].
        lipschitz: L, bound of the derivative of order n + 1, > 0 [unit per s^(n+1)].
        error: explicit form: z_0 less the last sample, 0 if that is missing [unit]; else None.
    """

    t: float
    nodes: tuple[float, ...]
    z: tuple[float, ...]
    lipschitz: float
    error: float | None

    @property
    def derivatives(self) -> tuple[float, ...]:
        """(n + 1,) The signal and its derivatives at t, after missing samples extrapolated."""
        return _derivatives(self.nodes, self.z, self.t)

    @property
    def rate(self) -> float:
        """First derivative at t [unit per s]."""
        return self.derivatives[1]  # z_1 + tau z_2/2 + tau^2 z_3/3 + ... for even periods


def begin_differentiator(
    t: float,
    value: float,
    lipschitz: float,
    order: int = 2,
    rate: float = 0.0,
    explicit: bool = False,
) -> Differentiator:
    """Memory at the first sample: higher derivatives 0.

    Args:
        t: time of the sample [s].
        value: the signal [unit].
        lipschitz: L, bound of the derivative of order + 1, > 0 [unit per s^(order + 1)].
        order: n, derivatives to estimate, 1 to 5.
        rate: what the first derivative is thought to be [unit per s].
        explicit: the explicit homogeneous form instead of the implicit one.

    Returns:
        The memory.

    Raises:
        ControlError: if the order or the bound is out of range, or the sample is not finite.
    """
    if not (1 <= order <= MAX_ORDER and 0.0 < lipschitz < inf):
        raise ControlError(
            f"differentiator: order {order} not in 1..{MAX_ORDER} or bound {lipschitz} not > 0"
        )
    if not (isfinite(t) and isfinite(value) and isfinite(rate)):
        raise ControlError(
            f"differentiator: begins with value {value}, rate {rate} at {t} s; give finite ones"
        )
    z = (value, rate) + (0.0,) * (order - 1)
    return Differentiator(t, (t,) * (order + 1), z, lipschitz, 0.0 if explicit else None)


def differentiate(memory: Differentiator, t: float, value: float | None) -> Differentiator:
    """Take one more sample; the period may vary.

    Args:
        memory: the memory so far.
        t: time of the sample, after the last one [s].
        value: the signal, an angle unwrapped; None or NaN if it was not seen: the polynomial then
            goes on as it was [unit].

    Returns:
        The memory after the sample.

    Raises:
        ControlError: if the sample is infinite, or its time not finite or not later than the last.
    """
    if not (isfinite(t) and t > memory.t):
        raise ControlError(
            f"differentiator: a sample at {t} s after one at {memory.t} s; times must ascend"
        )
    if value is not None and not isfinite(value):
        if not isnan(value):
            raise ControlError(f"differentiator: sample {value} at {t} s; give None if not seen")
        value = None
    if memory.error is not None:
        return _explicit_step(memory, memory.error, t, value)
    return replace(memory, t=t) if value is None else _implicit_step(memory, t, value)


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


def _explicit_step(m: Differentiator, e: float, t: float, value: float | None) -> Differentiator:
    """Livne and Levant: z_i+ = sum_j>=i tau^(j-i) z_j/(j-i)! + tau psi_i(e), e = z_0 - f."""
    n, tau, ahead = len(m.z) - 1, t - m.t, _derivatives(m.nodes, m.z, t)
    psi = _corrections(_gains(m), e, abs(e) ** (1.0 / (n + 1)), float(e != 0.0))
    z = tuple(a + tau * psi_i for a, psi_i in zip(ahead, psi, strict=True))
    return Differentiator(t, (t,) * (n + 1), z, m.lipschitz, 0.0 if value is None else z[0] - value)


def _implicit_step(m: Differentiator, t: float, value: float) -> Differentiator:
    """z_i+ = z_i + h_i (psi_i(e) + z_(i+1)+), with psi_i at the error e after the step."""
    n, gains = len(m.z) - 1, _gains(m)
    h = [(t - node) / (i + 1) for i, node in enumerate(m.nodes)]  # all tau for even periods
    error = _derivatives(m.nodes, m.z, t)[0] - value
    p, xi = _implicit_error(abs(error), [prod(h[: i + 1]) * gains[i] for i in range(n + 1)])
    psi = _corrections(gains, error, p, xi)
    z = [0.0]  # z_(n+1)
    for i in range(n, -1, -1):
        z.append(m.z[i] + h[i] * (psi[i] + z[-1]))
    return Differentiator(t, (t, *m.nodes[:n]), tuple(reversed(z[1:])), m.lipschitz, None)


def _gains(m: Differentiator) -> list[float]:
    """lambda~_(n-i) L^((i+1)/(n+1)) of psi_0 to psi_n."""
    n = len(m.z) - 1
    return [_LAMBDA[n - 1][n - i] * m.lipschitz ** ((i + 1) / (n + 1)) for i in range(n + 1)]


def _corrections(gains: list[float], error: float, p: float, xi: float) -> list[float]:
    """psi_i for errors of the sign of `error`, of size p^(n+1); |psi_n| is its gain times xi."""
    n, sign = len(gains) - 1, 1.0 if error > 0.0 else -1.0
    return [-g * sign * (p ** (n - i) if i < n else xi) for i, g in enumerate(gains)]


def _derivatives(nodes: tuple[float, ...], z: tuple[float, ...], t: float) -> tuple[float, ...]:
    """Of Newton's polynomial, sum_j z_j/j! prod_i<j (t - node_i), by Horner's rule."""
    result = [0.0] * len(z)
    for j in range(len(z) - 1, -1, -1):
        reach = t - nodes[j]
        for i in range(len(z) - 1 - j, 0, -1):
            result[i] = result[i] * reach + i * result[i - 1]
        result[0] = result[0] * reach + z[j] / factorial(j)
    return tuple(result)


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
