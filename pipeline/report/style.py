"""How all figures look: one palette, safe for colour-blind readers, and few lines."""

from contextlib import AbstractContextManager
from io import BytesIO
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.report.marks import Marks

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LEADER = "#222222"
GREY = "#8a8f98"
# The palette of Okabe and Ito, in an order in which neighbours differ most.
_FOLLOWERS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
_SETTINGS: dict[Any, Any] = {
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


def house_style() -> AbstractContextManager[None]:
    """The settings under which all figures are drawn.

    Returns:
        A context in which they hold.
    """
    from matplotlib import rc_context

    return rc_context(_SETTINGS)


def new_figure(
    height: float, rows: int = 1, columns: int = 1, shared: bool = True
) -> "tuple[Figure, list[Axes]]":
    """Begin a figure with plots.

    Args:
        height: of the figure, 7.4 inches wide [inch].
        rows: of plots.
        columns: of plots.
        shared: whether a column shares its horizontal axis, and a row its vertical one.

    Returns:
        The figure and its plots, row by row.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.4, height), dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    if shared:
        axes = figure.subplots(rows, columns, sharex="col", sharey="row", squeeze=False)
    else:
        axes = figure.subplots(rows, columns, squeeze=False)
    return figure, list(np.ravel(axes))


def png_of(figure: "Figure") -> bytes:
    """A figure as a file.

    Args:
        figure: finished.

    Returns:
        A PNG without the library's version, so that the same figure gives the same bytes.
    """
    data = BytesIO()
    figure.savefig(data, format="png", metadata={"Software": None})
    return data.getvalue()


def draw_marks(axes: "Axes", marks: Marks, text: bool) -> None:
    """Shade turns and rule instants across a plot over time.

    Args:
        axes: the plot.
        marks: of the run.
        text: whether to write what they are above the plot.
    """
    for turn in marks.turns:
        axes.axvspan(turn.start, turn.end, color="#eef1f5", zorder=0, lw=0)
    for instant in marks.instants:
        axes.axvline(instant.start, color=GREY, lw=0.9, ls=(0, (4, 3)), zorder=1)
    if not text:
        return
    for height, row in ((4.0, marks.turns), (15.0, marks.instants)):
        for mark in row:
            axes.annotate(
                mark.text,
                (0.5 * (mark.start + mark.end), 1.0),
                xycoords=axes.get_xaxis_transform(),
                xytext=(0.0, height),
                textcoords="offset points",
                fontsize=8,
                color="#5a6068",
                ha=mark.align,
            )


def say_empty(axes: "Axes", text: str) -> None:
    """Say in the middle of a plot why it is empty.

    Args:
        axes: the plot.
        text: the reason.
    """
    axes.text(0.5, 0.5, text, transform=axes.transAxes, ha="center", va="center", color=GREY)
