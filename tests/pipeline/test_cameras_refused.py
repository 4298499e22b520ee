"""Network cameras that cannot be opened: why, in one line, and without passwords."""

import socket
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest

from pipeline.cameras.newest import Habits
from pipeline.cameras.stream import open_stream, public_name
from pipeline.clock import MonotonicClock
from pipeline.errors import CameraError

pytestmark = pytest.mark.realtime

CLOCK = MonotonicClock()


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


def test_passwords_are_neither_shown_nor_recorded() -> None:
    assert public_name("rtsp://me:secret@10.0.0.7:554/live?x=1") == "rtsp://10.0.0.7:554/live?x=1"
    with pytest.raises(CameraError) as caught:
        open_stream("http://me:secret@127.0.0.1:9/x", CLOCK)
    assert "secret" not in str(caught.value)
