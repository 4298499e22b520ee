"""Network cameras on loopback: MJPEG over HTTP and H.264 in MPEG-TS over UDP, with real codecs."""

import socket
import threading
from fractions import Fraction
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any, Protocol

import av
import cv2
import numpy as np
from numpy.typing import NDArray

BOUNDARY = "pictures"
CLOCK_RATE = 90_000  # ticks of an MPEG-TS timestamp [1/s]


class Streamer(Protocol):
    """What a rendered world streams its pictures through."""

    url: str

    def publish(self, image: NDArray[np.uint8], t: float) -> None:
        """Send one picture.

        Args:
            image: (H, W, 3) BGR.
            t: when it was taken [s].
        """
        ...

    def close(self) -> None:
        """End the stream."""
        ...


class MjpegServer:
    """An HTTP camera as IP cameras and phones serve it: multipart/x-mixed-replace of JPEGs."""

    def __init__(self, quality: int = 90, port: int = 0) -> None:
        """Listen.

        Args:
            quality: of the JPEGs, 1 to 100.
            port: on loopback; a free one if 0.
        """
        self._quality = [int(cv2.IMWRITE_JPEG_QUALITY), quality]
        self._news = threading.Condition()
        self._jpeg, self._count, self._ended = b"", 0, False
        self._server = ThreadingHTTPServer(("127.0.0.1", port), _handler(self))
        self._server.daemon_threads = True
        self.port = self._server.server_port
        self.url = f"http://127.0.0.1:{self._server.server_port}/stream"
        threading.Thread(target=self._server.serve_forever, args=(0.05,), daemon=True).start()

    def publish(self, image: NDArray[np.uint8], t: float) -> None:  # noqa: ARG002 - MJPEG has no times
        """Send one picture to everyone connected.

        Args:
            image: (H, W, 3) BGR.
            t: when it was taken [s]; the format has no room for it.
        """
        ok, jpeg = cv2.imencode(".jpg", image, self._quality)
        assert ok
        self.send(jpeg.tobytes())

    def send(self, jpeg: bytes) -> None:
        """Send a picture as it is, sound or broken.

        Args:
            jpeg: what stands for a JPEG.
        """
        with self._news:
            self._jpeg, self._count = jpeg, self._count + 1
            self._news.notify_all()

    def next_after(self, count: int) -> tuple[bytes, int]:
        """Wait for news.

        Args:
            count: number of the picture already had.

        Returns:
            The newest JPEG and its number; an empty one when the stream has ended.
        """
        with self._news:
            self._news.wait_for(lambda: self._count > count or self._ended)
            return (b"", count) if self._ended else (self._jpeg, self._count)

    def close(self) -> None:
        """End the stream for everyone connected."""
        with self._news:
            self._ended = True
            self._news.notify_all()
        self._server.shutdown()
        self._server.server_close()


def _handler(camera: MjpegServer) -> type[BaseHTTPRequestHandler]:
    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.send_header("Content-Type", f"multipart/x-mixed-replace; boundary={BOUNDARY}")
            self.end_headers()
            self.connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            jpeg, count = camera.next_after(0)
            while jpeg:
                head = f"--{BOUNDARY}\r\nContent-Type: image/jpeg\r\nContent-Length: {len(jpeg)}"
                try:
                    self.wfile.write(head.encode() + b"\r\n\r\n" + jpeg + b"\r\n")
                except OSError:  # the viewer has gone
                    return
                jpeg, count = camera.next_after(count)

        def log_message(self, format: str, *args: Any) -> None:
            """Stay quiet."""

    return Handler


class UdpSender:
    """An H.264 camera that sends MPEG-TS over UDP, with its own capture times in the stream."""

    def __init__(self, size_px: tuple[int, int], fps: float, port: int | None = None) -> None:
        """Prepare the encoder.

        Args:
            size_px: width and height [px].
            fps: frames per second.
            port: where to send on loopback; a free one if None.
        """
        self.url = f"udp://127.0.0.1:{port or _free_udp_port()}"
        self._container: Any = av.open(
            f"{self.url}?pkt_size=1316",
            "w",
            format="mpegts",
            options={"flush_packets": "1"},
        )
        stream = self._container.add_stream("libx264", rate=round(fps))
        stream.width, stream.height, stream.pix_fmt = *size_px, "yuv420p"
        stream.time_base = stream.codec_context.time_base = Fraction(1, CLOCK_RATE)
        stream.codec_context.gop_size = round(fps / 2)  # who joins late waits at most half a second
        stream.codec_context.thread_count = 1
        stream.options = {"preset": "ultrafast", "tune": "zerolatency", "crf": "18"}
        self._stream = stream

    def publish(self, image: NDArray[np.uint8], t: float) -> None:
        """Send one picture.

        Args:
            image: (H, W, 3) BGR.
            t: when it was taken [s].
        """
        frame = av.VideoFrame.from_ndarray(image, format="bgr24")
        frame.pts, frame.time_base = round(t * CLOCK_RATE), Fraction(1, CLOCK_RATE)
        self._container.mux(self._stream.encode(frame))

    def close(self) -> None:
        """End the stream."""
        self._container.mux(self._stream.encode(None))
        self._container.close()


def _free_udp_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
