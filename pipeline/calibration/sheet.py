"""A printable board: true scale, with a ruler to check the printer."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pipeline.calibration.board_file import board_text
from pipeline.errors import ConfigError
from vision.calibration.board import Board

PAPERS = {"a4": (297.0, 210.0), "a3": (420.0, 297.0), "a2": (594.0, 420.0), "a1": (841.0, 594.0),
          "letter": (279.4, 215.9), "tabloid": (431.8, 279.4)}  # mm  # fmt: skip
_INCH = 25.4  # mm
_RIM = 8.0  # printers reach no further [mm]
_FOOT = 20.0  # for ruler and words, below the board [mm]
_RULER = 100.0  # mm
_SEAM = 0.03  # outline of every cell, so that viewers show no seams [pt]


def print_board(board: Board, paper: str, out: Path) -> None:
    """Write a board as a PDF page of true scale.

    Args:
        board: to print.
        paper: name of the sheet; it lies across.
        out: file; .pdf, .svg or .png.

    Raises:
        ConfigError: if the board does not fit the sheet, or the file cannot be written.
    """
    if paper not in PAPERS:
        raise ConfigError(f'no paper "{paper}"; there are: {", ".join(PAPERS)}')
    if out.suffix.lower() not in (".pdf", ".svg", ".png"):
        raise ConfigError(f"{out}: need a .pdf, .svg or .png file")
    width, height = PAPERS[paper]
    wide, high = (1e3 * side for side in board.size)
    if wide > width - 2 * _RIM or high > height - _RIM - _FOOT:
        largest = min((width - 2 * _RIM) / board.columns, (height - _RIM - _FOOT) / board.rows)
        raise ConfigError(
            f"a board of {wide:g} x {high:g} mm does not fit {paper} ({width:g} x {height:g} mm "
            f"with its margins); squares of {int(largest)} mm would, or a larger --paper"
        )
    figure, axes = _page(width, height)
    left, bottom = 0.5 * (width - wide), _FOOT + 0.5 * (height - _RIM - _FOOT - high)
    _draw_cells(axes, board, left, bottom)
    _draw_foot(axes, board, left)
    _draw_frame(axes, left, bottom)
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(out, dpi=300 if out.suffix.lower() == ".png" else 72, metadata=_undated(out))
    except OSError as error:
        raise ConfigError(f"{out}: cannot be written ({error.strerror})") from None


def _undated(out: Path) -> dict[str, None]:
    """The same board gives the same file, whenever it is printed."""
    return {"pdf": {"CreationDate": None}, "svg": {"Date": None}}.get(out.suffix.lower()[1:], {})


def _page(width: float, height: float) -> tuple[Any, Any]:
    """A page whose axes count millimetres from its lower left corner."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width / _INCH, height / _INCH))
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_xlim(0.0, width)
    axes.set_ylim(0.0, height)
    axes.axis("off")
    return figure, axes


def _draw_cells(axes: Any, board: Board, left: float, bottom: float) -> None:
    from matplotlib.collections import PolyCollection

    cells = list(1e3 * board.black_cells() + (left, bottom))
    printed = PolyCollection(cells, facecolors="black", edgecolors="black", linewidths=_SEAM)
    printed.set_snap(False)  # true scale, also in pixels
    axes.add_collection(printed)


def _draw_foot(axes: Any, board: Board, left: float) -> None:
    """The ruler, and what the board is called."""
    y = 11.0
    axes.plot([left, left + _RULER], [y, y], color="black", linewidth=0.5)
    for tick in range(0, int(_RULER) + 1, 5):
        length = 3.0 if tick % 10 == 0 else 1.5
        axes.plot([left + tick, left + tick], [y, y + length], color="black", linewidth=0.4)
    _write(axes, left, y - 4.0, f"{_RULER:.0f} mm: measure it; print without scaling (100 %)")
    _write(axes, left + _RULER + 8.0, y + 1.0, f"--board {board_text(board)}")
    words = "origin of the board: lower left corner of the squares; x to the right, y up"
    _write(axes, left + _RULER + 8.0, y - 4.0, words)


def _draw_frame(axes: Any, left: float, bottom: float) -> None:
    """Small arrows at the board's origin, outside of the squares."""
    for dx, dy, name in ((9.0, 0.0, "x"), (0.0, 9.0, "y")):
        start, end = (left - 3.0, bottom - 3.0), (left - 3.0 + dx, bottom - 3.0 + dy)
        arrow = {"arrowstyle": "->", "lw": 0.6, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", xy=end, xytext=start, arrowprops=arrow)
        _write(axes, end[0] + 0.5 * (dx > 0), end[1] + 0.5 * (dy > 0) - 1.0 * (dx > 0), name)


def _write(axes: Any, x: float, y: float, text: str) -> None:
    axes.text(x, y, text, fontsize=7, family="DejaVu Sans")


def largest_square(columns: int, rows: int, paper: str) -> int:
    """The side of the largest squares that a sheet takes.

    Args:
        columns: squares in a row.
        rows: rows of squares.
        paper: name of the sheet.

    Returns:
        Whole millimetres [mm].

    Raises:
        ConfigError: if there is no such sheet.
    """
    if paper not in PAPERS:
        raise ConfigError(f'no paper "{paper}"; there are: {", ".join(PAPERS)}')
    width, height = PAPERS[paper]
    return int(min((width - 2 * _RIM) / columns, (height - _RIM - _FOOT) / rows))


def paper_names() -> Sequence[str]:
    """The sheets that can be printed on.

    Returns:
        Their names.
    """
    return tuple(PAPERS)
