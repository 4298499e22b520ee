"""`echelon check`: what holds in a scenario, with numbers, before anything moves."""

from pathlib import Path
from typing import Annotated

import typer

from pipeline.cli import options


def check(
    scenario: options.ScenarioName = "paper",
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Write omega.png: where errors stay, and their paths."),
    ] = None,
    session: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="A recorded .mcap file whose path omega.png shows too."),
    ] = None,
    overrides: options.Overrides = None,
    json: options.Json = False,
) -> None:
    """Check what holds in a scenario, with numbers.

    Gains and what they guarantee, shape, path, tags, colours, camera, radio budget, safety times.

    Exit status 2 if something does not hold; what is not guaranteed is told ("open").
    """
    from pipeline.checks import check_scenario
    from pipeline.cli.output import Output
    from pipeline.errors import ConfigError
    from pipeline.scenario import load_scenario

    if session is not None and out is None:
        raise ConfigError("--session is drawn into omega.png: say where with --out DIR")
    checked, output = load_scenario(scenario, tuple(overrides or ())), Output(json)
    findings = check_scenario(checked)
    output.findings(scenario, findings)
    if out is not None:
        from pipeline.cli.checking import write_omega

        output.say(f"picture: {write_omega(checked, out, session)}")
    raise typer.Exit(0 if all(f.holds or not f.binding for f in findings) else 2)
