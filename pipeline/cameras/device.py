"""A camera at this machine, through OpenCV: an index or /dev/videoN."""

import glob
import os
import sys
import time
from dataclasses import replace

import cv2
import numpy as np

from pipeline.cameras.capture_format import (
    ANY_FORMAT,
    CaptureFormat,
    format_refused,
    fourcc,
    pixels_named,
)
from pipeline.cameras.newest import USUAL, Habits, NewestFrame
from pipeline.cameras.options import AS_IT_IS, DeviceOptions, apply
from pipeline.cameras.reader import Picture
from pipeline.cameras.v4l2 import V4l2Device
from pipeline.errors import CameraError
from pipeline.notice import tell
from pipeline.ports import Clock

OLDEST_STAMP = 1.0  # a driver's stamp further back than this is of another clock [s]
# The reader always waits for the next picture, so a queue never builds up; with a single buffer the
# camera would have nowhere to put a picture while the one before is being decoded.
BUFFERS = 2
MOST_DAMAGED = 30  # JPEGs in a row that cannot be decoded; a single one is left out
os.environ.setdefault("OPENCV_VIDEOIO_V4L_SELECT_TIMEOUT", "2")  # else a hung camera blocks 10 s
SLOW_HINT = (
    ": usually the exposure is longer than a frame; give more light, or lock it shorter "
    "(camera.device.exposure_ms); echelon cameras lists the rates of each format"
)


class DeviceReader:
    """Reads one device, picture by picture; see FrameReader."""

    def __init__(
        self,
        device: int | str,
        clock: Clock,
        latency: float,
        wanted: CaptureFormat,
        options: DeviceOptions = AS_IT_IS,
    ) -> None:
        """Open the device, set its format and then what it is asked to hold still.

        Args:
            device: index or path.
            clock: the run's clock.
            latency: from the picture to its arrival, where the driver gives no time [s].
            wanted: format to set; the device must agree.
            options: exposure and the like; where the device does otherwise the user is told.

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
        for line in refused_options(self._name, options, wanted.fps):
            tell(f"camera {self._name}: {line}")

    def read(self) -> Picture:
        """Wait for the next picture.

        Returns:
            It, with its capture time on the run's clock.

        Raises:
            CameraError: if the device gives none, or damaged ones only.
        """
        for _ in range(MOST_DAMAGED):
            if not self._capture.grab():
                raise CameraError(f"camera {self._name}: gives no more pictures (unplugged?)")
            ok, image = self._capture.retrieve()
            if ok:
                return self._picture(image)
        raise CameraError(f"camera {self._name}: {MOST_DAMAGED} damaged pictures in a row")

    def release(self) -> None:
        """Give the device back."""
        self._capture.release()

    def _picture(self, image: cv2.typing.MatLike) -> Picture:
        stamp = self._capture.get(cv2.CAP_PROP_POS_MSEC) / 1000.0
        age, now = stamp_age(stamp, time.monotonic()), self._clock.now()
        pixels = np.asarray(image, dtype=np.uint8)
        if age is None:
            return Picture(pixels, now - self._latency, now)
        return Picture(pixels, now - age, now, stamp)

    def _set(self, wanted: CaptureFormat) -> None:
        self._capture.set(cv2.CAP_PROP_BUFFERSIZE, BUFFERS)
        if wanted.pixels is not None:  # first: sizes and rates depend on it
            self._capture.set(cv2.CAP_PROP_FOURCC, fourcc(wanted.pixels))
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
            pixels_named(self._capture.get(cv2.CAP_PROP_FOURCC)),
        )
        refusal = format_refused(wanted, got)
        if refusal:
            self.release()
            raise CameraError(f"camera {self._name}: {refusal}")


def open_device(
    device: int | str,
    clock: Clock,
    latency: float = 0.0,
    wanted: CaptureFormat = ANY_FORMAT,
    options: DeviceOptions = AS_IT_IS,
    habits: Habits = USUAL,
) -> NewestFrame:
    """Open a camera at this machine.

    Args:
        device: index or path.
        clock: the run's clock.
        latency: from the picture to its arrival, where the driver gives no time [s].
        wanted: format to set; the device must agree.
        options: exposure and the like, set at every opening.
        habits: what is expected of the camera.

    Returns:
        A frame source that keeps only the newest frame.

    Raises:
        CameraError: if the device is missing, busy, forbidden, or refuses the format.
    """
    name = device_path(device)
    habits = replace(habits, slow_hint=SLOW_HINT)
    return NewestFrame(
        name, lambda: DeviceReader(device, clock, latency, wanted, options), clock, habits
    )


def refused_options(path: str, options: DeviceOptions, fps: float | None) -> tuple[str, ...]:
    """Set what a device is asked to hold still.

    Args:
        path: of the device.
        options: what is asked for.
        fps: the frame rate asked for, None if none is [1/s].

    Returns:
        One line for each thing that is not as asked.
    """
    if options == AS_IT_IS:
        return ()
    if not _IS_LINUX:
        return ("exposure, gain, focus and white balance can be set on Linux only",)
    try:
        with V4l2Device(path) as device:
            return tuple(apply(options, device, fps))
    except OSError as error:
        return (f"exposure and the like cannot be set ({error.strerror})",)


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
