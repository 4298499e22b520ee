"""Which tag goes where on which page, in millimetres; forward is up on the paper."""

from dataclasses import dataclass
from math import floor

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import ConfigError
from vision.tags import Tag

Floats = NDArray[np.float64]

MARGIN = 8.0  # of the page, which printers leave white [mm]
HEADER, RULER, COLOR_ROW = 7.0, 10.0, 4.0  # heights of what else is on a page [mm]
COLORS_IN_A_ROW = 6
ABOVE, BELOW, BESIDE = 6.0, 3.0, 6.0  # room around a tag for its name and the cut marks [mm]


@dataclass(frozen=True, slots=True)
class Paper:
    """A size of paper.

    Attributes:
        name: "a4" or "letter".
        width: [mm].
        height: [mm].
    """

    name: str
    width: float
    height: float


PAPERS = (Paper("a4", 210.0, 297.0), Paper("letter", 215.9, 279.4))


@dataclass(frozen=True, slots=True)
class PrintedTag:
    """A tag with the words beside it.

    Attributes:
        tag: what is printed.
        label: its name.
    """

    tag: Tag
    label: str


@dataclass(frozen=True, slots=True)
class PlacedTag:
    """A tag on a page.

    Attributes:
        printed: the tag and its name.
        x: of the robot's centre, from the left edge of the paper [mm].
        y: from the lower edge [mm].
    """

    printed: PrintedTag
    x: float
    y: float


def paper_named(name: str) -> Paper:
    """Find a size of paper.

    Args:
        name: "a4" or "letter".

    Returns:
        The paper.

    Raises:
        ConfigError: if it is another.
    """
    for paper in PAPERS:
        if paper.name == name.lower():
            return paper
    raise ConfigError(f'no paper "{name}"; there are: {", ".join(p.name for p in PAPERS)}')


def on_paper(polygon: Floats) -> Floats:
    """Turn a polygon of the robot's frame so that forward is up.

    Args:
        polygon: shape (N, 2), x forward, y left [m].

    Returns:
        Shape (N, 2), to the right and up [mm].
    """
    return 1e3 * np.column_stack((-polygon[:, 1], polygon[:, 0]))


def tag_box(tag: Tag) -> Floats:
    """The box around all parts of a tag on paper.

    Args:
        tag: to be printed.

    Returns:
        Shape (2, 2), least and greatest right, up, from the robot's centre [mm].
    """
    corners = np.concatenate([on_paper(part.polygon) for part in tag.parts])
    return np.array([corners.min(axis=0), corners.max(axis=0)])


def arrange(
    tags: tuple[PrintedTag, ...], paper: Paper, colors: int
) -> tuple[tuple[PlacedTag, ...], ...]:
    """Put tags on pages, row by row from the top left.

    Args:
        tags: in reading order.
        paper: to print on.
        colors: number of colours to be listed at the foot of each page.

    Returns:
        For every page its tags.

    Raises:
        ConfigError: if a tag is larger than the paper.
    """
    boxes = np.array([tag_box(printed.tag) for printed in tags])
    low, high = boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)
    cell = high - low + (2.0 * BESIDE, ABOVE + BELOW)
    foot = RULER + COLOR_ROW * -(-colors // COLORS_IN_A_ROW)
    room = np.array([paper.width, paper.height - HEADER - foot]) - 2.0 * MARGIN
    columns, rows = (floor(length) for length in (room + 1e-6) / cell)
    if columns < 1 or rows < 1:
        raise ConfigError(
            f"tags of {high[0] - low[0]:.0f} x {high[1] - low[1]:.0f} mm do not fit on "
            f"{paper.name} paper, which has room for {room[0] - 2 * BESIDE:.0f} x "
            f"{room[1] - ABOVE - BELOW:.0f} mm"
        )
    left = 0.5 * (paper.width - columns * cell[0]) + BESIDE - low[0]
    top = paper.height - MARGIN - HEADER - ABOVE - high[1]
    placed = [
        PlacedTag(printed, left + column * cell[0], top - row * cell[1])
        for printed, (row, column) in zip(tags, _cells(len(tags), rows, columns), strict=True)
    ]
    return tuple(
        tuple(placed[first : first + rows * columns])
        for first in range(0, len(placed), rows * columns)
    )


def _cells(count: int, rows: int, columns: int) -> list[tuple[int, int]]:
    """Row and column of every tag on its page."""
    return [divmod(n % (rows * columns), columns) for n in range(count)]
