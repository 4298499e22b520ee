"""`echelon calibrate camera`: lens and floor from pictures of a board."""

from pathlib import Path
from typing import Annotated

import typer

from pipeline.cli import options


def camera(
    source: Annotated[
        str | None,
        typer.Argument(
            metavar="[SOURCE]",
            help="Views of the board: a folder of images, a video, or a camera (index, "
            "/dev/videoN, URL). Not needed with --lens.",
        ),
    ] = None,
    board: Annotated[
        str,
        typer.Option(
            metavar="BOARD",
            help="charuco:8x5:35:25 (squares, side of a square and of a marker in mm), "
            "chessboard:10x7:25, or a TOML file.",
        ),
    ] = "charuco:8x5:35:25",
    floor: Annotated[
        list[str] | None,
        typer.Option(
            metavar="IMAGE",
            help="The board lying on the floor (image, folder, or camera): the first gives the "
            "floor frame, more at other places make it more exact.",
        ),
    ] = None,
    points: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Instead of --floor: known points (CSV or TOML: x_m, y_m, x_px, y_px, and z_m for "
            "tags on robots).",
        ),
    ] = None,
    lens: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Use the lens of this fragment; only the floor is new."),
    ] = None,
    at: Annotated[
        tuple[float, float],
        typer.Option("--floor-at", metavar="X Y", help="The first board's origin on the floor, m."),
    ] = (0.0, 0.0),
    turn_deg: Annotated[
        float, typer.Option("--floor-turn", metavar="DEG", help="Turn of the first board's x axis.")
    ] = 0.0,
    thickness_mm: Annotated[
        float,
        typer.Option("--board-thickness", metavar="MM", min=0.0, help="Of the board on the floor."),
    ] = 0.0,
    tag_height_mm: Annotated[
        float | None,
        typer.Option("--tag-height", metavar="MM", min=0.0, help="Of the tags above the floor."),
    ] = None,
    views: Annotated[
        int, typer.Option(min=6, max=100, help="Views to choose from a video or camera.")
    ] = 15,
    size: Annotated[
        str | None, typer.Option(metavar="WxH", help="Size of a camera's frames, e.g. 1280x960.")
    ] = None,
    out: Annotated[Path, typer.Option(metavar="FILE", help="The TOML fragment.")] = Path(
        "camera.toml"
    ),
    overlay: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR", help="Write pictures: corners with residuals, coverage, floor grid."
        ),
    ] = None,
    json: options.Json = False,
) -> None:
    """Find lens and floor plane from pictures of a board, and say how well they are known.

    Poor sets are refused, with the reason. A scenario includes the file that is written.
    """
    from pipeline.cli.calibrating_camera import CameraRequest, calibrate_camera
    from pipeline.cli.output import Output

    request = CameraRequest(
        source, board, tuple(floor or ()), points, lens, at, turn_deg, thickness_mm, tag_height_mm,
        views, size, out, overlay,
    )  # fmt: skip
    calibrate_camera(request, Output(json))
