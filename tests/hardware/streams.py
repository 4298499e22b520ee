"""Network cameras on loopback: MJPEG over HTTP and H.264 in MPEG-TS over UDP, with real codecs."""

import socket
import threading
from fractions import Fraction
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from socketserver import BaseServer
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

    def unplug(self) -> None:
        """Be gone: the stream ends, and nothing is at its address. Safe to call twice."""
        ...

    def plug(self) -> None:
        """Be there again, at the same address; a clock in the stream begins anew."""
        ...

    def close(self) -> None:
        """End the stream. Safe to call twice."""
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
        self._jpeg, self._count = b"", 0
        self._server: ThreadingHTTPServer | None = None
        self.port = port
        self.plug()
        self.url = f"http://127.0.0.1:{self.port}/stream"

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

    def next_after(self, count: int, server: BaseServer) -> tuple[bytes, int]:
        """Wait for news.

        Args:
            count: number of the picture already had.
            server: that serves who asks.

        Returns:
            The newest JPEG and its number; an empty one when the stream has ended.
        """
        with self._news:
            self._news.wait_for(lambda: self._count > count or self._server is not server)
            return (self._jpeg, self._count) if self._server is server else (b"", count)

    def plug(self) -> None:
        """Be there again, at the same address."""
        server = ThreadingHTTPServer(("127.0.0.1", self.port), _handler(self))
        server.daemon_threads = True
        self._server, self.port = server, server.server_port
        threading.Thread(target=server.serve_forever, args=(0.05,), daemon=True).start()

    def unplug(self) -> None:
        """End the stream for everyone connected. Safe to call twice."""
        with self._news:
            server, self._server = self._server, None
            self._news.notify_all()
        if server is not None:
            server.shutdown()
            server.server_close()

    def close(self) -> None:
        """End the stream for everyone connected. Safe to call twice."""
        self.unplug()


def _handler(camera: MjpegServer) -> type[BaseHTTPRequestHandler]:
    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.send_header("Content-Type", f"multipart/x-mixed-replace; boundary={BOUNDARY}")
            self.end_headers()
            self.connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            jpeg, count = camera.next_after(0, self.server)
            while jpeg:
                head = f"--{BOUNDARY}\r\nContent-Type: image/jpeg\r\nContent-Length: {len(jpeg)}"
                try:
                    self.wfile.write(head.encode() + b"\r\n\r\n" + jpeg + b"\r\n")
                except OSError:  # the viewer has gone
                    return
                jpeg, count = camera.next_after(count, self.server)

        def log_message(self, format: str, *args: Any) -> None:
            """Stay quiet."""

    return Handler


class UdpSender:
    """An H.264 camera that sends MPEG-TS over UDP, with its own capture times in the stream."""

    def __init__(self, size_px: tuple[int, int], fps: float, port: int | None = None) -> None:
        """Begin to send.

        Args:
            size_px: width and height [px].
            fps: frames per second.
            port: where to send on loopback; a free one if None.
        """
        self.url = f"udp://127.0.0.1:{port or _free_udp_port()}"
        self._size, self._fps, self._lock = size_px, round(fps), threading.Lock()
        self._container: Any = None
        self.plug()

    def publish(self, image: NDArray[np.uint8], t: float) -> None:
        """Send one picture.

        Args:
            image: (H, W, 3) BGR.
            t: when it was taken [s].
        """
        frame = av.VideoFrame.from_ndarray(image, format="bgr24")
        frame.pts, frame.time_base = round(t * CLOCK_RATE), Fraction(1, CLOCK_RATE)
        with self._lock:
            if self._container is not None:
                self._container.mux(self._stream.encode(frame))

    def plug(self) -> None:
        """Send again, to the same address; the times in the stream may be any."""
        container: Any = av.open(
            f"{self.url}?pkt_size=1316", "w", format="mpegts", options={"flush_packets": "1"}
        )
        stream = container.add_stream("libx264", rate=self._fps)
        stream.width, stream.height, stream.pix_fmt = *self._size, "yuv420p"
        stream.time_base = stream.codec_context.time_base = Fraction(1, CLOCK_RATE)
        stream.codec_context.gop_size = self._fps // 2  # who joins late waits at most half a second
        stream.codec_context.thread_count = 1
        stream.options = {"preset": "ultrafast", "tune": "zerolatency", "crf": "18"}
        with self._lock:
            self._container, self._stream = container, stream

    def unplug(self) -> None:
        """Send no more. Safe to call twice."""
        with self._lock:
            container, self._container = self._container, None
        if container is not None:
            container.mux(self._stream.encode(None))
            container.close()

    def close(self) -> None:
        """End the stream. Safe to call twice."""
        self.unplug()


def _free_udp_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
