"""`echelon calibrate`: what a scenario includes, learned from pictures; one file a sub-command."""

import typer

from pipeline.cli import later
from pipeline.cli.calibrate_board import board
from pipeline.cli.calibrate_camera import camera
from pipeline.cli.calibrate_colors import colors

calibrate = typer.Typer(
    name="calibrate",
    help="Learn colours, camera and robots from pictures; writes a TOML fragment.",
    no_args_is_help=True,
    rich_markup_mode=None,
)
for command in (camera, board, colors):
    calibrate.command()(command)
later.register(calibrate, later.CALIBRATE)
