"""`echelon check`: what holds in a scenario, with numbers, before anything moves."""

import typer

from pipeline.cli import options


def check(
    scenario: options.ScenarioName = "paper",
    overrides: options.Overrides = None,
    json: options.Json = False,
) -> None:
    """Check what holds in a scenario, with numbers.

    Gains, shape, path, tags, colours, camera, radio budget, safety times.

    Exit status 2 if something does not hold.
    """
    from pipeline.checks import check_scenario
    from pipeline.cli.output import Output
    from pipeline.scenario import load_scenario

    findings = check_scenario(load_scenario(scenario, tuple(overrides or ())))
    Output(json).findings(scenario, findings)
    raise typer.Exit(0 if all(f.holds or not f.binding for f in findings) else 2)
