"""The printable sheet: tags in true scale, cut marks, names, colours, and a ruler to check it."""

from collections.abc import Sequence
from dataclasses import dataclass
from io import BytesIO
from typing import TYPE_CHECKING

import numpy as np

from pipeline.sheets.arrange import (
    ABOVE,
    COLOR_ROW,
    COLORS_IN_A_ROW,
    MARGIN,
    RULER,
    Paper,
    PlacedTag,
    on_paper,
    tag_box,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Segment = tuple[tuple[float, float], tuple[float, float]]

MM_PER_INCH = 25.4
POINTS_PER_MM = 72.0 / MM_PER_INCH
RULER_LENGTH = 100  # [mm]
_LINE = 0.15  # width of all lines [mm]
_MARK_GAP, _MARK = 0.8, 2.0  # between a tag and its cut marks, and their length [mm]
_TEXT, _SMALL = 3.0, 2.0  # height of letters [mm]
_ADVICE = 'print at 100 %, not "fit to page"; this ruler must measure 100 mm'


@dataclass(frozen=True, slots=True)
class Sheet:
    """All that is printed.

    Attributes:
        title: at the head of every page.
        paper: to print on.
        pages: for every page its tags.
        colors: pairs of a name and "#rrggbb", of all colours the tags use.
    """

    title: str
    paper: Paper
    pages: tuple[tuple[PlacedTag, ...], ...]
    colors: tuple[tuple[str, str], ...]


def ruler_start(paper: Paper) -> tuple[float, float]:
    """Where the ruler's zero is.

    Args:
        paper: to print on.

    Returns:
        From the left and the lower edge [mm].
    """
    del paper  # at the foot of any
    return MARGIN + 2.0, MARGIN + 2.0


def sheet_pdf(sheet: Sheet) -> bytes:
    """Draw a sheet.

    Args:
        sheet: what to print.

    Returns:
        The PDF file; the same sheet gives the same bytes.
    """
    from matplotlib.backends.backend_pdf import PdfPages

    file = BytesIO()
    facts = {"CreationDate": None, "Title": sheet.title}
    with PdfPages(file, metadata=facts) as pdf:
        for number in range(len(sheet.pages)):
            pdf.savefig(_page(sheet, number))
    return file.getvalue()


def _page(sheet: Sheet, number: int) -> "Figure":
    """One page; its coordinates are millimetres from the lower left corner of the paper."""
    from matplotlib.figure import Figure

    paper = sheet.paper
    figure = Figure((paper.width / MM_PER_INCH, paper.height / MM_PER_INCH))
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set(xlim=(0.0, paper.width), ylim=(0.0, paper.height))
    axes.axis("off")
    title = f"{sheet.title}, page {number + 1} of {len(sheet.pages)}"
    _write(axes, MARGIN, paper.height - MARGIN - _TEXT, title, _TEXT)
    for placed in sheet.pages[number]:
        _draw_tag(axes, placed, dict(sheet.colors))
    _draw_colors(axes, sheet.colors)
    _draw_ruler(axes, *ruler_start(paper))
    return figure


def _draw_tag(axes: "Axes", placed: PlacedTag, colors: dict[str, str]) -> None:
    """The parts, bottom to top; cut marks, name and the way forward outside."""
    from matplotlib.patches import Polygon

    center = np.array((placed.x, placed.y))
    for part in placed.printed.tag.parts:
        corners = on_paper(part.polygon) + center
        axes.add_patch(Polygon(corners, facecolor=colors[part.color], linewidth=0.0))
    (x0, y0), (x1, y1) = tag_box(placed.printed.tag) + center
    near, far = _MARK_GAP, _MARK_GAP + _MARK
    for x, way in ((x0, -1.0), (x1, 1.0)):
        for y, up in ((y0, -1.0), (y1, 1.0)):
            upright = ((x, y + up * near), (x, y + up * far))
            _lines(axes, (upright, ((x + way * near, y), (x + way * far, y))))
    base = y1 + 1.0
    tip = np.array([[placed.x - 1.5, base], [placed.x + 1.5, base], [placed.x, y1 + 0.8 * ABOVE]])
    axes.add_patch(Polygon(tip, facecolor="black", linewidth=0.0))
    _write(axes, placed.x + 2.5, base + 0.5, "front", _SMALL)
    _write(axes, x0 + 1.5, base + 0.5, placed.printed.label, _TEXT)


def _draw_colors(axes: "Axes", colors: tuple[tuple[str, str], ...]) -> None:
    """Swatches with names and numbers, above the ruler."""
    from matplotlib.patches import Rectangle

    width = (axes.get_xlim()[1] - 2.0 * MARGIN) / COLORS_IN_A_ROW
    for n, (name, code) in enumerate(colors):
        row, column = divmod(n, COLORS_IN_A_ROW)
        x, y = MARGIN + column * width, MARGIN + RULER + row * COLOR_ROW + 0.5
        axes.add_patch(
            Rectangle((x, y), 4.0, 2.5, facecolor=code, edgecolor="black", linewidth=_LINE)
        )
        _write(axes, x + 5.0, y + 0.3, f"{name} {code}", _SMALL)


def _draw_ruler(axes: "Axes", x: float, y: float) -> None:
    """100 mm with a mark every millimetre."""
    heights = [3.5 if n % 10 == 0 else 2.5 if n % 5 == 0 else 1.5 for n in range(RULER_LENGTH + 1)]
    marks = [((x + mm, y), (x + mm, y + height)) for mm, height in enumerate(heights)]
    _lines(axes, [((x, y), (x + RULER_LENGTH, y)), *marks])
    for mm in range(0, RULER_LENGTH + 1, 10):
        _write(axes, x + mm, y + 4.0, f"{mm}", _SMALL, "center")
    _write(axes, x + RULER_LENGTH + 5.0, y + 0.5, _ADVICE, _SMALL)


def _lines(axes: "Axes", segments: Sequence[Segment]) -> None:
    from matplotlib.collections import LineCollection

    axes.add_collection(
        LineCollection(segments, colors="black", linewidths=_LINE * POINTS_PER_MM), autolim=False
    )


def _write(axes: "Axes", x: float, y: float, text: str, height: float, align: str = "left") -> None:
    axes.text(x, y, text, fontsize=height * POINTS_PER_MM, ha=align, va="baseline")
