"""The newest-frame thread: what is unread is replaced, failures are told after the last frame."""

import threading
import time
from collections.abc import Callable, Iterator

import numpy as np
import pytest

from pipeline.cameras.newest import FrameReader, NewestFrame, Picture
from pipeline.errors import CameraError
from pipeline.ports import EndOfStream
from vision.frame import Frame

pytestmark = pytest.mark.realtime


class Script:
    """A reader that gives pictures with the times it is told, each when it is let go on."""

    def __init__(self, times: list[float], ending: Exception) -> None:
        self.turns, self.released = threading.Semaphore(0), threading.Event()
        self._times, self._ending = iter(times), ending

    def read(self) -> Picture:
        self.turns.acquire()
        t = next(self._times, None)
        if t is None:
            raise self._ending
        return Picture(np.full((4, 6, 3), 7, np.uint8), t)

    def release(self) -> None:
        self.released.set()


def opened(script: FrameReader) -> NewestFrame:
    return NewestFrame("test", lambda: script)


def let(script: Script, camera: NewestFrame, pictures: int) -> None:
    goal = camera.received + pictures
    script.turns.release(pictures)
    while camera.received < goal:
        time.sleep(0.001)


def handed_out(camera: NewestFrame) -> Iterator[Frame]:
    while True:
        if (frame := camera.latest(0.0)) is not None:
            yield frame
        time.sleep(0.001)


def test_the_newest_wins_and_is_given_once() -> None:
    script = Script([0.1, 0.2, 0.3, 0.4], CameraError("gone"))
    camera = opened(script)
    assert camera.latest(0.0) is None
    let(script, camera, 3)
    frame = camera.latest(1.0)
    assert frame is not None
    assert (frame.t_capture, frame.sequence, frame.camera_id) == (0.3, 2, "test")
    assert camera.latest(1.0) is None
    assert camera.dropped == 2
    let(script, camera, 1)
    script.turns.release()
    assert script.released.wait(5.0)
    assert camera.latest(1.0) is not None  # the last frame before the failure
    for _ in range(2):
        with pytest.raises(CameraError, match="gone"):
            camera.latest(1.0)
    camera.close()
    camera.close()


def test_time_never_runs_backwards() -> None:
    script = Script([0.1, 0.3, 0.2, 0.3, 0.4], EndOfStream("over"))
    camera, given = opened(script), []
    for _ in range(5):
        let(script, camera, 1)
        frame = camera.latest(0.0)
        given += [] if frame is None else [frame.t_capture]
    assert given == [0.1, 0.3, 0.4]
    assert camera.dropped == 2
    script.turns.release()
    with pytest.raises(EndOfStream):
        next(handed_out(camera))


def test_a_failure_to_open_is_raised_at_once() -> None:
    def refuse() -> FrameReader:
        raise CameraError("no such camera")

    with pytest.raises(CameraError, match="no such camera"):
        NewestFrame("test", refuse)


def test_opening_is_bounded_and_what_opens_too_late_is_released() -> None:
    script, gate = Script([], CameraError("gone")), threading.Event()

    def slow() -> FrameReader:
        gate.wait()
        return script

    with pytest.raises(CameraError, match=r"camera test: did not open within 0.05 s"):
        NewestFrame("test", slow, timeout=0.05)
    gate.set()
    assert script.released.wait(5.0)


def bad_picture() -> Picture:
    return Picture(np.zeros((4, 6), np.uint8), 0.0)


def defect() -> Picture:
    raise ZeroDivisionError("a defect in the reader")


class Broken(Script):
    """A reader that fails in a way no reader should."""

    def __init__(self, failure: Callable[[], Picture]) -> None:
        super().__init__([], CameraError("gone"))
        self._failure = failure

    def read(self) -> Picture:
        self.turns.acquire()
        return self._failure()


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
@pytest.mark.parametrize(
    ("failure", "words"),
    [(bad_picture, r"need a uint8 \(H, W, 3\) image"), (defect, "has stopped")],
)
def test_whatever_ends_the_thread_is_told(failure: Callable[[], Picture], words: str) -> None:
    script = Broken(failure)
    camera = opened(script)
    script.turns.release()
    with pytest.raises(CameraError, match=words):
        next(handed_out(camera))
    camera.close()
