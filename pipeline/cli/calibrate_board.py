"""`echelon calibrate board`: a board to print."""

from pathlib import Path
from typing import Annotated

import typer


def board(
    out: Annotated[Path, typer.Option(metavar="FILE", help="The page: .pdf, .svg or .png.")] = Path(
        "board.pdf"
    ),
    board: Annotated[
        str | None,
        typer.Option(
            metavar="BOARD",
            help="charuco:8x5:35:25 (squares, side of a square and of a marker in mm), "
            "chessboard:10x7:25, or a TOML file; by default the largest that fits the paper.",
        ),
    ] = None,
    paper: Annotated[str, typer.Option(help="a4, a3, a2, a1, letter or tabloid.")] = "a4",
) -> None:
    """Print a calibration board in true scale, with a ruler to check the printer."""
    from pipeline.calibration.board_file import board_text, read_board
    from pipeline.calibration.sheet import largest_square, print_board
    from pipeline.cli.output import Output

    square = largest_square(8, 5, paper)
    printed = read_board(board or f"charuco:8x5:{square}:{round(0.72 * square)}")
    print_board(printed, paper, out)
    Output(False).say(f"{out}: print it in true size, glue it onto something flat, then "
                      f"calibrate with --board {board_text(printed)}")  # fmt: skip
