"""The two clocks a run can have: the machine's, and one that jumps."""

import time

AWAKE = 0.001  # before a moment the processor stays busy: warm caches, a punctual tick [s]


class MonotonicClock:
    """Real time: the machine's monotonic clock, zero when it is first read."""

    def __init__(self) -> None:
        """Wait for the first reading: a run's time begins with the run, not with its opening."""
        self._started: float | None = None

    @property
    def _origin(self) -> float:
        if self._started is None:
            self._started = time.monotonic()
        return self._started

    def now(self) -> float:
        """Present time.

        Returns:
            Seconds since the first reading [s].
        """
        origin = self._origin  # before the reading: the first one is exactly 0
        return max(0.0, time.monotonic() - origin)

    def wait_until(self, t: float) -> float:
        """Sleep until shortly before a moment, and stay awake for the rest.

        Args:
            t: when to wake [s].

        Returns:
            The slack that was left on arrival [s]; negative, without sleeping, if t had passed.
        """
        slack = t - self.now()
        if slack > AWAKE:
            time.sleep(slack - AWAKE)
        while self.now() < t:
            time.sleep(0.0)  # other threads may run
        return slack


class VirtualClock:
    """Time that passes only by waiting, for runs as fast as they go."""

    def __init__(self) -> None:
        """Start at zero."""
        self._now = 0.0

    def now(self) -> float:
        """Present time.

        Returns:
            The latest moment waited for [s].
        """
        return self._now

    def wait_until(self, t: float) -> float:
        """Jump to a moment.

        Args:
            t: where to jump [s].

        Returns:
            The slack jumped over [s]; negative, without a jump, if t had passed.
        """
        slack = t - self._now
        if slack > 0.0:
            self._now = t
        return slack
