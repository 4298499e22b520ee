"""`echelon calibrate colors`: the palette, from a few frames of the running scene."""

from pathlib import Path
from typing import Annotated

import typer

from pipeline.cli import options


def colors(
    sources: Annotated[
        list[str],
        typer.Argument(
            metavar="SOURCE... [SCENARIO]",
            help="Images, a folder, a video, a session (.mcap) or a camera SPEC; then the scenario "
            "whose tags are in them (default: paper, or the session's own).",
        ),
    ],
    out: Annotated[
        Path, typer.Option(metavar="FILE", help="The TOML fragment; pictures are put beside it.")
    ] = Path("colors.toml"),
    frames: Annotated[
        int, typer.Option(min=1, max=100, help="Frames to use of a folder, video or camera.")
    ] = 5,
    overrides: options.Overrides = None,
    json: options.Json = False,
) -> None:
    """Learn the palette from a few frames of the running scene; nobody has to click.

    Robots may stand anywhere. Their tags are found by their geometry alone, then named.
    """
    from pipeline.cli.calibrating_colors import calibrate_colors
    from pipeline.cli.output import Output

    calibrate_colors(sources, out, frames, tuple(overrides or ()), Output(json))
