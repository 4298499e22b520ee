"""From a camera's SPEC, as the command line writes it, to its adapter."""

from dataclasses import dataclass
from pathlib import Path

from pipeline.cameras.capture_format import ANY_FORMAT, CaptureFormat
from pipeline.cameras.device import open_device
from pipeline.cameras.file import FileCamera
from pipeline.cameras.newest import USUAL, Habits
from pipeline.cameras.options import AS_IT_IS, DeviceOptions
from pipeline.cameras.stream import open_stream
from pipeline.errors import ConfigError
from pipeline.ports import Clock, FrameSource

URL_SCHEMES = ("http", "https", "rtsp", "rtsps", "udp", "rtp", "tcp")
KINDS = "rendered, an index, /dev/videoN, a URL (http, rtsp, udp) or a video file"


@dataclass(frozen=True, slots=True)
class CameraRequest:
    """How a camera is to be opened.

    Attributes:
        latency: from the picture to its earliest arrival [s].
        wanted: format that a device must agree to.
        options: exposure, gain and the like that a device is asked for.
        habits: what is expected of it.
    """

    latency: float = 0.0
    wanted: CaptureFormat = ANY_FORMAT
    options: DeviceOptions = AS_IT_IS
    habits: Habits = USUAL


def open_camera(spec: str, clock: Clock, request: CameraRequest = CameraRequest()) -> FrameSource:
    """Open what a SPEC names; `rendered` is the caller's, who has the world.

    Args:
        spec: an index, /dev/videoN, a URL or a file.
        clock: the run's clock.
        request: latency, format and patience.

    Returns:
        The frame source, open.

    Raises:
        ConfigError: if the SPEC names no kind of camera.
        CameraError: if it cannot be opened.
    """
    scheme, separator, _ = spec.partition("://")
    if separator and scheme.lower() in URL_SCHEMES:
        return open_stream(spec, clock, request.latency, request.habits)
    if spec.isdecimal() or spec.startswith("/dev/"):
        device = int(spec) if spec.isdecimal() else spec
        return open_device(
            device, clock, request.latency, request.wanted, request.options, request.habits
        )
    if spec and not separator and (Path(spec).suffix or Path(spec).exists()):
        return FileCamera(spec, request.latency, request.habits.fps)
    raise ConfigError(f"camera {spec!r}: need {KINDS}")
