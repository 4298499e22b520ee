"""`echelon locate`: the robots in single images."""

from pathlib import Path
from typing import Annotated

import typer

from pipeline.cli import options


def locate(
    images: Annotated[
        list[Path], typer.Argument(metavar="IMAGE...", help="Image files, or folders of images.")
    ],
    setup: Annotated[
        str, typer.Option(metavar="FILE", help="Scenario: camera, tags and colours.")
    ] = "paper",
    overlay: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Write each image with outlines and rejected candidates."),
    ] = None,
    overrides: options.Overrides = None,
    json: options.Json = False,
) -> None:
    """Find the robots in images.

    Also says of every candidate that was not accepted why not, with the numbers that decided.
    """
    from pipeline.cli.locating import locate_images
    from pipeline.cli.output import Output

    locate_images(images, setup, tuple(overrides or ()), overlay, Output(json))
