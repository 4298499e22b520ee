"""What the studies' figures share."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from control.laws import Law
from pipeline.report.style import color_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def draw_curve(
    axes: "Axes", across: Sequence[float], up: Sequence[float], look: tuple[str, str, str]
) -> None:
    """Draw a line through values.

    Args:
        axes: the plot.
        across: values of the horizontal axis.
        up: values of the vertical axis.
        look: marks and line, and colour, as matplotlib takes them; label, "" for none.
    """
    line, color, label = look
    axes.plot(across, up, line, ms=4.2, color=color, label=label or None)


def logarithmic(axes: "Axes", which: str) -> None:
    """Make axes logarithmic, with plain numbers at the powers of ten.

    Args:
        axes: the plot.
        which: "x", "y" or "xy".
    """
    for letter in which:
        getattr(axes, f"set_{letter}scale")("log")
        axis = getattr(axes, f"{letter}axis")
        axis.set_major_formatter(lambda value, _: f"{value:g}")
        axis.set_minor_formatter(lambda *_: "")


def period_axis(axes: "Axes", periods: Sequence[float]) -> None:
    """Label a logarithmic horizontal axis by the periods that were tried.

    Args:
        axes: the plot.
        periods: to be written at the axis [ms].
    """
    logarithmic(axes, "x")
    axes.set_xticks(periods, [f"{period:.0f}" for period in periods])
    axes.set_xticks([], minor=True)
    axes.set_xlabel("sampling period  [ms]")


def legend_below(figure: "Figure") -> None:
    """Labels below the plots, those of the first plot, at most four in a row.

    Args:
        figure: whose plots have the same curves.
    """
    handles, names = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, names, ncols=min(len(names), 4), loc="outside lower center")


def law_color(law: Law) -> str:
    """Colour of a law, the same in all studies.

    Args:
        law: a follower's law.

    Returns:
        As matplotlib takes it; black is left for what is no law of ours. A first-order law has
        that of a second-order one, and dashes.
    """
    return color_of(1 + law % Law.FIRST_ORDER_SIGN)


def shades(count: int) -> list[str]:
    """Colours for ordered things, dark to light, told apart by colour-blind readers.

    Args:
        count: how many.

    Returns:
        As matplotlib takes them.
    """
    from matplotlib import colormaps
    from matplotlib.colors import to_hex

    ramp = colormaps["viridis"]
    return [to_hex(ramp(0.9 * i / max(1, count - 1))) for i in range(count)]
