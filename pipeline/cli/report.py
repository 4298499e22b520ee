"""`echelon report`: figures and a page from a session."""

from pathlib import Path
from typing import Annotated

import typer


def report(
    session: Annotated[Path, typer.Argument(metavar="SESSION", help="A recorded .mcap file.")],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the PNGs and report.html.")],
) -> None:
    """Draw the paper's figures 6 to 9 from a session, and one self-contained HTML page."""
    from pipeline.cli.reporting import write_report

    page = write_report(session, out)
    typer.echo(f"report: {page}")
