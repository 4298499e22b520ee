"""The paper's experiment again: its figures 6 to 9, and its statements one by one (section V)."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import degrees
from typing import TYPE_CHECKING

import numpy as np

from datasets.bodies import pair_gaps
from pipeline.live import run
from pipeline.report.marks import Marks, marks_of
from pipeline.report.series import Collector, Floats, Series
from pipeline.report.style import color_of, draw_marks, new_figure
from pipeline.rigs import connect
from pipeline.scenario import load_scenario
from pipeline.setup import Setup, make_setup
from pipeline.studies.study import Progress, Result
from pipeline.viewers.stage import name_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_TURN = 2.65, 5.1  # of the leader [s]
_BODY = 0.075  # side of a robot [m]
_Measure = Callable[[Series], float]


@dataclass(frozen=True, slots=True)
class _Statement:
    """What the paper says, and how a run is asked for it; the worst of the runs counts."""

    text: str
    paper: str
    unit: str
    measure: _Measure
    worst: Callable[[Sequence[float]], float]
    low: float
    high: float


@dataclass(frozen=True, slots=True)
class PaperAgain:
    """Runs of the scenario `paper` through rendered frames.

    Attributes:
        periods: of the commands; the figure shows the last one, the paper's own [ms].
        runs: of each period, with the seeds 0, 1, ...; the figure shows the first.
    """

    periods: tuple[float, ...] = (10.0, 60.0)
    runs: int = 5
    name: str = "paper"
    summary: str = "figures 6 to 9 of the paper through rendered frames, its statements one by one"

    def run(self, progress: Progress) -> Result:
        """Drive, and ask every run for every statement.

        Args:
            progress: is told the share that is done.

        Returns:
            One row a statement: what the paper says, ours at each period, whether it holds.
        """
        found: dict[float, list[Series]] = {}
        for number, period in enumerate(self.periods):
            changes = (f"control.command_period_s={1e-3 * period}",)
            setup = make_setup(load_scenario("paper", changes))
            for seed in range(self.runs):
                progress((number + seed / self.runs) / len(self.periods))
                found.setdefault(period, []).append(_driven(changes, setup, seed))
        header = (
            "statement", "paper", "unit", *(f"ours_{period:g}_ms" for period in self.periods),
            "holds",
        )  # fmt: skip
        rows = tuple(_row(statement, list(found.values())) for statement in _STATEMENTS)
        shown = found[self.periods[-1]][0]
        return Result(header, rows, lambda: _figure(shown, setup))


def _driven(changes: tuple[str, ...], setup: Setup, seed: int) -> Series:
    collector = Collector(setup)
    rig = connect(load_scenario("paper", changes), "rendered", None, seed, fast=True)
    run(setup, replace(rig, observers=(collector,)), setup.period)
    return collector.series()


def _row(statement: _Statement, found: Sequence[Sequence[Series]]) -> tuple[str | float, ...]:
    values = [statement.worst([statement.measure(one) for one in runs]) for runs in found]
    holds = all(statement.low <= value <= statement.high for value in values)
    return (
        statement.text, statement.paper, statement.unit, *(round(v, 3) for v in values),
        "yes" if holds else "no",
    )  # fmt: skip


def _errors(series: Series, column: int, start: float, end: float) -> float:
    """Greatest error of any follower between two times, true states."""
    between = (series.times >= start) & (series.times <= end)
    return float(np.abs(series.true_errors[:, between, column]).max())


def _speeds(series: Series, robot: int) -> Floats:
    """True speeds of a robot while the leader turns [m/s]."""
    turning = (series.times >= _TURN[0]) & (series.times <= _TURN[1])
    speeds: Floats = series.true[turning, robot, 3]
    return speeds


def _gap(series: Series) -> float:
    """Least distance between two bodies [mm]."""
    sides = np.full(len(series.robots), _BODY)
    return 1e3 * float(pair_gaps(series.true[:, :, :3], sides).min())


_STATEMENTS = (
    _Statement(
        "a triangle in 5 s: distance errors then", "5 s", "mm",
        lambda s: 1e3 * _errors(s, 0, 4.95, 5.05), max, 0.0, 20.0,
    ),
    _Statement(
        "a triangle in 5 s: bearing errors then", "5 s", "deg",
        lambda s: degrees(_errors(s, 1, 4.95, 5.05)), max, 0.0, degrees(0.1),
    ),
    _Statement(
        "tracked through the change of size at 5.5 s: distance errors from then on", "tracked",
        "mm", lambda s: 1e3 * _errors(s, 0, 5.5, 8.0), max, 0.0, 20.0,
    ),
    _Statement(
        "asymptotically stable in spite of uncertainties: distance errors at the end", "stable",
        "mm", lambda s: 1e3 * _errors(s, 0, 7.5, 8.0), max, 0.0, 5.0,
    ),
    _Statement(
        "asymptotically stable in spite of uncertainties: bearing errors at the end", "stable",
        "deg", lambda s: degrees(_errors(s, 1, 7.5, 8.0)), max, 0.0, 4.0,
    ),
    _Statement(
        "R3 accelerates in the turn: greatest speed", "until 1", "m/s",
        lambda s: float(_speeds(s, 2).max()), max, 0.85, 1.1,
    ),
    _Statement(
        "R2 slows down in the turn: least speed", "slower", "m/s",
        lambda s: float(_speeds(s, 1).min()), max, 0.0, 0.45,
    ),
    _Statement(
        "no collision from the first instant: least gap between bodies", "avoided", "mm",
        _gap, min, 0.0, np.inf,
    ),
)  # fmt: skip


def _figure(series: Series, setup: Setup) -> "Figure":
    """Figures 6 to 9, one below the other."""
    figure, plots = new_figure(11.5, 5, shared=False)
    floor, *over_time = plots
    marks = marks_of(setup, (), setup.duration)
    for robot, robot_id in enumerate(series.robots):
        x, y = series.true[:, robot, 0], series.true[:, robot, 1]
        floor.plot(x, y, color=color_of(robot), lw=1.8, label=name_of(robot_id))
    floor.set_aspect("equal", adjustable="datalim")
    floor.set_title("Fig. 6: trajectories")
    floor.set_xlabel("x  [m]")
    floor.set_ylabel("y  [m]")
    floor.legend(loc="center left")
    followers = range(1, len(series.robots))
    scaled = (1e3 * series.true_errors[:, :, 0], np.degrees(series.true_errors[:, :, 1]))
    curves = [dict(zip(followers, errors, strict=True)) for errors in scaled]
    curves += [{robot: series.true[:, robot, column] for robot in followers} for column in (3, 4)]
    labels = (
        ("Fig. 7: tracking errors", "distance error  [mm]"), ("", "bearing error  [deg]"),
        ("Fig. 8: linear velocities", "v  [m/s]"), ("Fig. 9: angular velocities", "ω  [rad/s]"),
    )  # fmt: skip
    for axes, by_robot, (title, label) in zip(over_time, curves, labels, strict=True):
        _over_time(axes, series, by_robot, marks)
        axes.set_title(title)
        axes.set_ylabel(label)
    plots[-1].set_xlabel("mission time  [s]")
    return figure


def _over_time(axes: "Axes", series: Series, curves: "dict[int, Floats]", marks: Marks) -> None:
    """One curve a follower; the turn is shaded, the change of size ruled."""
    for robot, values in curves.items():
        axes.plot(series.times, values, color=color_of(robot), lw=1.3)
    draw_marks(axes, marks, text=False)
    axes.set_xlim(0.0, 8.0)
