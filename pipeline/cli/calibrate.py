"""`echelon calibrate`: what a scenario includes, learned from pictures; one file a sub-command."""

import typer

from pipeline.cli import later
from pipeline.cli.calibrate_colors import colors

calibrate = typer.Typer(
    name="calibrate",
    help="Learn colours, camera and robots from pictures; writes a TOML fragment.",
    no_args_is_help=True,
    rich_markup_mode=None,
)
calibrate.command()(colors)
later.register(calibrate, later.CALIBRATE)
