"""What the second-order laws leave of s on s'' = v + 2 sin t m/s^2, over the period.

One channel alone, sampled with and without noise: no robots, no geometry.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import cos, sin
from typing import TYPE_CHECKING

import numpy as np

from control.channel import ChannelMemory
from control.laws import Law, is_first_order
from control.twisting import TwistingGains, twist
from pipeline.report.style import new_figure
from pipeline.studies.drawing import draw_curve, law_color, legend_below, logarithmic, period_axis
from pipeline.studies.study import Progress, Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LAWS = tuple(law for law in Law if not is_first_order(law))
_DISTURBANCE = 2.0  # amplitude [m/s^2]


@dataclass(frozen=True, slots=True)
class TwistingLaws:
    """Largest |s| in the second half of a run, with the paper's mu = 20 and nu = 4.

    Attributes:
        periods: sampling periods, of which the implicit laws' horizon is one [ms].
        noises: of s, uniform [mm].
        until: end of a run [s].
        runs: with different noise, of which the median counts.
    """

    periods: tuple[float, ...] = (2.0, 5.0, 10.0, 20.0, 33.0, 60.0, 100.0)
    noises: tuple[float, ...] = (0.0, 1.0)
    until: float = 40.0
    runs: int = 4
    name: str = "twisting-laws"
    summary: str = "what the second-order laws leave of s, over period and noise"

    def run(self, progress: Progress) -> Result:
        """Control s with each law at each period.

        Args:
            progress: is told the share that is done.

        Returns:
            Largest |s|, one row a law, period and noise.
        """
        cases = [(p, noise) for p in self.periods for noise in self.noises]
        total, done = sum(1.0 / p for p, _ in cases), 0.0
        largest: dict[tuple[Law, float, float], float] = {}
        for period, noise in cases:
            for law in _LAWS:
                left = [
                    _left(law, 1e-3 * period, 1e-3 * noise, self.until, seed)
                    for seed in range(self.runs if noise else 1)
                ]
                largest[law, period, noise] = 1e3 * float(np.median(left))
                progress(done / total)
            done += 1.0 / period
        header = "law", "period_ms", "noise_mm", "largest_s_mm"
        rows = tuple((law.title, p, noise, s) for (law, p, noise), s in largest.items())
        return Result(header, rows, lambda: _figure(largest, self.periods, self.noises))


def _left(law: Law, tau: float, noise: float, until: float, seed: int) -> float:
    """Largest |s| at the samples of the second half [m]."""
    gains, count = TwistingGains(horizon=tau), round(until / tau)
    noises = np.random.default_rng(seed).uniform(-noise, noise, count)
    memory, s, rate, worst = ChannelMemory(0.0, 0.0, 0.0), 0.0, 0.0, 0.0
    for i in range(count):
        worst = max(worst, abs(s)) if 2 * i > count else worst
        seen = s + noises[i]
        memory = replace(memory, sliding=seen, before=memory.sliding, before_that=memory.before)
        v, own = twist(memory, tau, gains, law)
        memory = replace(memory, applied=v, applied_before=memory.applied, own=own)
        s, rate = _moved(s, rate, v, i * tau, tau)
    return float(worst)


def _moved(s: float, rate: float, v: float, t: float, tau: float) -> tuple[float, float]:
    """s and s' after a period: s'' = v + 2 sin t, integrated exactly."""
    a, after = _DISTURBANCE, t + tau
    s += tau * rate + 0.5 * tau * tau * v + a * (tau * cos(t) - sin(after) + sin(t))
    return s, rate + tau * v + a * (cos(t) - cos(after))


def _figure(
    largest: Mapping[tuple[Law, float, float], float],
    periods: Sequence[float],
    noises: Sequence[float],
) -> "Figure":
    """One plot a noise, side by side."""
    figure, plots = new_figure(4.0, 1, len(noises))
    for axes, noise in zip(plots, noises, strict=True):
        for law, mark in zip(_LAWS, "^osv", strict=True):
            left = [largest[law, period, noise] for period in periods]
            draw_curve(axes, periods, left, (f"{mark}-", law_color(law), law.title))
        seen = f"±{noise:g} mm of noise" if noise else "no noise"
        axes.set_title(f"s″ = v + 2 sin t, {seen}")
        period_axis(axes, periods)
    logarithmic(plots[0], "y")
    plots[0].set_ylabel("largest |s|  [mm]")
    legend_below(figure)
    return figure
