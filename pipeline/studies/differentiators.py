"""Which differentiator errs how much: over noise, period and order; sin t m, seen with noise."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_coeffs

from control.differentiator import MAX_ORDER, begin_differentiator, differentiate
from pipeline.report.style import GREY, color_of, new_figure
from pipeline.studies.drawing import draw_curve, logarithmic, period_axis, shades
from pipeline.studies.study import Progress, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]
_Method: TypeAlias = tuple[str, int]  # name and order
_Curve: TypeAlias = tuple[_Method, tuple[str, str, str]]  # method; mark and line, colour, label
_LIPSCHITZ = 1.0  # bound of every derivative of sin t m [m/s^n]
_WINDOW = 9  # samples of the Savitzky-Golay filter
_FRAME = 1000.0 / 30.0  # period of a 30 fps camera [ms]
_ORDERS = range(1, MAX_ORDER + 1)
_METHODS: tuple[_Method, ...] = (
    *(("implicit", order) for order in _ORDERS),
    *(("explicit", order) for order in _ORDERS),
    ("Savitzky-Golay", 2),
    ("backward difference", 1),
)


@dataclass(frozen=True, slots=True)
class Differentiators:
    """Largest error of the rate of sin t m in the second half of a run.

    Attributes:
        periods: sampling periods, at noises of 0, 1 and 10 mm [ms].
        noises: uniform noise, within plus and minus that, at the period of a camera [mm].
        until: end of a run [s].
        runs: with different noise, of which the median counts.
    """

    periods: tuple[float, ...] = (10.0, 20.0, _FRAME, 60.0, 100.0)
    noises: tuple[float, ...] = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0)
    until: float = 40.0
    runs: int = 20
    name: str = "differentiators"
    summary: str = "errors of Levant's differentiators of orders 1 to 5, over noise and period"

    def run(self, progress: Progress) -> Result:
        """Differentiate by every method.

        Args:
            progress: is told the share that is done.

        Returns:
            Errors, one row a method, period and noise.
        """
        cases = dict.fromkeys((period, n) for period in self.periods for n in (0.0, 1.0, 10.0))
        cases |= dict.fromkeys((_FRAME, noise) for noise in self.noises)
        total, done = sum(1.0 / period for period, _ in cases), 0.0
        errors: dict[tuple[_Method, float, float], float] = {}
        for period, noise in cases:
            for method in _METHODS:
                progress(done / total)
                errors[method, period, noise] = self._error(method, period, noise)
            done += 1.0 / period
        header = "method", "order", "period_ms", "noise_mm", "largest_error_mmps"
        rows = tuple((*method, p, noise, e) for (method, p, noise), e in errors.items())
        return Result(header, rows, lambda: _figure(errors, self.noises, self.periods))

    def _error(self, method: _Method, period: float, noise: float) -> float:
        """Median over the runs of the largest error [mm/s]; period [ms], noise [mm]."""
        count = round(1e3 * self.until / period) + 1
        times: Floats = 1e-3 * period * np.arange(count, dtype=np.float64)
        late, errors = times >= 0.5 * self.until, []
        for seed in range(self.runs if noise else 1):
            off = np.random.default_rng(seed).uniform(-noise, noise, len(times))
            rates = _rates(method, times, np.sin(times) + 1e-3 * off)
            errors.append(np.abs(rates - np.cos(times))[late].max())
        return 1e3 * float(np.median(errors))


def _rates(method: _Method, times: Floats, values: Floats) -> Floats:
    """Rate at every sample, from that one and those before."""
    name, order = method
    period = times[1] - times[0]
    if name == "backward difference":
        differences: Floats = np.diff(values, prepend=values[0]) / period
        return differences
    if name == "Savitzky-Golay":  # slope at the last sample of the parabola through a window
        weights = savgol_coeffs(_WINDOW, order, deriv=1, delta=period, pos=_WINDOW - 1)
        slopes: Floats = np.convolve(values, weights)[: len(values)]
        return slopes
    samples = list(zip(times.tolist(), values.tolist(), strict=True))
    explicit = name == "explicit"
    memory = begin_differentiator(*samples[0], _LIPSCHITZ, order, explicit=explicit)
    rates = [memory.rate]
    for sample in samples[1:]:
        memory = differentiate(memory, *sample)
        rates.append(memory.rate)
    return np.array(rates)


def _figure(
    errors: Mapping[tuple[_Method, float, float], float],
    noises: Sequence[float],
    periods: Sequence[float],
) -> "Figure":
    """Methods above, orders below; over noise on the left, over the period on the right."""
    figure, plots = new_figure(6.6, 2, 2)
    for (left, right), curves in zip((plots[:2], plots[2:]), (_methods(), _orders()), strict=True):
        for method, look in curves:
            draw_curve(left, noises, [errors[method, _FRAME, noise] for noise in noises], look)
            draw_curve(right, periods, [errors[method, period, 1.0] for period in periods], look)
        logarithmic(left, "xy")
        left.set_ylabel("largest error of the rate  [mm/s]")
    _label(plots, periods)
    return figure


def _methods() -> Sequence[_Curve]:
    return (
        (("backward difference", 1), ("o-", GREY, "backward difference")),
        (("Savitzky-Golay", 2), ("v-", color_of(3), f"Savitzky-Golay, {_WINDOW} samples")),
        (("explicit", 2), ("s-", color_of(2), "explicit, order 2")),
        (("implicit", 2), ("^-", color_of(1), "implicit, order 2")),
    )


def _orders() -> Sequence[_Curve]:
    """Implicit ones in full, explicit ones dashed, without a label."""
    colors = shades(len(_ORDERS))
    return [
        ((form, order), (line, color, f"{order}" if form == "implicit" else ""))
        for form, line in (("explicit", "--"), ("implicit", "o-"))
        for order, color in zip(_ORDERS, colors, strict=True)
    ]


def _label(plots: "Sequence[Axes]", periods: Sequence[float]) -> None:
    over_noise, over_period, orders_over_noise, orders_over_period = plots
    over_noise.set_title(f"methods, every {_FRAME:.0f} ms")
    over_period.set_title("methods, noise ±1 mm")
    orders_over_noise.set_title(f"orders, every {_FRAME:.0f} ms")
    orders_over_period.set_title("orders, noise ±1 mm")
    orders_over_noise.set_xlabel("noise, ±  [mm]")
    period_axis(orders_over_period, periods)
    over_period.legend(loc="lower left")
    title = "order (full: implicit, dashed: explicit)"
    orders_over_period.legend(loc="lower left", ncols=MAX_ORDER, title=title, columnspacing=1.2)
