"""Options that several commands share, each written once."""

from pathlib import Path
from typing import Annotated

import typer

ScenarioName = Annotated[
    str, typer.Argument(metavar="[SCENARIO]", help="Name of a shipped scenario, or a TOML file.")
]
Json = Annotated[
    bool, typer.Option("--json", help="Print one JSON object on stdout and nothing else there.")
]
Overrides = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Override a key of the scenario, e.g. camera.fps=60 or robots.2.lag_s=0.07.",
    ),
]
Seed = Annotated[
    int, typer.Option("--seed", min=0, help="Seed of everything random in the rendered world.")
]
CommandPeriod = Annotated[
    float | None,
    typer.Option(
        "--command-period", metavar="S", min=0.001, max=1.0, help="Seconds between commands."
    ),
]
Camera = Annotated[
    str, typer.Option(metavar="SPEC", help="rendered, an index, /dev/videoN, a URL, or a file.")
]
Radio = Annotated[
    str | None,
    typer.Option(
        metavar="SPEC",
        help="simulated, none, miabot:ID=PORT,..., miabot-tcp:ID=HOST:PORT,..., "
        "miabot-tcp-listen:HOST:PORT, vsss:PORT, or firasim:HOST:PORT. "
        "Default: simulated with the rendered camera, none with any other.",
    ),
]
Record = Annotated[
    Path | None,
    typer.Option("--record", metavar="FILE", help="Record the session (.mcap): replay it later."),
]
ReportFolder = Annotated[
    Path | None,
    typer.Option("--report", metavar="DIR", help="Write the figures and report.html at the end."),
]
Trajectory = Annotated[
    Path | None,
    typer.Option("--trajectory", metavar="FILE", help="Write a CSV: states, commands, errors."),
]
Publish = Annotated[
    str | None,
    typer.Option(
        "--publish",
        metavar="SPEC",
        help="Send detections to other programs: ssl-vision (multicast) or ssl-vision:HOST:PORT.",
    ),
]
View = Annotated[
    str,
    typer.Option("--view", metavar="none|rerun|FILE.rrd", help="Watch live, or keep the view."),
]
