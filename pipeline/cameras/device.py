"""A camera at this machine, through OpenCV: an index or /dev/videoN."""

import glob
import os
import sys
import time
from dataclasses import dataclass

import cv2
import numpy as np

from pipeline.cameras.newest import NewestFrame, Picture
from pipeline.errors import CameraError
from pipeline.ports import Clock

OLDEST_STAMP = 1.0  # a driver's stamp further back than this is of another clock [s]


@dataclass(frozen=True, slots=True)
class CaptureFormat:
    """What is asked of a device; None leaves it to the driver.

    Attributes:
        size_px: width and height [px].
        fps: frames per second.
    """

    size_px: tuple[int, int] | None = None
    fps: float | None = None


class DeviceReader:
    """Reads one device, picture by picture; see FrameReader."""

    def __init__(
        self, device: int | str, clock: Clock, latency: float, wanted: CaptureFormat
    ) -> None:
        """Open the device and set its format.

        Args:
            device: index or path.
            clock: the run's clock.
            latency: from the picture to its arrival, where the driver gives no time [s].
            wanted: format to set; the device must agree.

        Raises:
            CameraError: if the device is missing, busy, forbidden, or refuses the format.
        """
        self._name = device_path(device)
        self._clock, self._latency = clock, latency
        _check_path(self._name)
        cv2.utils.logging.setLogLevel(0)  # OpenCV reports on stderr what the message below says
        backend = cv2.CAP_V4L2 if sys.platform == "linux" else cv2.CAP_ANY
        self._capture = cv2.VideoCapture(device, backend)
        if not self._capture.isOpened():
            raise CameraError(f"camera {self._name}: is no camera, or another program uses it")
        self._set(wanted)

    def read(self) -> Picture:
        """Wait for the next picture.

        Returns:
            It, with its capture time on the run's clock.

        Raises:
            CameraError: if the device gives none.
        """
        ok, image = self._capture.read()
        if not ok:
            raise CameraError(f"camera {self._name}: gives no more pictures (unplugged?)")
        stamp = self._capture.get(cv2.CAP_PROP_POS_MSEC) / 1000.0
        age = stamp_age(stamp, time.monotonic())
        t_capture = self._clock.now() - (self._latency if age is None else age)
        return Picture(np.asarray(image, dtype=np.uint8), t_capture)

    def release(self) -> None:
        """Give the device back."""
        self._capture.release()

    def _set(self, wanted: CaptureFormat) -> None:
        self._capture.set(cv2.CAP_PROP_BUFFERSIZE, 1)
        if wanted.size_px is not None:
            self._capture.set(cv2.CAP_PROP_FRAME_WIDTH, wanted.size_px[0])
            self._capture.set(cv2.CAP_PROP_FRAME_HEIGHT, wanted.size_px[1])
        if wanted.fps is not None:
            self._capture.set(cv2.CAP_PROP_FPS, wanted.fps)
        got = CaptureFormat(
            (
                round(self._capture.get(cv2.CAP_PROP_FRAME_WIDTH)),
                round(self._capture.get(cv2.CAP_PROP_FRAME_HEIGHT)),
            ),
            self._capture.get(cv2.CAP_PROP_FPS),
        )
        refusal = format_refused(wanted, got)
        if refusal:
            self.release()
            raise CameraError(f"camera {self._name}: {refusal}")


def open_device(
    device: int | str,
    clock: Clock,
    latency: float = 0.0,
    wanted: CaptureFormat = CaptureFormat(),
    timeout: float = 5.0,
) -> NewestFrame:
    """Open a camera at this machine.

    Args:
        device: index or path.
        clock: the run's clock.
        latency: from the picture to its arrival, where the driver gives no time [s].
        wanted: format to set; the device must agree.
        timeout: longest wait for opening [s].

    Returns:
        A frame source that keeps only the newest frame.

    Raises:
        CameraError: if the device is missing, busy, forbidden, or refuses the format.
    """
    name = device_path(device)
    return NewestFrame(name, lambda: DeviceReader(device, clock, latency, wanted), timeout)


def stamp_age(stamp: float, monotonic_now: float) -> float | None:
    """Say how old a picture is by the driver's stamp.

    Args:
        stamp: what the driver gave; CLOCK_MONOTONIC for V4L2, anything for others [s].
        monotonic_now: the same clock's reading on arrival [s].

    Returns:
        The age [s]; None if the stamp is not of this clock: in the future, or long past.
    """
    age = monotonic_now - stamp
    return age if 0.0 <= age < OLDEST_STAMP else None


def format_refused(wanted: CaptureFormat, got: CaptureFormat) -> str | None:
    """Compare what was asked for with what the device does.

    Args:
        wanted: what was asked for.
        got: what the device reports after setting it.

    Returns:
        One sentence with the numbers, None if they agree.
    """
    if wanted.size_px is not None and got.size_px is not None and wanted.size_px != got.size_px:
        asked, done = ("x".join(map(str, size)) for size in (wanted.size_px, got.size_px))
        return f"does not do {asked} px, it offers {done} px"
    if wanted.fps is not None and got.fps and abs(got.fps - wanted.fps) > 0.02 * wanted.fps:
        return f"does not do {wanted.fps:g} frames/s, it offers {got.fps:g}"
    return None


def device_path(device: int | str) -> str:
    """Name a device as the system does.

    Args:
        device: index or path.

    Returns:
        Its path on Linux; elsewhere the index as text.
    """
    return f"/dev/video{device}" if isinstance(device, int) and _IS_LINUX else str(device)


_IS_LINUX = sys.platform == "linux"


def _check_path(path: str) -> None:
    """Tell apart what OpenCV reports as one failure."""
    if not path.startswith("/"):
        return
    if not os.path.exists(path):
        others = ", ".join(sorted(glob.glob("/dev/video*"))) or "no camera at all"
        raise CameraError(f"camera {path}: does not exist; there is {others}")
    effective = os.access in os.supports_effective_ids
    if not os.access(path, os.R_OK | os.W_OK, effective_ids=effective):
        raise CameraError(f"camera {path}: permission denied (is the user in the group 'video'?)")
