"""`echelon simulate`: control without a camera, many runs at once."""

from typing import Annotated

import typer

from pipeline.cli import options


def simulate(
    scenario: options.ScenarioName = "paper",
    runs: Annotated[
        int, typer.Option(metavar="N", min=1, help="Runs of each point, with seeds in a row.")
    ] = 1,
    sweep: Annotated[
        list[str] | None,
        typer.Option(
            metavar="KEY=A,B,C",
            help="Take several values of a key; more than one --sweep: all combinations.",
        ),
    ] = None,
    seed: options.Seed = 0,
    overrides: options.Overrides = None,
    duration: Annotated[
        float | None,
        typer.Option(metavar="S", min=0.001, help="End every run after this many seconds."),
    ] = None,
    trajectory: options.Trajectory = None,
    json: options.Json = False,
) -> None:
    """Run a formation without pictures: poses with errors in, commands out.

    One run is told as `live` tells it; several, or a sweep, as a table of median and worst. The
    first use compiles for about half a minute.
    """
    from pipeline.cli.output import Output  # heavy rooms are entered only when needed
    from pipeline.cli.simulating import Request, run_simulate

    request = Request(
        scenario, runs, tuple(sweep or ()), seed, tuple(overrides or ()), duration, trajectory
    )
    run_simulate(request, Output(json))
