"""Draws the shipped tag layouts for docs/layouts.md: `make layouts`."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from pipeline.cli.tagging import tags_scenario
from pipeline.config import Scenario
from pipeline.layouts import layout_names, make_tags, nominal_colors
from pipeline.sheets.arrange import on_paper, tag_box
from vision.tags import Tag

OUT = Path(__file__).parent / "layouts.png"
COLUMNS = 8  # tags shown of each layout
PITCH = 1.25  # from tag to tag, in widths of a tag


def main() -> None:
    """One row a layout, the first patterns of each; forward is up."""
    scenarios = [tags_scenario(name) for name in [*layout_names(), "aruco"]]
    width, height = COLUMNS * PITCH + 1.8, len(scenarios) * PITCH + 0.15
    figure = Figure((10.0, 10.0 * height / width), dpi=110, facecolor="#d8d8d4")
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set(xlim=(-1.6, width - 1.6), ylim=(0.05 - height, 0.05))
    axes.axis("off")
    for row, scenario in enumerate(scenarios):
        draw_row(axes, scenario, -(row + 0.5) * PITCH)
    figure.savefig(OUT)


def draw_row(axes: Axes, scenario: Scenario, y: float) -> None:
    """A layout's name and its first tags, all rows at the same width."""
    axes.text(-1.5, y, scenario.tags.layout, fontsize=11, va="center")
    for column, tag in enumerate(make_tags(scenario).tags[:COLUMNS]):
        draw_tag(axes, tag, nominal_colors(scenario), ((column + 0.6) * PITCH, y))


def draw_tag(axes: Axes, tag: Tag, colors: dict[str, str], at: tuple[float, float]) -> None:
    """One tag, one unit wide, its id below."""
    low, high = tag_box(tag)
    middle, width = 0.5 * (low + high), float((high - low).max())
    for part in tag.parts:
        corners = (on_paper(part.polygon) - middle) / width + np.array(at)
        axes.add_patch(Polygon(corners, facecolor=colors[part.color], linewidth=0.0))
    axes.text(at[0], at[1] - 0.62, f"{tag.robot_id}", fontsize=7, ha="center", va="center")


main()
