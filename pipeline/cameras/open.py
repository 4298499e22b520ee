"""From a camera's SPEC, as the command line writes it, to its adapter."""

from dataclasses import dataclass, field
from pathlib import Path

from pipeline.cameras.device import CaptureFormat, open_device
from pipeline.cameras.file import FileCamera
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
        wanted: size and rate a device must agree to.
        timeout: longest wait for opening [s].
    """

    latency: float = 0.0
    wanted: CaptureFormat = field(default_factory=CaptureFormat)
    timeout: float = 5.0


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
        return open_stream(spec, clock, request.latency, request.timeout)
    if spec.isdecimal() or spec.startswith("/dev/"):
        device = int(spec) if spec.isdecimal() else spec
        return open_device(device, clock, request.latency, request.wanted, request.timeout)
    if spec and not separator and (Path(spec).suffix or Path(spec).exists()):
        return FileCamera(spec, request.latency)
    raise ConfigError(f"camera {spec!r}: need {KINDS}")
