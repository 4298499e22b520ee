"""Network cameras that go away and come back, on real sockets: nothing is raised, all is told."""

import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
import pytest

from pipeline.calibration.pictures import camera_frames
from pipeline.cameras.newest import NewestFrame
from pipeline.cameras.stream import open_stream
from pipeline.clock import MonotonicClock
from pipeline.errors import CameraError
from tests.hardware.streams import MjpegServer
from vision.frame import Frame

pytestmark = pytest.mark.realtime

CLOCK = MonotonicClock()
SIZE = (96, 64)


@pytest.fixture(autouse=True)
def _impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pipeline.cameras.stream.READ_TIMEOUT", 0.5)


class Filming:
    """Films noise through a server until it is stopped."""

    def __init__(self, port: int = 0, size: tuple[int, int] = SIZE, still: bool = False) -> None:
        self.server, self._size, self._still = MjpegServer(port=port), size, still
        self._stop, self._thread = threading.Event(), threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        noise = np.random.default_rng(int(1e6 * CLOCK.now()))
        image = noise.integers(0, 255, (self._size[1], self._size[0], 3), np.uint8)
        while not self._stop.wait(0.02):
            self.server.publish(image, 0.0)
            if not self._still:
                image = noise.integers(0, 255, image.shape, np.uint8)

    def kill(self) -> None:
        """Stop filming and serving."""
        self._stop.set()
        self._thread.join()
        self.server.close()


@contextmanager
def filming(port: int = 0, size: tuple[int, int] = SIZE, still: bool = False) -> Iterator[Filming]:
    film = Filming(port, size, still)
    try:
        yield film
    finally:
        film.kill()


@contextmanager
def watched(url: str) -> Iterator[NewestFrame]:
    camera = open_stream(url, CLOCK)
    try:
        yield camera
    finally:
        camera.close()


def until(holds: Callable[[], bool]) -> None:
    end = time.monotonic() + 20.0
    while not holds():
        assert time.monotonic() < end
        time.sleep(0.005)


def seen(camera: NewestFrame) -> Frame:
    """The next frame."""
    frames: list[Frame] = []
    until(lambda: (frame := camera.latest(CLOCK.now())) is not None and not frames.append(frame))
    return frames[0]


def test_a_server_that_was_killed_and_started_again(capfd: pytest.CaptureFixture[str]) -> None:
    with filming() as film, watched(film.server.url) as camera:
        before = seen(camera)
        film.kill()
        until(lambda: bool(camera.outages))
        while camera.latest(CLOCK.now()) is not None:
            pass
        time.sleep(0.6)
        assert camera.latest(CLOCK.now()) is None  # not an error
        with filming(film.server.port):
            after = seen(camera)
            report, outages = camera.report, camera.outages
    assert after.t_capture > before.t_capture + 0.6
    assert after.sequence > before.sequence
    assert (report.reopenings, len(outages)) == (1, 1)
    assert report.delay_p50 is not None
    assert 0.0 <= report.delay_p50 < 0.1
    said = capfd.readouterr().err
    assert "it is opened again" in said
    assert "back after" in said


def test_a_server_that_comes_back_with_another_size_is_refused() -> None:
    with filming() as film, watched(film.server.url) as camera:
        seen(camera)
        film.kill()
        until(lambda: bool(camera.outages))
        while camera.latest(CLOCK.now()) is not None:
            pass
        with filming(film.server.port, (64, 48)):
            until(lambda: camera.report.wrong_size >= 2)
            assert camera.latest(CLOCK.now()) is None
        with filming(film.server.port):
            assert seen(camera).size_px == SIZE
    assert camera.report.reopenings == 1


def test_a_frozen_picture_is_no_frame_and_the_camera_is_opened_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("pipeline.cameras.newest.NO_NEWS", 0.3)
    with filming(still=True) as film, watched(film.server.url) as camera:
        seen(camera)
        assert camera.latest(CLOCK.now()) is None
        until(lambda: bool(camera.outages))
        assert "frozen" in camera.outages[0].reason
        assert camera.latest(CLOCK.now()) is None
        assert camera.report.duplicates > 5


def test_a_calibration_does_not_wait_for_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pipeline.calibration.pictures.SILENT", 0.5)
    with filming() as film:
        frames = camera_frames(film.server.url, None, lambda: False)
        assert next(frames).size_px == SIZE
        film.kill()
        with pytest.raises(CameraError, match="no frame for"):
            list(frames)


def test_a_server_that_accepts_and_never_answers_again_does_not_block() -> None:
    with filming() as film, watched(film.server.url) as camera:
        seen(camera)
        film.kill()
        until(lambda: bool(camera.outages))
        with socket.create_server(("127.0.0.1", film.server.port)) as dead:
            connection, _ = dead.accept()  # it is asked again
            with connection:
                start = time.monotonic()
                camera.latest(CLOCK.now())
                assert time.monotonic() - start < 0.1
                assert camera.outages[-1].t_back is None
                close_start = time.monotonic()
                camera.close()
                assert time.monotonic() - close_start < 2.0  # 1 s by promise
