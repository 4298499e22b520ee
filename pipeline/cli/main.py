"""The `echelon` command: dispatch, and errors as one clear line with the contract's exit status."""

import sys
import traceback
from importlib.metadata import version
from typing import Annotated

import typer

from control.errors import EchelonError
from pipeline.cli import (
    calibrate,
    cameras,
    check,
    doctor,
    live,
    locate,
    render,
    replay,
    report,
    simulate,
    study,
    tags,
)
from pipeline.errors import CameraError, RadioError, SafetyStop

app = typer.Typer(
    name="echelon",
    rich_markup_mode=None,  # plain help answers in half the time
    pretty_exceptions_enable=False,
    add_completion=False,
    no_args_is_help=True,
    epilog="Start with: echelon live. Exit status: 0 done; 2 wrong use or configuration; "
    "3 a device failed; 4 a safety stop ended the run; 5 recorded and recomputed results differ; "
    "130 interrupted.",
)


def _say_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"echelon {version('echelon-formation')}")
        raise typer.Exit


@app.callback()
def general(
    version: Annotated[
        bool,
        typer.Option(
            "--version", help="Say which version this is.", callback=_say_version, is_eager=True
        ),
    ] = False,
    debug: Annotated[bool, typer.Option("--debug", help="Show a traceback with an error.")] = False,
) -> None:
    """From an overhead camera's frames to the commands of a formation of small robots."""
    del version, debug  # one has its callback, the other is taken before arguments are parsed


for command in (
    live,
    replay,
    simulate,
    render,
    locate,
    report,
    check,
    doctor,
    cameras,
    study,
    tags,
):
    app.command()(getattr(command, command.__name__.rsplit(".", 1)[-1]))
app.add_typer(calibrate.calibrate)

USAGE, DEVICE, STOPPED = 2, 3, 4


def main() -> None:
    """Run the command line and exit with the contract's status."""
    debug = "--debug" in sys.argv
    sys.argv = [argument for argument in sys.argv if argument != "--debug"]
    try:
        app()
    except EchelonError as error:
        if debug:
            traceback.print_exc()
        line = " ".join(str(error).split())
        print(f"echelon: {line}", file=sys.stderr)  # noqa: T201 (the one line a user reads)
        sys.exit(_status(error))


def _status(error: EchelonError) -> int:
    if isinstance(error, SafetyStop):
        return STOPPED
    return DEVICE if isinstance(error, CameraError | RadioError) else USAGE
