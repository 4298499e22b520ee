"""A board as the user writes it: a short text on the command line, or a TOML file."""

import re
import tomllib
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from pipeline.errors import ConfigError
from pipeline.section import Positive, Section
from vision.calibration.board import Board, Kind
from vision.errors import VisionError

DEFAULT_BOARD = "charuco:8x5:35:25"
_SPEC = re.compile(
    r"(?P<kind>charuco|chessboard):(?P<columns>\d+)x(?P<rows>\d+):(?P<square>[\d.]+)"
    r"(?::(?P<marker>[\d.]+))?(?::(?P<dictionary>\d+x\d+_\d+))?(?P<legacy>:legacy)?"
)


class BoardConfig(Section):
    """A board's description in a TOML file."""

    kind: Kind = "charuco"
    columns: int
    rows: int
    square_mm: Positive
    marker_mm: Positive | None = None
    dictionary: str = "4x4_100"
    legacy: bool = False


def read_board(text: str) -> Board:
    """The board that an option names.

    Args:
        text: "charuco:8x5:35:25" (squares, side of a square and of a marker in millimetres, and
            perhaps ":5x5_100", ":legacy"), "chessboard:10x7:25", or a TOML file with the keys of
            `BoardConfig`.

    Returns:
        The board.

    Raises:
        ConfigError: if the text is neither, or there can be no such board.
    """
    try:
        config = BoardConfig.model_validate(_table(text))
    except ValidationError as error:
        first = error.errors()[0]
        raise ConfigError(
            f"board {text}: {'.'.join(map(str, first['loc']))}: {first['msg']}"
        ) from None
    marker = config.marker_mm if config.marker_mm is not None else 0.72 * config.square_mm
    try:
        return Board(
            config.kind, config.columns, config.rows, 1e-3 * config.square_mm, 1e-3 * marker,
            config.dictionary, config.legacy,
        )  # fmt: skip
    except VisionError as error:
        raise ConfigError(f"board {text}: {error}") from None


def board_text(board: Board) -> str:
    """The text that names a board.

    Args:
        board: any.

    Returns:
        What `read_board` takes.
    """
    text = f"{board.kind}:{board.columns}x{board.rows}:{1e3 * board.square:g}"
    if board.kind == "charuco":
        text += f":{1e3 * board.marker:g}:{board.dictionary}" + ":legacy" * board.legacy
    return text


def _table(text: str) -> dict[str, Any]:
    """The keys of a description."""
    if text.endswith(".toml"):
        try:
            return tomllib.loads(Path(text).read_text(encoding="utf-8"))
        except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
            raise ConfigError(f"board {text}: cannot be read: {error}") from None
    found = _SPEC.fullmatch(text)
    if found is None:
        raise ConfigError(
            f'board {text}: need "charuco:8x5:35:25" (squares, side of a square and of a marker in '
            'mm), "chessboard:10x7:25" or a TOML file'
        )
    names = {"square": "square_mm", "marker": "marker_mm"}
    given = {names.get(k, k): v for k, v in found.groupdict().items() if v}
    return {**given, "legacy": "legacy" in given}
