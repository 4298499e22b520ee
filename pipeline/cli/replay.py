"""`echelon replay`: recorded inputs through the same step."""

from pathlib import Path
from typing import Annotated

import typer

from pipeline.cli import options


def replay(
    source: Annotated[
        Path, typer.Argument(metavar="SOURCE", help="A session (.mcap), a video, or a folder.")
    ],
    scenario: Annotated[
        str | None,
        typer.Argument(metavar="[SCENARIO]", help="Default: the session's own; paper for footage."),
    ] = None,
    compare: Annotated[
        bool,
        typer.Option(
            "--compare", help="Exit 5 unless every recomputed command equals the recorded."
        ),
    ] = False,
    fps: Annotated[
        float | None,
        typer.Option(
            metavar="FPS", min=0.1, help="Frame rate. Default: a video's own times; 30 for folders."
        ),
    ] = None,
    record: options.Record = None,
    view: options.View = "none",
    report: options.ReportFolder = None,
    trajectory: options.Trajectory = None,
    publish: options.Publish = None,
    overrides: options.Overrides = None,
    json: options.Json = False,
) -> None:
    """Replay a session, a video or a folder of images.

    A session is recomputed tick by tick from its recorded inputs; a video or a folder is looked at
    frame by frame and gives poses, relative states and the commands that would have been sent.
    """
    from datasets.recorded import is_session
    from pipeline.cli.output import Output
    from pipeline.cli.replaying import replay_footage, replay_session
    from pipeline.cli.running import Outputs

    outputs, output = Outputs(record, view, report, trajectory, publish), Output(json)
    changes = tuple(overrides or ())
    if is_session(source):
        replay_session(source, scenario, changes, compare, outputs, output)
    else:
        replay_footage(source, scenario or "paper", changes, fps, outputs, output)
