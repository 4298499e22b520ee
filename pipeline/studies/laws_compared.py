"""All laws side by side in the formation of the paper: accuracy, busy commands, clearance."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import degrees
from typing import TYPE_CHECKING

import numpy as np

from control.laws import Law, is_first_order
from pipeline.report.style import new_figure
from pipeline.simulation.runs import Batch
from pipeline.studies.drawing import draw_curve, law_color, legend_below, logarithmic, period_axis
from pipeline.studies.many_runs import simulated, worst_follower
from pipeline.studies.study import Progress, Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_HEADER = (
    "law", "period_ms", "distance_rms_mm", "bearing_rms_deg", "turn_command_variation_radps_per_s",
    "least_clearance_mm",
)  # fmt: skip
_MARKS = "^osvDPX*"
_Found = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class LawsCompared:
    """Medians over runs of the worst follower, the filter between bodies off.

    Attributes:
        periods: of the commands [ms].
        runs: of every law and period.
    """

    periods: tuple[float, ...] = (5.0, 10.0, 20.0, 33.0, 60.0)
    runs: int = 8
    name: str = "laws"
    summary: str = "all laws side by side: accuracy, variation of the commands, least clearance"

    def run(self, progress: Progress) -> Result:
        """Simulate every law at every period.

        Args:
            progress: is told the share that is done.

        Returns:
            One row a law and period.
        """
        cases = [(law, period) for law in Law for period in self.periods]
        points = [
            (
                "safety.clearance_m=0", f"control.law={law.title}",
                f"control.command_period_s={1e-3 * period}",
            )
            for law, period in cases
        ]  # fmt: skip
        found = {
            case: _found(batches, 1e-3 * case[1])
            for case, batches in zip(cases, simulated(points, self.runs, progress), strict=True)
        }
        rows = tuple((law.title, period, *found[law, period]) for law, period in cases)
        return Result(_HEADER, rows, lambda: _figure(found, self.periods))


def _found(batches: Sequence[Batch], period: float) -> _Found:
    """Medians over the runs, and the least clearance of all."""
    variations = [_variation(batch, period) for batch in batches]
    return (
        1e3 * float(np.median(worst_follower(batches, 0))),
        degrees(float(np.median(worst_follower(batches, 2)))),
        float(np.median(np.concatenate(variations))),
        1e3 * float(min(batch.figures.clearance.min() for batch in batches)),
    )


def _variation(batch: Batch, period: float) -> "np.ndarray[tuple[int], np.dtype[np.float64]]":
    """How far the turn command of the busiest follower goes up and down in a second, (N,)."""
    busiest = []
    for (first, end, _), commands in zip(
        batch.drawn.chance.ticks, batch.trace.commands, strict=True
    ):
        steps = np.abs(np.diff(commands[first:end, 1:, 1], axis=0)).sum(axis=0)
        busiest.append(steps.max() / ((end - first) * period))
    return np.array(busiest)


def _figure(found: Mapping[tuple[Law, float], _Found], periods: Sequence[float]) -> "Figure":
    """A plot a figure, over the period."""
    figure, plots = new_figure(7.4, 4)
    labels = (
        "distance rms  [mm]", "bearing rms  [deg]", "turn command up and\ndown  [rad/s per s]",
        "least clearance  [mm]",
    )  # fmt: skip
    for column, (axes, label) in enumerate(zip(plots, labels, strict=True)):
        for law, mark in zip(Law, _MARKS, strict=True):
            curve = [found[law, period][column] for period in periods]
            line = f"{mark}--" if is_first_order(law) else f"{mark}-"
            draw_curve(axes, periods, curve, (line, law_color(law), law.title))
        if column < 3:
            logarithmic(axes, "y")
        axes.set_ylabel(label)
    plots[0].set_title("the paper's formation, simulated, worst follower")
    period_axis(plots[-1], periods)
    legend_below(figure)
    return figure
