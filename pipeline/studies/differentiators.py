"""Which differentiator errs how much: over noise, period and order (design of h'(0), Remark 5)."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_coeffs

from control.differentiator import MAX_ORDER, begin_differentiator, differentiate
from pipeline.report.style import GREY, color_of, new_figure
from pipeline.studies.drawing import logarithmic, period_axis, shades
from pipeline.studies.study import Cell, Progress, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]
_WINDOW = 9  # samples of the Savitzky-Golay filter
_LIPSCHITZ = 1.0  # of every derivative of sin t
_ORDERS = range(1, MAX_ORDER + 1)
_FRAME = 1000.0 / 30.0  # period of a 30 fps camera [ms]
_NOISES = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0)  # swept at a camera's period [mm]
_PERIODS = (10.0, 20.0, _FRAME, 60.0, 100.0)  # swept at the noises of the table [ms]


@dataclass(frozen=True, slots=True)
class _Method:
    """A way from samples to rates: f(times, values) gives the rate at every sample."""

    name: str
    order: int
    rates: Callable[[Floats, Floats], Floats]


@dataclass(frozen=True, slots=True)
class Differentiators:
    """The largest error of the rate of sin t m, from samples with uniform noise.

    Attributes:
        runs: with different noise, of which the median counts.
        until: end of a run; errors count in its second half [s].
    """

    runs: int = 8
    until: float = 40.0
    name: str = "differentiators"
    summary: str = "errors of Levant's differentiators of order 1 to 5 over noise and period"

    def run(self, progress: Progress) -> Result:
        """Differentiate sin t m by every method.

        Args:
            progress: is told the share that is done.

        Returns:
            Errors, one row a method, period and noise.
        """
        cases = [(p, n) for p in _PERIODS for n in (0.0, 1.0, 10.0)]
        cases += [(_FRAME, n) for n in _NOISES if (_FRAME, n) not in cases]
        total, done, rows = sum(1.0 / p for p, _ in cases), 0.0, list[tuple[Cell, ...]]()
        for period, noise in cases:
            for method in _methods():
                error = self._error(method, 1e-3 * period, 1e-3 * noise)
                rows.append((method.name, method.order, period, noise, 1e3 * error))
                progress(done / total)
            done += 1.0 / period
        header = "method", "order", "period_ms", "noise_mm", "largest_error_mmps"
        return Result(header, tuple(rows), lambda: _figure(rows))

    def _error(self, method: _Method, period: float, noise: float) -> float:
        """Median over the runs of the largest error [m/s]."""
        times = period * np.arange(round(self.until / period) + 1)
        late, errors = times >= 0.5 * self.until, []
        for seed in range(self.runs if noise else 1):
            seen = np.sin(times) + np.random.default_rng(seed).uniform(-noise, noise, len(times))
            errors.append(np.abs(method.rates(times, seen) - np.cos(times))[late].max())
        return float(np.median(errors))


def _methods() -> Iterator[_Method]:
    for name, explicit in (("implicit", False), ("explicit", True)):
        for order in _ORDERS:
            yield _Method(name, order, _levant(order, explicit))
    yield _Method("Savitzky-Golay", 2, _savitzky_golay)
    yield _Method("backward difference", 1, _backward)


def _levant(order: int, explicit: bool) -> Callable[[Floats, Floats], Floats]:
    def _rates(times: Floats, values: Floats) -> Floats:
        samples = list(zip(times.tolist(), values.tolist(), strict=True))
        memory = begin_differentiator(*samples[0], _LIPSCHITZ, order, explicit=explicit)
        rates = [memory.rate]
        for sample in samples[1:]:
            memory = differentiate(memory, *sample)
            rates.append(memory.rate)
        return np.array(rates)

    return _rates


def _savitzky_golay(times: Floats, values: Floats) -> Floats:
    """Slope at the last of `_WINDOW` samples of the parabola through them."""
    weights = savgol_coeffs(_WINDOW, 2, deriv=1, delta=times[1] - times[0], pos=_WINDOW - 1)
    slopes: Floats = np.convolve(values, weights)[: len(values)]
    return slopes


def _backward(times: Floats, values: Floats) -> Floats:
    return np.diff(values, prepend=values[0]) / (times[1] - times[0])


def _figure(rows: Iterable[tuple[Cell, ...]]) -> "Figure":
    """Methods of order 2 above, orders below; over noise on the left, over the period right."""
    table = {(row[0], row[1], row[2], row[3]): row[4] for row in rows}
    figure, (noises, periods, noises_by_order, periods_by_order) = new_figure(6.6, 2, 2)
    colors = shades(len(_ORDERS))
    others = [
        ("backward difference", 1, "backward difference", GREY),
        ("Savitzky-Golay", 2, "Savitzky-Golay, 9 samples", color_of(3)),
        ("explicit", 2, "explicit, order 2", color_of(2)),
        ("implicit", 2, "implicit, order 2", color_of(1)),
    ]
    orders = [("implicit", n, f"{n}", colors[n - 1]) for n in _ORDERS]
    for left, right, curves in (
        (noises, periods, others),
        (noises_by_order, periods_by_order, orders),
    ):
        for method, order, label, color in curves:
            over_noise = [table[method, order, _FRAME, noise] for noise in _NOISES]
            over_period = [table[method, order, period, 1.0] for period in _PERIODS]
            left.plot(_NOISES, over_noise, "o-", ms=3.5, color=color, label=label)
            right.plot(_PERIODS, over_period, "o-", ms=3.5, color=color, label=label)
        logarithmic(left, "xy")
        left.set_ylabel("largest error of the rate  [mm/s]")
    _finish(noises, periods, noises_by_order, periods_by_order)
    return figure


def _finish(
    noises: "Axes", periods: "Axes", noises_by_order: "Axes", periods_by_order: "Axes"
) -> None:
    noises.set_title(f"methods, period {_FRAME:.0f} ms")
    periods.set_title("methods, noise ±1 mm")
    noises_by_order.set_title(f"implicit, orders 1 to 5, period {_FRAME:.0f} ms")
    periods_by_order.set_title("implicit, orders 1 to 5, noise ±1 mm")
    noises_by_order.set_xlabel("noise of the samples, ±  [mm]")
    period_axis(periods_by_order, _PERIODS)
    noises.legend(loc="lower right")
    noises_by_order.legend(loc="lower right", title="order")
