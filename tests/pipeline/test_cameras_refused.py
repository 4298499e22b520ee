"""Network cameras that cannot be opened: why, in one line, and without passwords."""

import socket
import threading
import time
from contextlib import suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import cv2
import numpy as np
import pytest

from pipeline.cameras.newest import Habits
from pipeline.cameras.stream import StreamReader, open_stream, public_name
from pipeline.clock import MonotonicClock
from pipeline.errors import CameraError

pytestmark = pytest.mark.realtime

CLOCK = MonotonicClock()
STREAM = b"HTTP/1.0 200 OK\r\nContent-Type: multipart/x-mixed-replace; boundary=b\r\n\r\n"


def test_a_server_that_answers_without_video() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        threading.Thread(target=answer_with_text, args=(server,), daemon=True).start()
        with pytest.raises(CameraError, match="cannot open: ") as caught:
            open_stream(f"http://127.0.0.1:{server.getsockname()[1]}/", CLOCK)
    assert "\n" not in str(caught.value)


def answer_with_text(server: socket.socket) -> None:
    connection, _ = server.accept()
    with connection:
        connection.recv(4096)
        connection.sendall(b"HTTP/1.0 200 OK\r\nContent-Type: text/html\r\n\r\n<p>Hello</p>")


def test_a_server_that_never_answers_is_given_up() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        url = f"http://127.0.0.1:{server.getsockname()[1]}/"
        with pytest.raises(CameraError, match=r"no data for 0.3 s|within 0.3 s"):
            open_stream(url, CLOCK, habits=Habits(timeout=0.3))


class Redirecting(BaseHTTPRequestHandler):
    """Sends everyone to where they are."""

    asked = 0

    def do_GET(self) -> None:
        type(self).asked += 1
        self.send_response(302)
        self.send_header("Location", self.path)
        self.send_header("Content-Length", "0")
        self.end_headers()

    def log_message(self, format: str, *args: object) -> None:
        """Stay quiet."""


def test_a_server_that_redirects_for_ever_is_given_up() -> None:
    with ThreadingHTTPServer(("127.0.0.1", 0), Redirecting) as server:
        threading.Thread(target=server.serve_forever, args=(0.05,), daemon=True).start()
        with pytest.raises(CameraError, match=r"cannot open: |did not open") as caught:
            open_stream(
                f"http://127.0.0.1:{server.server_port}/", CLOCK, habits=Habits(timeout=3.0)
            )
        server.shutdown()
    assert 1 < Redirecting.asked < 100
    assert "\n" not in str(caught.value)


def drip(server: socket.socket, head: bytes) -> None:
    """Answer, then send a byte at a time for ever."""
    with suppress(OSError):
        connection, _ = server.accept()
        with connection:
            connection.recv(4096)
            connection.sendall(head)
            while True:
                connection.sendall(b"x")
                time.sleep(0.02)


PART = b"--b\r\nContent-Type: image/jpeg\r\nContent-Length: 9000000\r\n\r\n\xff\xd8"


def whole(count: int) -> bytes:
    """Pictures of a stream, complete."""
    noise, parts = np.random.default_rng(1), b""
    for _ in range(count):
        jpeg = cv2.imencode(".jpg", noise.integers(0, 255, (64, 96, 3), np.uint8))[1].tobytes()
        parts += b"--b\r\nContent-Type: image/jpeg\r\nContent-Length: %d\r\n\r\n" % len(jpeg)
        parts += jpeg + b"\r\n"
    return parts


@pytest.mark.parametrize(
    "head",
    [b"HTTP/1.0 200 OK\r\nX: ", STREAM + PART, STREAM + whole(5) + PART],
    ids=["header", "first picture", "later picture"],
)
def test_what_never_comes_to_an_end_is_given_up(
    head: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By the reader itself: when a camera is opened again nobody else looks at the time."""
    monkeypatch.setattr("pipeline.cameras.stream.READ_TIMEOUT", 0.5)
    with socket.create_server(("127.0.0.1", 0)) as server:
        threading.Thread(target=drip, args=(server, head), daemon=True).start()
        start = time.monotonic()
        with pytest.raises(CameraError, match=r"no data for 0.5 s"):
            read_all(f"http://127.0.0.1:{server.getsockname()[1]}/")
        assert time.monotonic() - start < 5.0  # 0.5 s by promise


def read_all(url: str) -> None:
    reader = StreamReader(url, CLOCK, 0.0, 0.5)
    try:
        while True:
            reader.read()
    finally:
        reader.release()


def test_passwords_are_neither_shown_nor_recorded() -> None:
    assert public_name("rtsp://me:secret@10.0.0.7:554/live?x=1") == "rtsp://10.0.0.7:554/live?x=1"
    with pytest.raises(CameraError) as caught:
        open_stream("http://me:secret@127.0.0.1:9/x", CLOCK)
    assert "secret" not in str(caught.value)
