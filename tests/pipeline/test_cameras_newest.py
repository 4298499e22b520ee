"""The newest-frame thread: what is unread is replaced, a lost camera is opened again."""

import threading
import time
from collections.abc import Callable, Iterator
from itertools import count

import numpy as np
import pytest

from pipeline.cameras import newest
from pipeline.cameras.newest import FrameReader, Habits, NewestFrame
from pipeline.cameras.reader import Picture
from pipeline.clock import MonotonicClock
from pipeline.errors import CameraError
from pipeline.ports import EndOfStream
from vision.frame import Frame

pytestmark = pytest.mark.realtime

CLOCK = MonotonicClock()
SIZE = (6, 4)
NOISE = np.random.default_rng(3)


def noisy(size: tuple[int, int] = SIZE) -> np.ndarray:
    return NOISE.integers(0, 255, (size[1], size[0], 3), np.uint8)


def picture(t: float, image: np.ndarray | None = None, stamp: float | None = None) -> Picture:
    return Picture(noisy() if image is None else image, t, t + 0.02, stamp)


class Script:
    """A reader that gives the pictures it is told, each when it is let go on."""

    def __init__(self, pictures: list[Picture], ending: Exception) -> None:
        self.turns, self.released = threading.Semaphore(0), threading.Event()
        self._pictures, self._ending = iter(pictures), ending

    def read(self) -> Picture:
        self.turns.acquire()
        one = next(self._pictures, None)
        if one is None:
            raise self._ending
        return one

    def release(self) -> None:
        self.released.set()


def opened(*scripts: FrameReader, habits: Habits = newest.USUAL) -> tuple[NewestFrame, list[str]]:
    """A camera that opens one script after the other, then none; and what it says."""
    waiting, said = iter(scripts), list[str]()

    def open_next() -> FrameReader:
        script = next(waiting, None)
        if script is None:
            raise CameraError("camera test: nobody is there")
        return script

    return NewestFrame("test", open_next, CLOCK, habits, said.append), said


def let(script: Script, camera: NewestFrame, pictures: int) -> None:
    goal = camera.report.frames + pictures
    script.turns.release(pictures)
    until(lambda: camera.report.frames >= goal)


def until(holds: Callable[[], bool]) -> None:
    end = time.monotonic() + 20.0
    while not holds():
        assert time.monotonic() < end
        time.sleep(0.001)


def handed_out(camera: NewestFrame) -> Iterator[Frame]:
    while True:
        if (frame := camera.latest(0.0)) is not None:
            yield frame
        time.sleep(0.001)


GONE = CameraError("camera test: gone")


@pytest.fixture(autouse=True)
def _short_pauses(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(newest, "FIRST_PAUSE", 0.01)
    monkeypatch.setattr(newest, "LONGEST_PAUSE", 0.04)


def test_the_newest_wins_and_is_given_once() -> None:
    script = Script([picture(t) for t in (0.1, 0.2, 0.3, 0.4)], EndOfStream("over"))
    camera, _ = opened(script)
    assert camera.latest(0.0) is None
    let(script, camera, 3)
    frame = camera.latest(1.0)
    assert frame is not None
    assert (frame.t_capture, frame.t_arrival) == (0.3, 0.32)
    assert (frame.sequence, frame.camera_id, frame.surely_new) == (2, "test", False)
    assert camera.latest(1.0) is None
    assert camera.report.dropped == 2
    let(script, camera, 1)
    script.turns.release()
    assert script.released.wait(5.0)
    assert camera.latest(1.0) is not None  # the last frame before the end
    for _ in range(2):
        with pytest.raises(EndOfStream):
            camera.latest(1.0)
    camera.close()
    camera.close()


def test_time_never_runs_backwards() -> None:
    times = [0.1, 0.3, 0.2, 0.3, 0.4]
    script = Script([picture(t) for t in times], EndOfStream("over"))
    (camera, _), given = opened(script), []
    for _ in times:
        let(script, camera, 1)
        frame = camera.latest(0.0)
        given += [] if frame is None else [frame.t_capture]
    assert given == [0.1, 0.3, 0.4]
    assert camera.report.dropped == 2
    script.turns.release()
    with pytest.raises(EndOfStream):
        next(handed_out(camera))


def test_a_picture_shown_twice_is_no_news_and_counted() -> None:
    still, stamped = noisy(), [picture(0.3, None, 7.0), picture(0.31, None, 7.0)]
    script = Script([picture(0.1, still), picture(0.2, still.copy()), *stamped], EndOfStream("."))
    (camera, _), given = opened(script), []
    for _ in range(4):
        let(script, camera, 1)
        frame = camera.latest(0.0)
        given += [] if frame is None else [frame.t_capture]
    assert given == [0.1, 0.3]
    assert (camera.report.duplicates, camera.report.dropped) == (2, 0)
    camera.close()


def test_a_lost_camera_comes_back_and_nothing_is_raised() -> None:
    first = Script([picture(0.1)], GONE)
    second = Script([picture(5.0), picture(5.1)], GONE)
    camera, said = opened(first, second)
    let(first, camera, 1)
    first.turns.release()
    until(lambda: bool(camera.outages))
    assert first.released.wait(5.0)
    assert next(handed_out(camera)).t_capture == 0.1
    assert camera.latest(0.0) is None
    assert camera.outages[0].t_back is None
    let(second, camera, 2)
    assert next(handed_out(camera)).t_capture == 5.1
    (outage,) = camera.outages
    assert (outage.reason, outage.t_back) == ("camera test: gone", 5.02)
    assert camera.report.reopenings == 1
    second.turns.release()
    until(lambda: "nobody is there" in "".join(said))
    time.sleep(0.2)  # further attempts fail for the same reason, which is told once
    assert [line.split(";")[0] for line in said] == [
        "camera test: gone", said[1], "camera test: gone", "camera test: nobody is there",
    ]  # fmt: skip
    assert "back after" in said[1]
    assert camera.latest(0.0) is None
    camera.close()


def test_pauses_double_up_to_the_longest(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(newest, "FIRST_PAUSE", 0.05)
    monkeypatch.setattr(newest, "LONGEST_PAUSE", 0.2)
    script, times = Script([picture(0.1)], GONE), list[float]()

    def vanish() -> FrameReader:
        times.append(time.monotonic())
        if len(times) == 1:
            return script
        raise GONE

    camera = NewestFrame("test", vanish, CLOCK, newest.USUAL, lambda _: None)
    script.turns.release(2)
    until(lambda: len(times) == 6)
    camera.close()
    least = (0.1, 0.2, 0.2, 0.2)  # a pause may be longer, never shorter
    assert all(np.diff(times[1:]) >= np.array(least) - 2e-3)
    assert times[5] - times[1] < 1.4  # s; it is 0.7, without a cap 1.5


def test_another_size_after_a_loss_is_refused_until_the_right_one_comes() -> None:
    wrong = [Script([picture(t, noisy((8, 4)))], GONE) for t in (2.0, 3.0)]
    right = Script([picture(4.0)], GONE)
    first = Script([picture(0.1)], GONE)
    camera, said = opened(first, *wrong, right)
    for script in (first, *wrong, right):
        script.turns.release(2 if script is first else 1)
    until(lambda: camera.report.reopenings == 1)
    assert "camera test: came back with 8 x 4 px, the run began with 6 x 4 px" in "".join(said)
    assert next(handed_out(camera)).size_px == SIZE
    assert camera.report.wrong_size == 2
    assert all(script.released.is_set() for script in wrong)
    camera.close()


def test_a_size_that_changes_in_between_is_dropped_and_counted() -> None:
    script = Script([picture(0.1), picture(0.2, noisy((8, 4))), picture(0.3)], GONE)
    camera, _ = opened(script)
    for expected in (0.1, None, 0.3):
        let(script, camera, 1)
        frame = camera.latest(0.0)
        assert (None if frame is None else frame.t_capture) == expected
    assert camera.report.wrong_size == 1
    assert not camera.outages
    camera.close()


@pytest.mark.parametrize(
    ("image", "words"),
    [(np.full((4, 6, 3), 9, np.uint8), "frozen"), (noisy((8, 4)), "has changed to 8 x 4 px")],
)
def test_a_camera_that_hangs_is_opened_again(
    image: np.ndarray, words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(newest, "NO_NEWS", 0.1)

    class Hanging:
        times = count(1)
        start = picture(0.1, np.full((4, 6, 3), 9, np.uint8))

        def read(self) -> Picture:
            time.sleep(0.01)
            now, number = CLOCK.now(), next(self.times)
            return Picture(self.start.image if number == 1 else image, now, now)

        def release(self) -> None: ...

    camera, said = opened(Hanging(), Script([], GONE))
    until(lambda: bool(camera.outages))
    assert words in camera.outages[0].reason
    assert said[0].endswith("it is opened again")
    camera.close()


def test_a_failure_to_open_is_raised_at_once() -> None:
    def refuse() -> FrameReader:
        raise CameraError("no such camera")

    with pytest.raises(CameraError, match="no such camera"):
        NewestFrame("test", refuse, CLOCK)


def test_opening_is_bounded_and_what_opens_too_late_is_released() -> None:
    script, gate = Script([], GONE), threading.Event()

    def slow() -> FrameReader:
        gate.wait()
        return script

    with pytest.raises(CameraError, match=r"camera test: did not open within 0.05 s"):
        NewestFrame("test", slow, CLOCK, Habits(timeout=0.05))
    gate.set()
    assert script.released.wait(5.0)


def test_a_picture_that_is_none_costs_a_reopening() -> None:
    bad = Script([picture(0.0, np.zeros((4, 6), np.uint8))], GONE)
    camera, said = opened(bad, Script([], GONE))
    bad.turns.release()
    until(lambda: bool(said))
    assert "camera test, frame 0: need a uint8 (H, W, 3) image" in said[0]
    camera.close()


class Broken(Script):
    """A reader that fails in a way no reader should."""

    def read(self) -> Picture:
        self.turns.acquire()
        raise ZeroDivisionError("a defect in the reader")


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
def test_a_defect_that_ends_the_thread_is_told() -> None:
    script = Broken([], GONE)
    camera, _ = opened(script)
    script.turns.release()
    with pytest.raises(CameraError, match="has stopped"):
        next(handed_out(camera))
    camera.close()


def test_a_rate_below_what_was_asked_is_told_once() -> None:
    script = Script([picture(n / 10.0) for n in range(100)], GONE)
    camera, said = opened(script, habits=Habits(fps=30.0, slow_hint=": more light"))
    let(script, camera, 100)
    assert said == ["camera test: 10.0 frames/s come, 30 were asked for: more light"]
    assert camera.report.fps == pytest.approx(10.0)
    camera.close()
