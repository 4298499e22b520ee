"""How all figures look: one palette, safe for colour-blind readers, and few lines."""

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from pipeline.report.marks import Mark

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LEADER = "#222222"
GREY = "#8a8f98"
# The palette of Okabe and Ito, in an order in which neighbours differ most.
_FOLLOWERS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
_SETTINGS = {
    "font.size": 9.5,
    "axes.titlesize": 10.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#5a6068",
    "axes.grid": True,
    "grid.color": "#e4e7eb",
    "grid.linewidth": 0.8,
    "axes.axisbelow": True,
    "legend.frameon": False,
    "legend.fontsize": 9,
    "lines.solid_capstyle": "round",
}
DPI = 160


def color_of(index: int) -> str:
    """Colour of a robot.

    Args:
        index: its place among the robots, 0 for the leader.

    Returns:
        As matplotlib takes it.
    """
    return _FOLLOWERS[(index - 1) % len(_FOLLOWERS)] if index else LEADER


def new_figure(
    height: float, rows: int = 1, ratios: tuple[int, ...] = ()
) -> "tuple[Figure, list[Axes]]":
    """Begin a figure with a column of plots that share the horizontal axis.

    Args:
        height: of the figure, 7.4 inches wide [inch].
        rows: number of plots.
        ratios: relative heights, all equal by default.

    Returns:
        The figure and its plots.
    """
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with rc_context(_SETTINGS):
        figure = Figure(figsize=(7.4, height), dpi=DPI, layout="constrained")
        FigureCanvasAgg(figure)
        grid = {"height_ratios": ratios or (1,) * rows}
        axes = figure.subplots(rows, 1, sharex=True, squeeze=False, gridspec_kw=grid)
    return figure, list(np.ravel(axes))


def draw_marks(axes: "Axes", spans: Iterable[Mark], instants: Iterable[Mark], text: bool) -> None:
    """Shade spans and rule instants across a plot over time.

    Args:
        axes: the plot.
        spans: shaded.
        instants: ruled.
        text: whether to write what they are above the plot.
    """
    above = axes.get_xaxis_transform()
    note = {"transform": above, "fontsize": 8, "color": "#5a6068", "va": "bottom"}
    for span in spans:
        axes.axvspan(span.start, span.end, color="#eef1f5", zorder=0, lw=0)
        if text:
            middle = 0.5 * (span.start + span.end)
            axes.text(middle, 1.01, f"turn {span.text}", ha="center", **note)
    for instant in instants:
        axes.axvline(instant.start, color=GREY, lw=0.9, ls=(0, (4, 3)), zorder=1)
        if text:
            axes.text(instant.start, 1.01, instant.text, ha="center", **note)


def say_empty(axes: "Axes", text: str) -> None:
    """Say in the middle of a plot why it is empty.

    Args:
        axes: the plot.
        text: the reason.
    """
    axes.text(0.5, 0.5, text, transform=axes.transAxes, ha="center", va="center", color=GREY)
