"""`echelon calibrate`: what a scenario includes, learned by looking; one file a sub-command."""

import typer

from pipeline.cli.calibrate_board import board
from pipeline.cli.calibrate_camera import camera
from pipeline.cli.calibrate_colors import colors
from pipeline.cli.calibrate_robots import robots

calibrate = typer.Typer(
    name="calibrate",
    help="Learn camera, colours and robots by looking; writes a TOML fragment.",
    no_args_is_help=True,
    rich_markup_mode=None,
)
for command in (camera, board, colors, robots):
    calibrate.command()(command)
