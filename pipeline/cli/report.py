"""`echelon report`: figures and a page from a session."""

from pathlib import Path
from typing import Annotated

import typer


def report(
    session: Annotated[Path, typer.Argument(metavar="SESSION", help="A recorded .mcap file.")],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the PNGs and report.html.")],
) -> None:
    """Draw a session: figures and one HTML page.

    Figures 6 to 9 of the paper as PNGs, the computing times, and a self-contained report.html.
    """
    from pipeline.cli.reporting import write_report

    page = write_report(session, out)
    typer.echo(f"report: {page}")
