"""`echelon render`: frames with truth, as a video or as pictures."""

from pathlib import Path
from typing import Annotated

import typer

from pipeline.cli import options


def render(
    scenario: options.ScenarioName = "paper",
    out: Annotated[
        Path, typer.Option(metavar="FILE|DIR", help="A lossless video (.mkv, .mp4) or a folder.")
    ] = Path("frames"),
    duration: Annotated[
        float | None, typer.Option(metavar="S", min=0.0, help="Default: the scenario's.")
    ] = None,
    seed: options.Seed = 0,
    overrides: options.Overrides = None,
) -> None:
    """Render a run: the frames, and the truth beside them.

    The robots drive under control, as in `echelon live --fast`. A folder gets PNG files and
    truth.json with the true poses; a video gets FILE.truth.json beside it.
    """
    from pipeline.cli.rendering import render_run

    render_run(scenario, tuple(overrides or ()), out, duration, seed)
