"""A video file as a live camera, paced by its own timestamps."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.cameras.report import CameraReport
from pipeline.cameras.stream import reason_of
from pipeline.cameras.tally import Tally
from pipeline.errors import CameraError
from pipeline.ports import EndOfStream
from vision.frame import Frame, as_frame

_SLACK = 1e-9  # a frame is not late for the rounding of its time [s]


class FileCamera:
    """Plays a video: its first frame is taken at the first cycle, the others as they are spaced."""

    def __init__(self, path: str, latency: float = 0.0, asked_fps: float | None = None) -> None:
        """Open the file and decode its first frame.

        Args:
            path: of the video.
            latency: from a frame's time to its delivery [s].
            asked_fps: frames per second that were asked for, None if nothing was [1/s].

        Raises:
            CameraError: if it cannot be read or holds no video.
        """
        self._path, self._latency, self._tally = path, latency, Tally(asked_fps)
        self._container = _open(path)
        self._frames = self._decode()
        self._sequence, self._ahead = 0, self._next()
        self._origin: float | None = None
        if self._ahead is None:
            self.close()
            raise CameraError(f"camera {path}: the video has no frame")

    @property
    def report(self) -> CameraReport:
        """What was delivered so far."""
        return self._tally.report

    def latest(self, now: float) -> Frame | None:
        """Hand out the newest frame that is due.

        Args:
            now: the moment of the cycle [s].

        Returns:
            The frame, None if no new one is due.

        Raises:
            CameraError: if the file is damaged from here on.
            EndOfStream: if the last frame was handed out.
        """
        if self._ahead is None:
            raise EndOfStream(f"{self._path}: end of the video")
        if self._origin is None:
            self._origin = now - self._ahead[0]
        due: tuple[float, NDArray[np.uint8]] | None = None
        while self._ahead and self._origin + self._ahead[0] + self._latency <= now + _SLACK:
            self._tally.dropped += due is not None
            due, self._ahead = self._ahead, self._next()
            t = self._origin + due[0]
            self._tally.receive(t, t + self._latency)
            self._sequence += 1
        if due is None:
            return None
        return as_frame(due[1], t, self._sequence - 1, self._path, t + self._latency)

    def close(self) -> None:
        """Close the file. Safe to call twice."""
        self._container.close()

    def _next(self) -> tuple[float, NDArray[np.uint8]] | None:
        try:
            return next(self._frames, None)
        except OSError as error:
            raise CameraError(f"camera {self._path}: {reason_of(error, 0.0)}") from error

    def _decode(self) -> Iterator[tuple[float, NDArray[np.uint8]]]:
        """Frames with their times [s]; where the file has none they follow the frame rate."""
        rate = float(self._container.streams.video[0].average_rate or 30)
        for number, frame in enumerate(self._container.decode(video=0)):
            yield (
                number / rate if frame.time is None else frame.time,
                frame.to_ndarray(format="bgr24"),
            )


def _open(path: str) -> Any:
    import av

    if not Path(path).is_file():
        missing = "is a folder" if Path(path).is_dir() else "there is no such file"
        raise CameraError(f"camera {path}: {missing}")
    try:
        container = av.open(path)
    except (av.FFmpegError, OSError) as error:
        raise CameraError(f"camera {path}: {reason_of(error, 0.0)}") from error
    if not container.streams.video:
        container.close()
        raise CameraError(f"camera {path}: the file has no video")
    return container
