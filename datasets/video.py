"""Recorded pictures as frames: videos, folders of images, single images."""

import re
from collections.abc import Iterator
from pathlib import Path

import av
import cv2
import numpy as np
from av.container import InputContainer
from av.video.stream import VideoStream
from numpy.typing import NDArray

from datasets.errors import RecordingError
from datasets.image_damage import damage_of
from vision.frame import Frame, as_frame

Image = NDArray[np.uint8]

IMAGE_SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp")
DEFAULT_FPS = 30.0


class Footage:
    """A video or a folder of images; iterate it, as often as needed, to get its frames.

    Attributes:
        path: the file or folder.
    """

    def __init__(self, path: Path, fps: float | None) -> None:
        """Use `read_frames`.

        Args:
            path: the file or folder.
            fps: constant rate that replaces the file's own times [1/s], or None.
        """
        self.path = path
        self._fps = fps
        self._lost = 0

    @property
    def lost(self) -> int:
        """Frames the file announces that could not be decoded; known after an iteration."""
        return self._lost

    def __iter__(self) -> Iterator[Frame]:
        """Iterate over the frames.

        Yields:
            Frames, numbered from 0, with strictly growing capture times.

        Raises:
            RecordingError: if an image, or no frame at all, can be decoded.
        """
        if self.path.is_dir():
            return self._folder()
        return self._video()

    def _folder(self) -> Iterator[Frame]:
        period = 1.0 / (self._fps or DEFAULT_FPS)
        for i, path in enumerate(image_files(self.path)):
            yield as_frame(read_image(path), i * period, i, self.path.name)

    def _video(self) -> Iterator[Frame]:
        self._lost = 0
        count, t = 0, 0.0
        with _open(self.path) as container:
            stream = container.streams.video[0]
            period = 1.0 / (self._fps or _rate(stream))
            for picture in self._pictures(container, stream):
                t = _capture_time(None if self._fps else picture.time, t if count else None, period)
                image = picture.to_ndarray(format="bgr24")
                yield as_frame(image, t, count, self.path.name)
                count += 1
            self._lost = max(self._lost, _announced(container, stream) - count)
        if count == 0:
            raise RecordingError(f"{self.path}: holds no frame that can be decoded")

    def _pictures(self, container: InputContainer, stream: VideoStream) -> Iterator[av.VideoFrame]:
        """Decode packet by packet, counting those that fail; a damaged end ends the video."""
        packets = container.demux(stream)
        while True:
            try:
                packet = next(packets)
            except (StopIteration, av.error.FFmpegError):
                return
            try:
                yield from packet.decode()
            except av.error.FFmpegError:
                self._lost += 1


def read_frames(source: Path | str, fps: float | None = None) -> Footage:
    """Open a video or a folder of images.

    Args:
        source: a video file, or a folder whose PNG, JPG and BMP files are taken in natural order
            (2 before 10).
        fps: constant frame rate [1/s]; by default a video's own time stamps, 30 for a folder.

    Returns:
        The footage; frames are decoded when it is iterated.

    Raises:
        RecordingError: if the source is missing, empty, unreadable or without pictures, or fps is
            not positive.
    """
    path = Path(source)
    if fps is not None and not 0.0 < fps < float("inf"):
        raise RecordingError(f"{path}: frame rate must be > 0, got {fps}")
    if path.is_dir():
        if not image_files(path):
            kinds = ", ".join(IMAGE_SUFFIXES)
            raise RecordingError(f"{path}: the folder holds no images ({kinds})")
    else:
        _open(path).close()
    return Footage(path, fps)


def image_files(folder: Path) -> tuple[Path, ...]:
    """Images of a folder in natural order.

    Args:
        folder: an existing folder.

    Returns:
        Paths; hidden files are left out.
    """
    found = (path for path in folder.iterdir() if path.suffix.lower() in IMAGE_SUFFIXES)
    return tuple(sorted((p for p in found if not p.name.startswith(".")), key=_natural))


def _natural(path: Path) -> list[tuple[int, str]]:
    """Sort key in which numbers count as numbers."""
    pieces = re.findall(r"\d+|\D+", path.name.lower())
    return [(int(piece), "") if piece.isdecimal() else (-1, piece) for piece in pieces]


def read_image(path: Path | str) -> Image:
    """Read one image of any usual kind.

    Args:
        path: PNG, JPG or BMP file; grey or colour, 8 or 16 bit, with or without transparency.

    Returns:
        Shape (H, W, 3), BGR, uint8; transparent parts are black.

    Raises:
        RecordingError: if the file is missing, empty, cut off, damaged, no image, or of another
            pixel type.
    """
    path = Path(path)
    try:
        data = np.frombuffer(path.read_bytes(), np.uint8)
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read ({error.strerror})") from error
    if data.size == 0:
        raise RecordingError(f"{path}: the file is empty")
    if damage := damage_of(data.tobytes()):
        raise RecordingError(f"{path}: {damage}")
    try:
        image = cv2.imdecode(data, cv2.IMREAD_UNCHANGED)
    except cv2.error as error:
        raise RecordingError(f"{path}: cannot be decoded ({error.err})") from error
    if image is None:
        raise RecordingError(f"{path}: is not an image, or is damaged")
    return _to_bgr8(np.asarray(image), path)


def _to_bgr8(image: NDArray[np.generic], path: Path) -> Image:
    """Any decoded image as three 8-bit channels."""
    if image.dtype == np.uint16:
        image = np.rint(np.asarray(image, np.float32) / 257.0).astype(np.uint8)
    if image.dtype != np.uint8:
        raise RecordingError(f"{path}: {image.dtype} pixels; need 8 or 16 bit")
    pixels: Image = np.asarray(image, np.uint8)
    if pixels.ndim == 2 or pixels.shape[2] == 1:
        return np.asarray(cv2.cvtColor(pixels, cv2.COLOR_GRAY2BGR), np.uint8)
    if pixels.shape[2] == 4:
        alpha = pixels[:, :, 3:].astype(np.float32) / 255.0
        return np.asarray(np.rint(pixels[:, :, :3] * alpha), np.uint8)
    if pixels.shape[2] != 3:
        raise RecordingError(f"{path}: {pixels.shape[2]} channels; need 1, 3 or 4")
    return pixels


def _open(path: Path) -> InputContainer:
    """Open a video that has a video stream."""
    if not path.exists():
        raise RecordingError(f"{path}: no such file or folder")
    if path.stat().st_size == 0:
        raise RecordingError(f"{path}: the file is empty")
    try:
        container = av.open(str(path), mode="r")
    except (av.error.FFmpegError, OSError) as error:
        reason = error.strerror or type(error).__name__
        raise RecordingError(f"{path}: is not a readable video ({reason})") from error
    if not container.streams.video:
        container.close()
        raise RecordingError(f"{path}: has no video stream")
    return container


def _capture_time(stamp: float | None, before: float | None, period: float) -> float:
    """The time stamp if it is usable, else one period after the frame before [s]."""
    if stamp is not None and (before is None or stamp > before):
        return float(stamp)
    return 0.0 if before is None else before + period


def _announced(container: InputContainer, stream: VideoStream) -> int:
    """Frames the container says it holds, 0 if it does not; from a duration, one to spare."""
    if stream.frames:
        return stream.frames
    seconds = (container.duration or 0) / av.time_base
    return max(int(seconds * _rate(stream)) - 1, 0)


def _rate(stream: VideoStream) -> float:
    """Frames per second the container states, else the default."""
    rate = stream.average_rate or stream.guessed_rate
    return float(rate) if rate else DEFAULT_FPS
