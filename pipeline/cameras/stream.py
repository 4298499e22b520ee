"""A network camera: MJPEG over HTTP, RTSP, or MPEG-TS over UDP, decoded with the least delay."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any
from urllib.parse import urlsplit, urlunsplit

from pipeline.cameras.newest import USUAL, Habits, NewestFrame
from pipeline.cameras.reader import Picture
from pipeline.cameras.timing import StreamTiming
from pipeline.errors import CameraError
from pipeline.ports import Clock

READ_TIMEOUT = 2.0  # a stream that is silent for longer has failed [s]
# What has queued up while the stream was probed says nothing about delays: it is decoded but not
# shown, until a packet had to be waited for.
BACKLOG, BACKLOG_WAIT = 100, 0.010  # packets at most, wait that ends it [1, s]
SLOW_HINT = ": set the rate at the camera, or say camera.fps as it is; or the network is too slow"

# What FFmpeg would hold back for smoothness is wrong for control: the newest picture counts.
LOW_DELAY = {
    "fflags": "nobuffer",
    "probesize": "32768",
    "analyzeduration": "300000",
    "rtsp_flags": "prefer_tcp",
    "reorder_queue_size": "0",
}
# A parser sees that a picture is complete only when the next begins: one frame period too late.
# Packets of MPEG-TS are whole pictures and need none; raw streams are cut by their parser alone.
UNPARSED = LOW_DELAY | {"fflags": "nobuffer+noparse+nofillin"}


class StreamReader:
    """Reads one URL, picture by picture; see FrameReader."""

    def __init__(self, url: str, clock: Clock, latency: float, timeout: float) -> None:
        """Connect and find the video.

        Args:
            url: http, rtsp or udp address.
            clock: the run's clock.
            latency: from the picture to its earliest arrival [s].
            timeout: longest wait for an answer [s].

        Raises:
            CameraError: if nothing answers or there is no video.
        """
        import av

        self._name, self._clock, self._timing = public_name(url), clock, StreamTiming(latency)
        self._errors, self._damaged = (av.FFmpegError, OSError), av.error.InvalidDataError
        try:
            self._container = _connect(url, timeout)
        except self._errors as error:
            raise CameraError(
                f"camera {self._name}: cannot open: {reason_of(error, timeout)}"
            ) from error
        if not self._container.streams.video:
            self._container.close()
            raise CameraError(f"camera {self._name}: the stream has no video")
        self._has_times = not _times_are_invented(self._container)
        self._pictures, self._whole = self._decode(), False

    def read(self) -> Picture:
        """Wait for the next picture.

        Returns:
            It, with its capture time on the run's clock.

        Raises:
            CameraError: if the stream ends, fails, or is silent for two seconds.
        """
        try:
            return next(self._pictures)
        except StopIteration:
            raise CameraError(f"camera {self._name}: the stream has ended") from None
        except self._errors as error:
            reason = reason_of(error, READ_TIMEOUT)
            raise CameraError(f"camera {self._name}: the stream broke off: {reason}") from error

    def release(self) -> None:
        """Hang up."""
        self._container.close()

    def _decode(self) -> Iterator[Picture]:
        stream = self._container.streams.video[0]
        stream.codec_context.thread_count = 1  # frame threads would each hold one picture back
        stream.codec_context.options = {"flags": "low_delay", "err_detect": "explode"}
        backlog, asked = BACKLOG, self._clock.now()
        for packet in self._container.demux(stream):
            arrival = self._clock.now()
            backlog = 0 if arrival - asked > BACKLOG_WAIT else max(0, backlog - 1)
            for frame in self._intact(packet):
                if not backlog:
                    yield self._picture(frame, arrival)
            asked = self._clock.now()

    def _picture(self, frame: Any, arrival: float) -> Picture:
        timestamp = frame.time if self._has_times else None
        t_capture = self._timing.capture_time(timestamp, arrival)
        image = frame.to_ndarray(format="bgr24")
        return Picture(image, t_capture, self._clock.now(), timestamp)

    def _intact(self, packet: Any) -> list[Any]:
        """Decode. After damage nothing is shown until a whole key frame: what a decoder puts where
        data are missing is old, and would show robots where they no longer are."""
        try:
            frames = packet.decode()
        except self._damaged:
            self._whole = False
            return []
        shown = []
        for frame in frames:
            intact = not (packet.is_corrupt or frame.is_corrupt)
            self._whole = intact and (self._whole or bool(frame.key_frame))
            shown += [frame] if self._whole else []
        return shown


def open_stream(
    url: str, clock: Clock, latency: float = 0.0, habits: Habits = USUAL
) -> NewestFrame:
    """Open a network camera.

    Args:
        url: http (MJPEG), rtsp or udp address.
        clock: the run's clock.
        latency: from the picture to its earliest arrival, as measured for this camera [s].
        habits: what is expected of the camera.

    Returns:
        A frame source that keeps only the newest frame.

    Raises:
        CameraError: if nothing answers in time or there is no video.
    """
    name = public_name(url)
    habits = replace(habits, slow_hint=SLOW_HINT)
    return NewestFrame(
        name, lambda: StreamReader(url, clock, latency, habits.timeout), clock, habits
    )


def public_name(url: str) -> str:
    """Take user name and password out of an address: it is shown and recorded.

    Args:
        url: perhaps of the form scheme://user:password@host/path.

    Returns:
        scheme://host/path.
    """
    parts = urlsplit(url)
    return urlunsplit(parts._replace(netloc=parts.netloc.rpartition("@")[2]))


def reason_of(error: Exception, timeout: float) -> str:
    """Say in a few words why FFmpeg gave up.

    Args:
        error: what PyAV raised.
        timeout: the time it was given [s].

    Returns:
        The reason, without the address.
    """
    from av.error import ExitError

    if isinstance(error, ExitError):  # how PyAV reports that its time was up
        return f"no data for {timeout:g} s"
    return str(getattr(error, "strerror", None) or error)


def _connect(url: str, timeout: float) -> Any:
    import av

    if url.startswith("udp:"):
        container = av.open(url, options=UNPARSED, timeout=(timeout, READ_TIMEOUT))
        if not _times_are_invented(container):
            return container
        container.close()
    return av.open(url, options=LOW_DELAY, timeout=(timeout, READ_TIMEOUT))


def _times_are_invented(container: Any) -> bool:
    """Where a format carries no timestamps FFmpeg makes them up: arrival is the better witness."""
    from av.format import Flags

    return bool(container.format.flags & Flags.no_timestamps.value)
