"""`echelon live`: the loop, from a camera's frames to the robots' commands."""

from typing import Annotated

import typer

from pipeline.cli import options
from pipeline.interruption import ARM, HALT, noted


def live(
    scenario: options.ScenarioName = "paper",
    camera: options.Camera = "rendered",
    radio: options.Radio = None,
    duration: Annotated[
        float | None,
        typer.Option(metavar="S", min=0.0, help="End after this many seconds."),
    ] = None,
    fast: Annotated[
        bool, typer.Option("--fast", help="As fast as it goes (rendered camera only).")
    ] = False,
    hold: Annotated[
        bool, typer.Option("--hold", help="Begin, and resume after a stop, only when r is pressed.")
    ] = False,
    seed: options.Seed = 0,
    record: options.Record = None,
    view: options.View = "none",
    report: options.ReportFolder = None,
    trajectory: options.Trajectory = None,
    publish: options.Publish = None,
    command_period: options.CommandPeriod = None,
    overrides: options.Overrides = None,
    json: options.Json = False,
) -> None:
    """Run a formation: frames in, commands out.

    Without options: the paper's experiment, with rendered frames and simulated robots, in real
    time. Ctrl-C stops every robot and closes the recording readable. In a terminal space is an
    emergency stop, r arms again, c tells how the loop keeps its time; SIGUSR1 and SIGUSR2 stop and
    arm from elsewhere.
    """
    with noted((HALT, ARM)) as came:
        from pipeline.cli.output import Output  # heavy rooms are entered only when needed
        from pipeline.cli.running import Outputs, Request, run_live
        from pipeline.operators.signals import Signals

        held = ("safety.hold=true",) if hold else ()
        changes = (*(overrides or ()), *held)
        request = Request(scenario, camera, radio, duration, fast, seed, command_period, changes)
        outputs = Outputs(record, view, report, trajectory, publish)
        run_live(request, outputs, Output(json), Signals(came))
