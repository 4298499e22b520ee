"""Network cameras over real sockets and codecs: what arrives, when it was taken, how it ends."""

import re
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from fractions import Fraction
from itertools import count

import av
import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from pipeline.cameras.newest import NewestFrame
from pipeline.cameras.stream import open_stream
from pipeline.clock import MonotonicClock
from tests.hardware.streams import MjpegServer, Streamer, UdpSender
from vision.frame import Frame

pytestmark = pytest.mark.realtime

FPS = 30.0
SIZE = (320, 240)
CLOCK = MonotonicClock()


@pytest.fixture(autouse=True)
def _short_silence(monkeypatch: pytest.MonkeyPatch) -> None:
    """UDP tells nobody that it has ended: the tests wait one second for that, not two."""
    monkeypatch.setattr("pipeline.cameras.stream.READ_TIMEOUT", 1.0)


def numbered(number: int) -> NDArray[np.uint8]:
    """A picture that says its number in ten black and white squares."""
    image = np.full((SIZE[1], SIZE[0], 3), 60, np.uint8)
    for bit in range(10):
        image[16:48, 32 * bit : 32 * bit + 32] = 255 * (number >> bit & 1)
    return image


def number_in(image: NDArray[np.uint8]) -> int:
    return sum(1 << b for b in range(10) if image[24:40, 32 * b + 8 : 32 * b + 24].mean() > 128)


class Filming:
    """Streams numbered pictures in real time; each leaves up to `jitter` late."""

    def __init__(self, streamer: Streamer, frames: int, jitter: float) -> None:
        self.taken: list[float] = []
        self.url, self._streamer, self._frames = streamer.url, streamer, frames
        self._delays = np.random.default_rng(0).uniform(0.0, jitter, frames)
        self._delays[::7] = 0.0
        self.thread = threading.Thread(target=self._run, daemon=True)
        self.thread.start()

    def _run(self) -> None:
        start = CLOCK.now()
        for number in range(self._frames):
            t = start + number / FPS
            CLOCK.wait_until(t + self._delays[number])
            self.taken.append(t)
            self._streamer.publish(numbered(number), t)
        self._streamer.close()


def received(camera: NewestFrame) -> Iterator[tuple[int, float, float]]:
    """Number, capture time and arrival of every frame until the stream is lost."""
    for frame in frames_of(camera):
        yield number_in(frame.image), frame.t_capture, CLOCK.now()


def frames_of(camera: NewestFrame) -> Iterator[Frame]:
    """Every frame until the stream is lost."""
    while True:
        lost = bool(camera.outages)  # first: what came before the loss is handed out
        frame = camera.latest(CLOCK.now())
        if frame is not None:
            yield frame
        elif lost:
            return
        time.sleep(0.001)


@contextmanager
def camera_at(url: str, latency: float = 0.0) -> Iterator[NewestFrame]:
    camera = open_stream(url, CLOCK, latency)
    try:
        yield camera
    finally:
        camera.close()


@pytest.mark.parametrize(
    ("make", "spread"),
    [
        (MjpegServer, 0.1),  # has no times of its own: the jitter of arrival stays
        (lambda: UdpSender(SIZE, FPS), 0.012),
    ],
)
def test_frames_arrive_in_order_with_their_capture_times(
    make: Callable[[], Streamer], spread: float
) -> None:
    streamer = make()
    film = Filming(streamer, 90, jitter=0.03)
    with camera_at(streamer.url) as camera:
        got = [frame for frame in received(camera) if frame[0] < len(film.taken)]
        assert re.search("ended|broke off", camera.outages[0].reason)
    numbers = [number for number, _, _ in got]
    assert numbers == sorted(set(numbers))
    assert len(numbers) > 25
    settled = [(film.taken[n], t, arrival) for n, t, arrival in got[10:]]
    delays = np.array([t - taken for taken, t, _ in settled])
    assert delays.min() > -1e-3
    assert all(t <= arrival for _, t, arrival in settled)
    # Arrivals are spread over 30 ms; with the stream's own times the capture times are not.
    assert np.ptp(delays) < spread


def test_latency_is_subtracted() -> None:
    server = MjpegServer()
    Filming(server, 30, 0.0)
    with camera_at(server.url, latency=0.25) as camera:
        _, t_capture, arrival = next(received(camera))
    assert arrival - t_capture >= 0.25


def test_raw_h264_without_container_is_cut_into_pictures() -> None:
    """What small boards send: no container, no timestamps, datagrams that end anywhere."""
    film = Filming(RawH264(), 90, 0.0)
    with camera_at(film.url) as camera:
        got = [(n, t - film.taken[n]) for n, t, _ in received(camera)]
    numbers = [number for number, _ in got]
    assert len(numbers) > 10
    assert numbers == sorted(set(numbers))
    # What queued up during opening would look fresh by its arrival: it is not handed out.
    assert max(age for number, age in got if number < 85) < 0.15


class RawH264:
    """An H.264 elementary stream in datagrams of 1024 bytes."""

    def __init__(self) -> None:
        inner = UdpSender(SIZE, FPS)
        self.url = inner.url
        inner.close()
        port = int(self.url.rpartition(":")[2])
        self._to = ("127.0.0.1", port)
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._codec = av.CodecContext.create("libx264", "w")
        self._codec.width, self._codec.height, self._codec.pix_fmt = *SIZE, "yuv420p"
        self._codec.framerate, self._codec.gop_size = Fraction(30), 10
        self._codec.options = {"preset": "ultrafast", "tune": "zerolatency"}

    def publish(self, image: NDArray[np.uint8], t: float) -> None:  # noqa: ARG002 - no room for it
        picture = av.VideoFrame.from_ndarray(textured(number_in(image)), format="bgr24")
        for packet in self._codec.encode(picture):
            data = bytes(packet)
            for start in range(0, len(data), 1024):
                self._socket.sendto(data[start : start + 1024], self._to)

    def close(self) -> None:
        self._socket.close()


TEXTURE = np.random.default_rng(5).integers(0, 255, (SIZE[1], SIZE[0], 1), np.uint8)


def textured(number: int) -> NDArray[np.uint8]:
    """A numbered picture that fills many datagrams and moves."""
    image = np.roll(TEXTURE, number, axis=1).repeat(3, axis=2)
    image[:60] = numbered(number)[:60]
    return image


class Lossy:
    """An H.264 camera behind a line that loses a datagram now and then."""

    def __init__(self, paint: Callable[[int], NDArray[np.uint8]], lost_one_in: int) -> None:
        self._paint, self._lost_one_in = paint, lost_one_in
        self._sender, self.url = UdpSender(SIZE, FPS), UdpSender(SIZE, FPS).url
        self._socket = socket.socket(type=socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", int(self._sender.url.rpartition(":")[2])))
        self._socket.settimeout(1.0)
        threading.Thread(target=self._relay, daemon=True).start()

    def publish(self, image: NDArray[np.uint8], t: float) -> None:
        self._sender.publish(self._paint(number_in(image)), t)

    def close(self) -> None:
        self._sender.close()

    def _relay(self) -> None:
        to = ("127.0.0.1", int(self.url.rpartition(":")[2]))
        with self._socket, suppress(TimeoutError):
            for number in count(1):
                data = self._socket.recv(65536)
                if number % self._lost_one_in:
                    self._socket.sendto(data, to)


@pytest.mark.parametrize(("paint", "lost_one_in"), [(textured, 200), (numbered, 11)])
def test_a_picture_damaged_by_loss_is_not_shown_nor_what_builds_on_it(
    paint: Callable[[int], NDArray[np.uint8]], lost_one_in: int
) -> None:
    """A decoder fills holes with what was there before: robots where they no longer are."""
    film, errors = Filming(Lossy(paint, lost_one_in), 100, 0.0), []
    with camera_at(film.url, latency=0.04) as camera:
        for frame in frames_of(camera):
            expected = paint(round(FPS * (frame.t_capture - film.taken[0]))).astype(int)
            errors.append(np.abs(frame.image - expected).mean())
    assert len(errors) >= 10
    assert max(errors) < 6.0  # of 255: what the codec costs; a hole is 20 to 50


def test_a_broken_jpeg_is_left_out_and_the_stream_goes_on() -> None:
    shown = [textured(number) for number in (7, 8, 9)]
    server, jpegs = MjpegServer(), [cv2.imencode(".jpg", one)[1].tobytes() for one in shown]
    one, two, three = jpegs
    half, hole = one[: len(one) // 2], one[:2000] + one[2500:]
    cycle = (one, half, two, hole, three, b"\xff\xd8" + b"junk" * 50)

    def send() -> None:
        for jpeg in cycle * 10:
            server.send(jpeg)
            time.sleep(0.02)
        server.close()

    threading.Thread(target=send, daemon=True).start()
    with camera_at(server.url) as camera:
        images = [frame.image for frame in frames_of(camera)]
    assert 10 < len(images) <= 30
    for image in images:
        assert min(np.abs(image - whole.astype(int)).mean() for whole in shown) < 6.0


def test_what_queued_up_before_opening_is_not_taken_for_fresh() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        threading.Thread(target=send_backlog, args=(server,), daemon=True).start()
        with camera_at(f"http://127.0.0.1:{server.getsockname()[1]}/") as camera:
            numbers = [number for number, _, _ in received(camera)]
    assert min(numbers) >= 19
    assert len(numbers) >= 8


def send_backlog(server: socket.socket) -> None:
    """Nineteen old pictures at once, then a new one every 40 ms."""
    connection, _ = server.accept()
    with connection:
        connection.recv(4096)
        kind = b"multipart/x-mixed-replace; boundary=b"
        connection.sendall(b"HTTP/1.0 200 OK\r\nContent-Type: " + kind + b"\r\n\r\n")
        connection.sendall(b"".join(part(number) for number in range(19)))
        for number in range(19, 30):
            time.sleep(0.04)
            connection.sendall(part(number))


def part(number: int) -> bytes:
    jpeg = cv2.imencode(".jpg", numbered(number))[1].tobytes()
    head = b"--b\r\nContent-Type: image/jpeg\r\nContent-Length: %d\r\n\r\n" % len(jpeg)
    return head + jpeg + b"\r\n"


def test_a_stream_that_falls_silent_has_failed() -> None:
    server = MjpegServer()
    with camera_at_after_first(server) as camera:
        list(received(camera))
        assert camera.outages[0].reason.endswith("broke off: no data for 1 s")
    server.close()


@contextmanager
def camera_at_after_first(server: MjpegServer) -> Iterator[NewestFrame]:
    server.publish(numbered(1), 0.0)
    threading.Timer(0.2, lambda: server.publish(numbered(2), 0.0)).start()
    with camera_at(server.url) as camera:
        yield camera
