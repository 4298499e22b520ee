"""`echelon tags`: the robots' tags on paper."""

from pathlib import Path
from typing import Annotated

import typer

from pipeline.cli import options


def tags(
    what: Annotated[
        str, typer.Argument(metavar="LAYOUT|SCENARIO", help="All of a layout, or of a scenario.")
    ],
    out: Annotated[Path, typer.Option(metavar="FILE", help="The PDF.")] = Path("tags.pdf"),
    paper: Annotated[str, typer.Option(metavar="a4|letter", help="Size of the paper.")] = "a4",
    overrides: options.Overrides = None,
) -> None:
    """Print tags: true scale, cut marks, and a ruler that checks the printer.

    Of a shipped layout every pattern is printed; of a scenario exactly its robots' tags. The team's
    colour of a layout: --set tags.colors.team=blue.
    """
    from pipeline.cli.tagging import print_tags

    print_tags(what, tuple(overrides or ()), paper, out)
