"""Counting what a camera delivers: frames, their rate and their age on arrival."""

from collections import deque

import numpy as np

from pipeline.cameras.report import CameraReport, is_slow

DELAYS = 4096  # of the latest frames are kept for the quantiles
PATIENCE = 3.0  # a rate is judged over so long [s]


class Tally:
    """Counts for one camera; who shares it between threads holds a lock.

    Attributes:
        dropped: frames passed over, or out of order.
        duplicates: frames that showed the picture before.
        wrong_size: frames of another size.
        reopenings: times the camera came back.
    """

    def __init__(self, asked_fps: float | None = None) -> None:
        """Start at zero.

        Args:
            asked_fps: frames per second asked for, None if nothing was [1/s].
        """
        self.dropped = self.duplicates = self.wrong_size = self.reopenings = 0
        self._asked = asked_fps
        self._frames, self._steps, self._seconds = 0, 0, 0.0
        self._before: float | None = None
        self._window: tuple[int, float] | None = 0, 0.0  # steps and seconds when it began
        self._delays: deque[float] = deque(maxlen=DELAYS)

    @property
    def frames(self) -> int:
        """Frames received so far."""
        return self._frames

    @property
    def report(self) -> CameraReport:
        """What was counted so far."""
        fps = self._steps / self._seconds if self._seconds > 0.0 else None
        middle, high = np.percentile(self._delays, (50, 99)) if self._delays else (None, None)
        return CameraReport(
            self._frames, self.dropped, self.duplicates, self.wrong_size, self.reopenings,
            fps, self._asked, _plain(middle), _plain(high),
        )  # fmt: skip

    def receive(self, t_capture: float, t_arrival: float) -> None:
        """Count a frame.

        Args:
            t_capture: when it was taken [s].
            t_arrival: when it was at hand [s].
        """
        self._frames += 1
        self._delays.append(t_arrival - t_capture)
        if self._before is not None:
            self._steps += 1
            self._seconds += t_arrival - self._before
        self._before = t_arrival

    def interrupt(self) -> None:
        """The camera is away: the time until its next frame says nothing about its rate."""
        self._before = None
        self._window = self._steps, self._seconds

    def slow_rate(self) -> float | None:
        """Judge the rate once, after some seconds in a row.

        Returns:
            Frames per second if the camera is slower than asked, else, or if this was told since
            it was last away, None [1/s].
        """
        if self._window is None or self._seconds - self._window[1] < PATIENCE:
            return None
        fps = (self._steps - self._window[0]) / (self._seconds - self._window[1])
        slow = is_slow(fps, self._asked)
        self._window = None if slow else (self._steps, self._seconds)
        return fps if slow else None


def _plain(value: float | None) -> float | None:
    return None if value is None else float(value)
