"""A blocking reader in a thread that keeps only its newest frame: shared by devices and streams."""

import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import CameraError
from pipeline.ports import EndOfStream
from vision.errors import VisionError
from vision.frame import Frame, as_frame

CLOSE_TIMEOUT = 1.0  # a reader that blocks longer is left to its daemon thread [s]


@dataclass(frozen=True, slots=True)
class Picture:
    """What a reader yields.

    Attributes:
        image: uint8, shape (H, W, 3), BGR.
        t_capture: when it was taken, on the run's clock [s].
    """

    image: NDArray[np.uint8]
    t_capture: float


class FrameReader(Protocol):
    """A camera that is read by waiting for it."""

    def read(self) -> Picture:
        """Wait for the next picture.

        Returns:
            The picture.

        Raises:
            CameraError: if the camera has failed or ended.
            EndOfStream: if it has ended as planned.
        """
        ...

    def release(self) -> None:
        """Give the device back."""
        ...


class NewestFrame:
    """A frame source that reads in its own thread and never queues: an unread frame is replaced.

    Attributes:
        camera_id: name put on the frames.
    """

    def __init__(
        self, camera_id: str, open_reader: Callable[[], FrameReader], timeout: float = 5.0
    ) -> None:
        """Open the reader in its thread and wait for it.

        Args:
            camera_id: name for frames and messages.
            open_reader: opens the device; raises CameraError.
            timeout: longest wait for opening [s].

        Raises:
            CameraError: if it cannot be opened, or not in time.
        """
        self.camera_id = camera_id
        self._open_reader = open_reader
        self._lock = threading.Lock()
        self._opened, self._closing = threading.Event(), threading.Event()
        self._frame: Frame | None = None
        self._failure: CameraError | EndOfStream | None = None
        self._read, self._dropped, self._last_t = 0, 0, -np.inf
        self._thread = threading.Thread(target=self._run, name=f"camera {camera_id}", daemon=True)
        self._thread.start()
        self._await_opening(timeout)

    @property
    def dropped(self) -> int:
        """Frames that were replaced unread or came out of order."""
        with self._lock:
            return self._dropped

    @property
    def received(self) -> int:
        """Frames read so far."""
        with self._lock:
            return self._read

    def latest(self, now: float) -> Frame | None:  # noqa: ARG002 - what is here has arrived by now
        """Hand out the newest frame not handed out before.

        Args:
            now: the moment of the cycle [s].

        Returns:
            The newest frame, None if there is no new one.

        Raises:
            CameraError: if the camera has failed; the last frame is handed out first.
            EndOfStream: if it has ended as planned.
        """
        with self._lock:
            frame, self._frame = self._frame, None
            if frame is None and self._failure is not None:
                raise self._failure
            return frame

    def close(self) -> None:
        """Release the device. Safe to call twice; does not wait for a reader that hangs."""
        self._closing.set()
        self._thread.join(CLOSE_TIMEOUT)

    def _await_opening(self, timeout: float) -> None:
        in_time = self._opened.wait(timeout)
        failure = self._failure
        if in_time and failure is None:
            return
        self._closing.set()
        raise failure or CameraError(f"camera {self.camera_id}: did not open within {timeout:g} s")

    def _run(self) -> None:
        try:
            self._read_all(self._open_reader())
        except (CameraError, EndOfStream) as error:
            self._fail(error)
        finally:  # whatever else ended this thread must not look like a camera without news
            self._fail(CameraError(f"camera {self.camera_id}: its reader has stopped"))

    def _read_all(self, reader: FrameReader) -> None:
        self._opened.set()
        try:
            while not self._closing.is_set():
                self._keep(reader.read())
        finally:
            reader.release()

    def _keep(self, picture: Picture) -> None:
        try:
            frame = as_frame(picture.image, picture.t_capture, self._read, self.camera_id)
        except VisionError as error:
            raise CameraError(str(error)) from error
        with self._lock:
            self._read += 1
            if frame.t_capture <= self._last_t:  # late: time never runs backwards for the filters
                self._dropped += 1
                return
            self._dropped += self._frame is not None
            self._frame, self._last_t = frame, frame.t_capture

    def _fail(self, error: CameraError | EndOfStream) -> None:
        with self._lock:
            self._failure = self._failure or error
        self._opened.set()
