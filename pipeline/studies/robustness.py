"""Where the default design holds: maps over what a lab may get wrong."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pipeline.report.style import new_figure
from pipeline.studies.many_runs import Changes, simulated, worst_follower
from pipeline.studies.study import Progress, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_POSITION_STD, _HEADING_STD = 0.5, 0.46  # of a measured pose at noise 1 [mm, deg]
_LOST_MM = 75.0  # a robot's length off its place
_Cell = tuple[str, float, float]  # map, across, up


@dataclass(frozen=True, slots=True)
class Robustness:
    """Median distance error of the worst follower, over two pairs of troubles.

    Attributes:
        mass_errors: eps of both followers, inertia the other way; the host believes in none [%].
        latencies: of the camera, known to the host [ms].
        noises: of the measured poses, in multiples of 0.5 mm and 0.46 deg.
        losses: of the frames [%].
        runs: of every cell.
    """

    mass_errors: tuple[float, ...] = (0.0, 10.0, 20.0, 30.0, 40.0, 50.0)
    latencies: tuple[float, ...] = (20.0, 40.0, 80.0, 120.0, 160.0)
    noises: tuple[float, ...] = (0.5, 1.0, 2.0, 4.0, 8.0, 16.0)
    losses: tuple[float, ...] = (0.0, 20.0, 40.0, 60.0, 70.0)
    runs: int = 16
    name: str = "robustness"
    summary: str = "where the default design holds: mass error, latency, noise, lost frames"

    def run(self, progress: Progress) -> Result:
        """Simulate every cell of both maps.

        Args:
            progress: is told the share that is done.

        Returns:
            One row a cell: median and worst of its runs.
        """
        cells = [("mass-latency", m, t) for m in self.mass_errors for t in self.latencies]
        cells += [("noise-loss", noise, lost) for noise in self.noises for lost in self.losses]
        found: dict[_Cell, tuple[float, float]] = {}
        runs = simulated([_changes(cell) for cell in cells], self.runs, progress)
        for cell, batches in zip(cells, runs, strict=True):
            errors = 1e3 * worst_follower(batches, 0)
            errors[np.isnan(errors)] = np.inf  # its mission never started, or was stopped
            found[cell] = float(np.median(errors)), float(errors.max())
        header = (
            "map", "mass_error_percent", "latency_ms", "noise_factor", "frames_lost_percent",
            "distance_rms_median_mm", "distance_rms_worst_mm",
        )  # fmt: skip
        rows = tuple((*_row(cell), *map(_finite, errors)) for cell, errors in found.items())
        return Result(header, rows, lambda: _figure(self, found))


def _changes(cell: _Cell) -> Changes:
    which, across, up = cell
    if which == "mass-latency":
        errors = [f"robots.{robot}.mass_error={across / 100.0}" for robot in (2, 3)]
        errors += [f"robots.{robot}.inertia_error={-across / 100.0}" for robot in (2, 3)]
        return (*errors, f"camera.latency_s={up / 1000.0}")
    return (
        f"simulation.position_std_m={across * _POSITION_STD / 1000.0}",
        f"simulation.heading_std_deg={across * _HEADING_STD}",
        f"camera.dropped_share={up / 100.0}",
    )


def _row(cell: _Cell) -> tuple[str, float, float, float, float]:
    """A cell, with what the scenario says of the other map's troubles."""
    which, across, up = cell
    if which == "mass-latency":
        return which, across, up, 1.0, 0.0
    return which, 10.0, 40.0, across, up


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


def _figure(study: Robustness, found: Mapping[_Cell, tuple[float, float]]) -> "Figure":
    """Both maps, with the medians written into the cells."""
    figure, plots = new_figure(3.9, 1, 2, shared=False)
    left, right = plots
    _draw_map(left, "mass-latency", study.mass_errors, study.latencies, found)
    left.set_xlabel("error of mass, and of inertia\nthe other way  [%]")
    left.set_ylabel("camera latency  [ms]")
    _draw_map(right, "noise-loss", study.noises, study.losses, found)
    right.set_xlabel("noise of poses, in multiples of\n0.5 mm and 0.46 deg")
    right.set_ylabel("frames lost  [%]")
    figure.suptitle(
        "distance error of the worst follower, rms  [mm]", x=0.01, ha="left", fontweight="bold"
    )
    return figure


def _draw_map(
    axes: "Axes",
    which: str,
    across: Sequence[float],
    up: Sequence[float],
    found: Mapping[_Cell, tuple[float, float]],
) -> None:
    """Cells from light to dark, grey where a follower is lost."""
    from matplotlib import colormaps

    values = np.array([[found[which, x, y][0] for x in across] for y in up])
    ramp = colormaps["YlGnBu"].with_extremes(over="#8a8f98")
    shown = np.log(np.clip(values, 1.0, 1e6))
    axes.grid(visible=False)
    axes.imshow(shown, cmap=ramp, vmin=0.0, vmax=np.log(_LOST_MM), origin="lower", aspect="auto")
    for (row, column), value in np.ndenumerate(values):
        text = "lost" if value > _LOST_MM else f"{value:.1f}" if value < 10.0 else f"{value:.0f}"
        dark = value > 15.0
        axes.text(
            column, row, text, ha="center", va="center", fontsize=8,
            color="white" if dark else "#222222",
        )  # fmt: skip
    axes.set_xticks(range(len(across)), [f"{value:g}" for value in across])
    axes.set_yticks(range(len(up)), [f"{value:g}" for value in up])
