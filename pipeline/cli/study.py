"""`echelon study`: one question about the laws, answered by a figure and a table."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pipeline.cli import options

if TYPE_CHECKING:
    from pipeline.cli.output import Output
    from pipeline.studies.study import Result, Study


def study(
    name: Annotated[
        str | None, typer.Argument(metavar="[NAME]", help="Of a study; none: list all.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder for NAME.png and NAME.csv.")
    ] = None,
    json: options.Json = False,
) -> None:
    """Answer a question about the laws by a figure and a table.

    Without NAME: list the studies with a line each. No camera and no robots take part.
    """
    from pipeline.cli.output import Output
    from pipeline.errors import ConfigError
    from pipeline.interruption import interruption
    from pipeline.studies.all import STUDIES, study_named
    from pipeline.studies.files import make_folder, write_result

    output = Output(json)
    if name is None:
        _list(STUDIES, output)
        return
    asked = study_named(name)
    if out is None:
        raise ConfigError(f"study {name}: needs --out DIR, a folder for {name}.png and {name}.csv")
    with interruption() as interrupted:  # before the folder: who sees it may press Ctrl-C
        make_folder(out)
        result = _run(asked, interrupted)
    picture, table = write_result(result, name, out)
    if json:
        files = {"figure": str(picture), "table": str(table)}
        output.object({"study": name, "columns": result.header, "rows": result.rows} | files)
        return
    output.say(f"figure: {picture}")
    output.say(f"table: {table} ({len(result.rows)} rows)")


def _list(studies: "tuple[Study, ...]", output: "Output") -> None:
    """Names and summaries."""
    if output.as_json:
        output.object({"studies": {study.name: study.summary for study in studies}})
        return
    width = max(len(study.name) for study in studies)
    for study in studies:
        output.say(f"{study.name:<{width}}  {study.summary}")


def _run(study: "Study", interrupted: Callable[[], bool]) -> "Result":
    """The result, with a line that says how far it is; Ctrl-C ends it with status 130."""
    from pipeline.cli.running import INTERRUPTED
    from pipeline.progress import ShareLine

    line = ShareLine(study.name)

    def _progress(share: float) -> None:
        line.show(share)
        if interrupted():
            raise typer.Exit(INTERRUPTED)

    try:
        return study.run(_progress)
    finally:
        line.close()
