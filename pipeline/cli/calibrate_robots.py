"""`echelon calibrate robots`: how each robot drives, and which radio is whose, by moving them."""

from pathlib import Path
from typing import Annotated

import typer

from pipeline.cli import options


def robots(
    scenario: options.ScenarioName = "paper",
    camera: options.Camera = "rendered",
    radio: options.Radio = None,
    out: Annotated[Path, typer.Option(metavar="FILE", help="The TOML fragment.")] = Path(
        "robots.toml"
    ),
    plan: Annotated[
        bool, typer.Option("--plan", help="Only look, and say what would be done; moves nobody.")
    ] = False,
    fast: Annotated[
        bool, typer.Option("--fast", help="As fast as it goes (rendered camera only).")
    ] = False,
    seed: options.Seed = 0,
    overrides: options.Overrides = None,
    json: options.Json = False,
) -> None:
    """Move every robot a little: which radio is whose, speed scale, track width, lag, latency.

    Needs safety.arena_m, a calibrated floor, and about 0.2 m of clear floor around each robot.
    First every radio's robot turns in place, then every robot drives for some seconds; one at a
    time. Ctrl-C stops every robot.
    """
    from pipeline.cli.calibrating_robots import RobotsRequest, calibrate_robots, plan_robots
    from pipeline.cli.output import Output

    request = RobotsRequest(scenario, camera, radio, fast, seed, tuple(overrides or ()))
    if plan:
        plan_robots(request, Output(json))
    else:
        calibrate_robots(request, out, Output(json))
