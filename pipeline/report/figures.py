"""The paper's figures 6 to 9, drawn from a session; wide and pale is true, thin is estimated."""

from typing import TYPE_CHECKING

import numpy as np

from pipeline.report.marks import Marks, Peak, speed_peaks
from pipeline.report.series import Floats, Series
from pipeline.report.style import color_of, draw_marks, new_figure, say_empty
from pipeline.viewers.stage import name_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_POINTS = 6000  # drawn per curve at most
_TOLERANCES = (20.0, np.degrees(0.1))  # of "settled" [mm, deg]


def tracking_errors(series: Series, marks: Marks) -> "Figure":
    """Figure 7: errors of distance and bearing of every follower.

    Args:
        series: of the run.
        marks: turns, changes of the shape.

    Returns:
        Two plots over time.
    """
    figure, plots = new_figure(5.0, rows=2)
    units = (("distance error  [mm]", 1e3), ("bearing error  [deg]", np.degrees(1.0)))
    for column, (axes, (label, scale)) in enumerate(zip(plots, units, strict=True)):
        limit = _TOLERANCES[column]
        axes.axhspan(-limit, limit, color="#bfe5cd", alpha=0.35, lw=0, zorder=0.5)
        errors = zip(series.followers, series.true_errors, series.believed_errors, strict=True)
        for robot, true, believed in errors:
            curve = scale * true[:, column], scale * believed[:, column]
            _draw_both(axes, series, robot, *curve)
        axes.set_ylabel(label)
        draw_marks(axes, marks, text=column == 0)
        _finish_time(axes, series, last=column == 1)
    _legend(figure, series)
    return figure


def linear_velocities(series: Series, marks: Marks) -> "Figure":
    """Figure 8: forward speed of the followers, the leader's beside it.

    Args:
        series: of the run.
        marks: turns, changes of the shape.

    Returns:
        One plot over time, the paper's remarks as numbers.
    """
    figure = _velocities(series, marks, 3, "linear velocity  [m/s]")
    for peak in speed_peaks(series, marks.turns):
        _point_at(figure.axes[0], peak, color_of(series.robots.index(peak.robot_id)))
    return figure


def angular_velocities(series: Series, marks: Marks) -> "Figure":
    """Figure 9: angular velocity of the followers, the leader's beside it.

    Args:
        series: of the run.
        marks: turns, changes of the shape.

    Returns:
        One plot over time.
    """
    return _velocities(series, marks, 4, "angular velocity  [rad/s]")


def _velocities(series: Series, marks: Marks, column: int, label: str) -> "Figure":
    figure, (axes,) = new_figure(3.6)
    for robot in range(len(series.robots)):
        true, believed = series.true[:, robot, column], series.believed[:, robot, column]
        _draw_both(axes, series, robot, true, believed)
    axes.set_ylabel(label)
    draw_marks(axes, marks, text=True)
    _finish_time(axes, series, last=True)
    _legend(figure, series)
    return figure


def _draw_both(axes: "Axes", series: Series, robot: int, true: Floats, believed: Floats) -> None:
    """True values wide and pale, estimates thin; estimates alone in full."""
    color, name = color_of(robot), name_of(series.robots[robot])
    known = np.isfinite(true).any()
    if known:
        axes.plot(*_thinned(series.times, true), color=color, lw=2.6, alpha=0.45, label=name)
    if np.isfinite(believed).any():
        label = None if known else name
        width = 0.8 if known else 1.5
        axes.plot(*_thinned(series.ahead, believed), color=color, lw=width, label=label)


def _thinned(times: Floats, values: Floats) -> tuple[Floats, Floats]:
    every = max(1, len(times) // _POINTS)
    return times[::every], values[::every]


def _finish_time(axes: "Axes", series: Series, last: bool) -> None:
    if not axes.lines or not axes.get_legend_handles_labels()[0]:
        say_empty(axes, "no mission: nothing to follow was seen")
    axes.margins(x=0.0, y=0.12)
    if len(series.times) > 1:
        axes.set_xlim(min(0.0, series.times[0]), series.times[-1])
    if last:
        clock = "mission time" if series.started else "time since the first frame"
        axes.set_xlabel(f"{clock}  [s]")


def _legend(figure: "Figure", series: Series) -> None:
    """One line below the plots: the robots, and how true and estimated are told apart."""
    drawn = zip(*figure.axes[0].get_legend_handles_labels(), strict=True)
    curves = {name: handle for handle, name in drawn}  # a follower of two has two
    if not curves:
        return
    both = series.has_truth and np.isfinite(series.believed).any()
    title = "wide: true, thin: estimated" if both else ("true" if series.has_truth else "estimated")
    figure.legend(
        curves.values(),
        curves.keys(),
        title=title,
        title_fontsize=8,
        ncols=7,
        loc="outside lower center",
    )


def _point_at(axes: "Axes", peak: Peak, color: str) -> None:
    axes.plot([peak.t], [peak.value], "o", ms=4.5, color=color, zorder=5)
    axes.annotate(
        peak.text,
        (peak.t, peak.value),
        xytext=(8, 10 if peak.outer else -14),
        textcoords="offset points",
        color=color,
        fontsize=8.5,
        fontweight="bold",
    )
