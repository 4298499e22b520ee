"""What `echelon calibrate camera` does: pictures in, a fragment and a report out."""

from dataclasses import dataclass
from math import radians
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pipeline.calibration.board_file import board_text, read_board
from pipeline.calibration.fragment import read_lens, write_fragment
from pipeline.calibration.overlay import draw_corners, draw_coverage, draw_floor, magnification
from pipeline.calibration.pictures import Gathered, gather_floor, gather_views
from pipeline.calibration.point_file import read_points
from pipeline.calibration.telling import to_json, told
from pipeline.cli.output import Output
from pipeline.errors import ConfigError
from pipeline.interruption import interruption
from pipeline.viewers.overlay import write_picture
from vision.calibration.board import Board
from vision.calibration.camera import calibrate_floor, calibrate_lens, with_points
from vision.calibration.detect import BoardView
from vision.calibration.floor import FloorFrame
from vision.calibration.result import Calibration, given_lens
from vision.errors import VisionError

Image = NDArray[np.uint8]

DEFAULT_TAG_HEIGHT = 0.075  # at which errors are told where no height is given [m]


@dataclass(frozen=True, slots=True)
class CameraRequest:
    """What the user asked for.

    Attributes:
        source: views of the board, None with a given lens.
        board: text or file.
        floor: pictures of the board on the floor.
        points: file of known points.
        lens: fragment whose lens is used.
        at: origin of the first board on the floor [m].
        turn_deg: of the first board [deg].
        thickness_mm: of the board on the floor [mm].
        tag_height_mm: of the tags, None: not given [mm].
        views: to choose from a stream.
        size: "WxH" of a camera's frames, None: its own.
        out: fragment to write.
        overlay: folder for pictures, None for none.
    """

    source: str | None
    board: str
    floor: tuple[str, ...]
    points: Path | None
    lens: Path | None
    at: tuple[float, float]
    turn_deg: float
    thickness_mm: float
    tag_height_mm: float | None
    views: int
    size: str | None
    out: Path
    overlay: Path | None


def calibrate_camera(request: CameraRequest, output: Output) -> None:
    """Calibrate, refuse or report, and write the fragment.

    Args:
        request: what was asked for.
        output: where to say it.

    Raises:
        ConfigError: if options contradict each other or a file is wrong.
        VisionError: if the pictures or points do not give a camera, with all reasons.
        RecordingError: if a source cannot be read.
        CameraError: if a camera cannot be opened.
    """
    _check(request)
    board = read_board(request.board)
    held, laid = _gather(request, board)
    for line in (*held.unused, *laid.unused):
        output.say(f"not used: {line}")
    height = DEFAULT_TAG_HEIGHT if request.tag_height_mm is None else 1e-3 * request.tag_height_mm
    try:
        calibration = _calibrate(request, board, held, laid)
        calibration.check_floor(height)
    except VisionError as error:
        raise VisionError(f"refused: {error}") from None
    given = None if request.tag_height_mm is None else height
    notes = told(calibration, height)
    origin = f"Written by: echelon calibrate camera --board {board_text(board)}"
    write_fragment(request.out, calibration, given, (origin, *notes))
    if request.overlay is not None:
        _draw(calibration, {**held.images, **laid.images}, request.overlay, height)
    if output.as_json:
        unused = (*held.unused, *laid.unused, *calibration.left_out)
        output.object({"file": str(request.out), **to_json(calibration, height), "unused": unused})
        return
    for line in (*calibration.left_out, *notes, f"written: {request.out}"):
        output.say(line)


def _check(request: CameraRequest) -> None:
    """Refuse options that contradict each other."""
    numbers = (*request.at, request.turn_deg, request.thickness_mm, request.tag_height_mm or 0.0)
    if not np.isfinite(numbers).all():
        raise ConfigError(f"calibrate camera: numbers must be finite, got {numbers}")
    if request.source is None and request.lens is None:
        raise ConfigError("calibrate camera: need a SOURCE of views, or --lens with a known lens")
    if request.source is not None and request.lens is not None:
        raise ConfigError("calibrate camera: SOURCE gives a lens, and so does --lens; name one")
    if request.floor and request.points is not None:
        raise ConfigError("calibrate camera: --floor and --points both give the floor; name one")
    if request.lens is not None and not request.floor and request.points is None:
        raise ConfigError("calibrate camera: with --lens, name --floor or --points")


def _gather(request: CameraRequest, board: Board) -> tuple[Gathered, Gathered]:
    """Views in the hands and on the floor."""
    size = _size(request.size)
    with interruption() as interrupted:
        held = Gathered()
        if request.source is not None:
            held = gather_views(request.source, board, request.views, size, interrupted)
        laid = gather_floor(request.floor, board, size, interrupted)
    return held, laid


def _size(text: str | None) -> tuple[int, int] | None:
    """A size such as 1280x960."""
    if text is None:
        return None
    width, cross, height = text.partition("x")
    if not (cross and width.isdecimal() and height.isdecimal()):
        raise ConfigError(f"--size {text}: need WIDTHxHEIGHT, e.g. 1280x960")
    return int(width), int(height)


def _calibrate(request: CameraRequest, board: Board, held: Gathered, laid: Gathered) -> Calibration:
    """Lens and floor from what there is."""
    at, thickness = request.at, 1e-3 * request.thickness_mm
    frame = FloorFrame(*at, radians(request.turn_deg), thickness)
    if request.lens is None:
        _same_size((*held.views, *laid.views))
        calibration = calibrate_lens(board, held.views, laid.views, frame)
    else:
        lens, size = read_lens(request.lens)
        if laid.views and laid.views[0].size_px != size:
            raise ConfigError(
                f"{request.lens}: the lens is for {size[0]} x {size[1]} px, the floor's picture "
                f"has {laid.views[0].size_px[0]} x {laid.views[0].size_px[1]} px"
            )
        calibration = given_lens(lens, size)
        if laid.views:
            calibration = calibrate_floor(board, lens, laid.views, frame)
    if request.points is not None:
        calibration = with_points(calibration, read_points(request.points))
    return calibration


def _same_size(views: tuple[BoardView, ...]) -> None:
    """Refuse views of different resolutions."""
    for view in views:
        if view.size_px != views[0].size_px:
            (w, h), (wide, high) = view.size_px, views[0].size_px
            raise ConfigError(f"{view.name} is {w} x {h} px, {views[0].name} {wide} x {high} px")


def _draw(
    calibration: Calibration, images: dict[str, Image], folder: Path, tag_height: float
) -> None:
    """Write pictures of what was seen."""
    folder.mkdir(parents=True, exist_ok=True)
    if calibration.views:
        write_picture(folder / "coverage.png", draw_coverage(calibration))
        magnified = magnification(calibration)
    for view, residuals in zip(calibration.views, calibration.residuals, strict=True):
        picture = draw_corners(images[view.name], view, residuals, magnified)
        write_picture(folder / f"corners_{Path(view.name).stem.replace(' ', '_')}.png", picture)
    if calibration.floor is not None:
        w, h = calibration.size_px
        blank = np.full((h, w, 3), 40, np.uint8)
        last = calibration.views[-calibration.floor.views].name if calibration.floor.views else ""
        picture = draw_floor(images.get(last, blank), calibration.camera(tag_height))
        write_picture(folder / "floor.png", picture)
