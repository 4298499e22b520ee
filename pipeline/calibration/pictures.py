"""Pictures of a board from wherever they come: files, folders, videos, cameras."""

import sys
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from datasets.errors import RecordingError
from datasets.recorded import image_files, read_frames, read_image
from datasets.video import IMAGE_SUFFIXES
from pipeline.cameras.capture_format import CaptureFormat
from pipeline.cameras.open import CameraRequest, open_camera
from pipeline.clock import MonotonicClock
from pipeline.errors import CameraError, ConfigError
from pipeline.glimpses import SILENT
from pipeline.ports import EndOfStream
from vision.calibration.board import Board
from vision.calibration.detect import BoardView, find_board
from vision.calibration.selection import Selection, offer
from vision.calibration.views import lacking_regions
from vision.frame import Frame

Image = NDArray[np.uint8]

_PATIENCE = 0.01  # between two looks for a new frame [s]


@dataclass
class Gathered:
    """Views, their pictures, and what could not be used.

    Attributes:
        views: boards that were found, all of one size.
        images: their pictures by name.
        unused: sentences that name pictures and say why they were not used.
    """

    views: list[BoardView] = field(default_factory=list)
    images: dict[str, Image] = field(default_factory=dict)
    unused: list[str] = field(default_factory=list)

    def add(self, view: BoardView, image: Image) -> None:
        """Keep a view.

        Args:
            view: of a board.
            image: in which it was found.
        """
        self.views.append(view)
        self.images[view.name] = image


def gather_views(
    source: str,
    board: Board,
    wanted: int,
    size_px: tuple[int, int] | None,
    interrupted: Callable[[], bool],
) -> Gathered:
    """Find a board in the pictures of a source.

    Args:
        source: a folder, an image, a video, or a camera's SPEC.
        board: to look for.
        wanted: number of views to choose from a video or camera; of a folder all are taken.
        size_px: wanted size of a camera's frames, None leaves it to the camera [px].
        interrupted: whether the user has had enough: what was gathered is used.

    Returns:
        Views and pictures.

    Raises:
        ConfigError: if the source is nothing of the kind.
        RecordingError: if a file or folder cannot be read at all.
        CameraError: if the camera cannot be opened.
    """
    path = Path(source)
    if path.is_dir() or path.suffix.lower() in IMAGE_SUFFIXES:
        return _from_stills(still_files(path), board)
    return _from_stream(_frames(source, size_px, interrupted), board, wanted)


def gather_floor(
    sources: tuple[str, ...],
    board: Board,
    size_px: tuple[int, int] | None,
    interrupted: Callable[[], bool],
) -> Gathered:
    """Find a board that lies on the floor.

    Args:
        sources: images, folders of images, or cameras, of which one still frame is taken.
        board: to look for.
        size_px: wanted size of a camera's frames, None leaves it to the camera [px].
        interrupted: whether the user has had enough.

    Returns:
        Views and pictures, in the order of the sources.

    Raises:
        ConfigError: if the board is not found in a source.
        RecordingError: if a file cannot be read.
        CameraError: if a camera cannot be opened.
    """
    gathered = Gathered()
    for source in sources:
        path = Path(source)
        if path.is_dir() or path.suffix.lower() in IMAGE_SUFFIXES:
            found = _from_stills(still_files(path), board)
        else:
            frames = _frames(source, size_px, interrupted)
            found = _from_stream(frames, board, 1, everywhere=False)
        if found.unused or not found.views:  # a lost first picture would move the floor frame
            raise ConfigError(f"floor: {'; '.join(found.unused) or f'{source}: no board seen'}")
        for view in found.views:
            gathered.add(replace(view, name=f"floor {view.name}"), found.images[view.name])
    return gathered


def still_files(path: Path) -> tuple[Path, ...]:
    """The images that a path names.

    Args:
        path: an image or a folder of images.

    Returns:
        Files in natural order.

    Raises:
        RecordingError: if there is none.
    """
    files = image_files(path) if path.is_dir() else (path,)
    if not files:
        raise RecordingError(f"{path}: the folder holds no images ({', '.join(IMAGE_SUFFIXES)})")
    return files


def _frames(
    source: str, size_px: tuple[int, int] | None, interrupted: Callable[[], bool]
) -> Iterable[Frame]:
    """Frames of a video, or of a camera."""
    path = Path(source)
    return read_frames(path) if path.is_file() else camera_frames(source, size_px, interrupted)


def camera_frames(
    spec: str, size_px: tuple[int, int] | None, interrupted: Callable[[], bool]
) -> Iterator[Frame]:
    """Frames of a camera, the newest at every call.

    Args:
        spec: index, /dev/videoN or URL.
        size_px: wanted size, None leaves it to the camera [px].
        interrupted: ends the frames.

    Yields:
        Frames.

    Raises:
        CameraError: if it cannot be opened or fails.
        ConfigError: if the SPEC names no kind of camera.
    """
    clock = MonotonicClock()
    if spec == "rendered":
        raise ConfigError("calibrate camera: the rendered camera needs no calibration")
    with closing(open_camera(spec, clock, CameraRequest(wanted=CaptureFormat(size_px)))) as camera:
        given_up = clock.now() + SILENT
        while not interrupted():
            try:
                frame = camera.latest(clock.now())
            except EndOfStream:
                return
            if frame is not None:
                yield frame
                given_up = clock.now() + SILENT
            elif clock.now() > given_up:
                raise CameraError(f"camera {spec}: no frame for {SILENT:.0f} s")
            else:
                clock.wait_until(clock.now() + _PATIENCE)


def _from_stills(files: tuple[Path, ...], board: Board) -> Gathered:
    """All images in which the board is found, of the size that most of them have."""
    gathered, images = Gathered(), {}
    for path in files:
        try:
            images[path] = read_image(path)
        except RecordingError as error:
            gathered.unused.append(str(error))
    sizes = Counter(image.shape[1::-1] for image in images.values())
    usual = sizes.most_common(1)[0][0] if sizes else (0, 0)
    for path, image in images.items():
        size = image.shape[1::-1]
        if size != usual:
            gathered.unused.append(
                f"{path}: is {size[0]} x {size[1]} px, the others {usual[0]} x {usual[1]} px"
            )
            continue
        view = find_board(image, board, path.name)
        if isinstance(view, str):
            gathered.unused.append(f"{path}: {view}")
        else:
            gathered.add(view, image)
    return gathered


def _from_stream(
    frames: Iterable[Frame], board: Board, wanted: int, everywhere: bool = True
) -> Gathered:
    """Sharp, still, different views of a moving picture."""
    gathered, selection, line = Gathered(), Selection(), _Line()
    for frame in frames:
        found = find_board(frame.image, board, f"frame {frame.sequence}", thorough=False)
        view = None if isinstance(found, str) else found
        if view is not None and selection.kept and view.size_px != selection.kept[0].size_px:
            raise RecordingError(f"{frame.camera_id}: frame {frame.sequence} has another size")
        selection, verdict = offer(selection, view)
        if verdict == "kept" and view is not None:
            gathered.add(view, frame.image)
        line.tell(selection, verdict, wanted, frame.size_px)
        if selection.complete(wanted) or (not everywhere and len(selection.kept) >= wanted):
            break
    line.close()
    return gathered


class _Line:
    """Progress on one line of stderr, if that is a terminal; else a line for every view."""

    def __init__(self) -> None:
        self._terminal = sys.stderr.isatty()

    def tell(
        self, selection: Selection, verdict: str, wanted: int, size_px: tuple[int, int]
    ) -> None:
        """Say how far it is, and where corners are lacking."""
        if not self._terminal and verdict != "kept":
            return
        lacking = ", ".join(lacking_regions(selection.kept, size_px)) or "nowhere"
        text = f"{len(selection.kept)} of {wanted} views, {verdict}; corners lacking: {lacking}"
        sys.stderr.write("\r" + text[:118].ljust(118) if self._terminal else text + "\n")
        sys.stderr.flush()

    def close(self) -> None:
        """Leave a clean line."""
        if self._terminal:
            sys.stderr.write("\r" + " " * 118 + "\r")
            sys.stderr.flush()
