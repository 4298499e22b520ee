"""A blocking reader in a thread that keeps only its newest frame: shared by devices and streams.

Once it was open, a camera that is lost is opened again until it comes back; meanwhile there is no
new frame, which the safety rules take for what it is.
"""

import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from pipeline.cameras.outages import Outage, Outages
from pipeline.cameras.reader import FrameReader, Picture
from pipeline.cameras.report import CameraReport
from pipeline.cameras.sieve import Repeats, Sieve, Verdict
from pipeline.cameras.tally import Tally
from pipeline.errors import CameraError
from pipeline.notice import tell
from pipeline.ports import Clock, EndOfStream
from vision.errors import VisionError
from vision.frame import Frame, as_frame

CLOSE_TIMEOUT = 1.0  # a reader that blocks longer is left to its daemon thread [s]
FIRST_PAUSE, LONGEST_PAUSE = 0.25, 4.0  # between attempts to open it again, doubling [s]
NO_NEWS = 2.0  # pictures that are no news for longer: the camera hangs [s]


@dataclass(frozen=True, slots=True)
class Habits:
    """What is expected of a camera.

    Attributes:
        timeout: longest wait for its first opening [s].
        fps: frames per second asked for, None if it is not known [1/s].
        repeats: what makes a picture the one before.
        slow_hint: what is usually the matter if it is slower than asked.
    """

    timeout: float = 5.0
    fps: float | None = None
    repeats: Repeats = "pixels"
    slow_hint: str = ""


USUAL = Habits()


class NewestFrame:
    """A frame source that reads in its own thread and never queues: an unread frame is replaced.

    Attributes:
        camera_id: name put on the frames.
    """

    def __init__(
        self,
        camera_id: str,
        open_reader: Callable[[], FrameReader],
        clock: Clock,
        habits: Habits = USUAL,
        say: Callable[[str], None] = tell,
    ) -> None:
        """Open the reader in its thread and wait for it.

        Args:
            camera_id: name for frames and messages.
            open_reader: opens the device, at every loss again; raises CameraError.
            clock: the run's clock.
            habits: what is expected of the camera.
            say: takes a line for the user.

        Raises:
            CameraError: if it cannot be opened, or not in time.
        """
        self.camera_id = camera_id
        self._open_reader, self._clock, self._habits = open_reader, clock, habits
        self._say = say
        self._lock = threading.Lock()
        self._opened, self._closing = threading.Event(), threading.Event()
        self._frame: Frame | None = None
        self._failure: CameraError | EndOfStream | None = None
        self._sieve, self._tally = Sieve(habits.repeats), Tally(habits.fps)
        self._outages = Outages(camera_id)
        self._up, self._t_news = False, 0.0
        self._thread = threading.Thread(target=self._run, name=f"camera {camera_id}", daemon=True)
        self._thread.start()
        self._await_opening(habits.timeout)

    @property
    def report(self) -> CameraReport:
        """What was delivered so far."""
        with self._lock:
            return self._tally.report

    @property
    def outages(self) -> tuple[Outage, ...]:
        """When the camera was away, the present outage last."""
        with self._lock:
            return self._outages.all

    def latest(self, now: float) -> Frame | None:  # noqa: ARG002 - what is here has arrived by now
        """Hand out the newest frame not handed out before.

        Args:
            now: the moment of the cycle [s].

        Returns:
            The newest frame, None if there is no new one; also while the camera is lost.

        Raises:
            CameraError: if its reader has stopped for good.
            EndOfStream: if it has ended as planned; the last frame is handed out first.
        """
        with self._lock:
            frame, self._frame = self._frame, None
            if frame is None and self._failure is not None:
                raise self._failure
            return frame

    def close(self) -> None:
        """Release the device. Safe to call twice; does not wait for a reader that hangs."""
        self._closing.set()
        self._thread.join(CLOSE_TIMEOUT)

    def _await_opening(self, timeout: float) -> None:
        in_time = self._opened.wait(timeout)
        failure = self._failure
        if in_time and failure is None:
            return
        self._closing.set()
        raise failure or CameraError(f"camera {self.camera_id}: did not open within {timeout:g} s")

    def _run(self) -> None:
        try:
            self._keep_open()
        except (CameraError, EndOfStream) as error:
            self._fail(error)
        finally:  # whatever else ended this thread must not look like a camera without news
            self._fail(CameraError(f"camera {self.camera_id}: its reader has stopped"))

    def _keep_open(self) -> None:
        pause = FIRST_PAUSE
        while not self._closing.is_set():
            try:
                self._read_all(self._open_reader())
            except CameraError as error:
                if not self._opened.is_set():
                    raise
                pause = FIRST_PAUSE if self._up else min(2.0 * pause, LONGEST_PAUSE)
                self._lose(error)
            self._closing.wait(pause)

    def _read_all(self, reader: FrameReader) -> None:
        self._opened.set()
        self._t_news = self._clock.now()
        try:
            while not self._closing.is_set():
                self._take(reader.read())
        finally:
            reader.release()

    def _take(self, picture: Picture) -> None:
        """Judge a picture and keep it if it is news."""
        try:
            frame = as_frame(
                picture.image, picture.t_capture, self._tally.frames, self.camera_id,
                picture.t_arrival, self._sieve.vouches(picture.stamp),
            )  # fmt: skip
        except VisionError as error:
            raise CameraError(f"camera {error}") from error
        verdict = self._sieve.judge(frame, picture.stamp)
        with self._lock:
            lines = [*self._book(verdict, frame), *self._judged_rate()]
        for line in lines:  # outside: a terminal that blocks must not block the loop
            self._say(line)
        if verdict is not Verdict.NEW:
            self._bear(verdict, frame)

    def _book(self, verdict: Verdict, frame: Frame) -> Iterator[str]:
        """Count a frame; keep it if it is new. Yields what is to be told."""
        arrival, tally = frame.t_arrival or 0.0, self._tally
        tally.receive(frame.t_capture, arrival)
        tally.duplicates += verdict is Verdict.DUPLICATE
        tally.wrong_size += verdict is Verdict.WRONG_SIZE
        tally.dropped += verdict is Verdict.LATE
        if verdict is not Verdict.NEW:
            return
        tally.dropped += self._frame is not None
        self._frame, self._up, self._t_news = frame, True, arrival
        if self._outages.away:
            tally.reopenings += 1
            yield self._outages.end(arrival)

    def _judged_rate(self) -> Iterator[str]:
        fps, habits = self._tally.slow_rate(), self._habits
        if fps is not None:
            yield (
                f"camera {self.camera_id}: {fps:.1f} frames/s come, {habits.fps:g} were asked "
                f"for{habits.slow_hint}"
            )

    def _bear(self, verdict: Verdict, frame: Frame) -> None:
        """Put up with pictures that are no news, but not for ever."""
        if verdict is Verdict.WRONG_SIZE and not self._up:
            raise CameraError(f"camera {self.camera_id}: came back with {self._sizes(frame)}")
        if (frame.t_arrival or 0.0) - self._t_news <= NO_NEWS:
            return
        why = {
            Verdict.DUPLICATE: "shows one picture, bit for bit (frozen? If a strong codec makes "
            'still scenes so: camera.repeats = "stamps")',
            Verdict.WRONG_SIZE: f"has changed to {self._sizes(frame)}",
            Verdict.LATE: "gives pictures with times that run backwards",
        }[verdict]
        raise CameraError(f"camera {self.camera_id}: for {NO_NEWS:g} s it {why}")

    def _sizes(self, frame: Frame) -> str:
        (width, height), (w, h) = frame.size_px, self._sieve.size_px or (0, 0)
        return f"{width} x {height} px, the run began with {w} x {h} px"

    def _lose(self, error: CameraError) -> None:
        with self._lock:
            self._up = False
            self._sieve.restart()
            self._tally.interrupt()
            line = self._outages.lose(str(error), self._clock.now())
        if line is not None:
            self._say(line)

    def _fail(self, error: CameraError | EndOfStream) -> None:
        with self._lock:
            self._failure = self._failure or error
        self._opened.set()
