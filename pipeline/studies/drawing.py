"""What the studies' figures share."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axes import Axes


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
