"""From a stream's own timestamps to capture times on the run's clock."""

from math import inf

WINDOW = 5.0  # the smallest delay is sought over the last one to two windows [s]


class StreamTiming:
    """Maps presentation timestamps to the run's clock by the smallest delay seen.

    A frame arrives late by transport jitter, never early, so the smallest arrival - timestamp of
    the last five to ten seconds is the offset between the clocks, up to the constant latency.
    The window lets the offset follow the drift of the sender's clock (50 ppm: 0.5 ms in 10 s).
    A frame held up for seconds is dated as old as it is. Only timestamps that run backwards, of a
    camera that has restarted, make all that was known void.
    """

    def __init__(self, latency: float) -> None:
        """Start without knowledge.

        Args:
            latency: from the picture to its earliest arrival [s].
        """
        self._latency = latency
        self._before, self._current, self._since = inf, inf, -inf
        self._newest = -inf

    def capture_time(self, timestamp: float | None, arrival: float) -> float:
        """Say when a frame was taken.

        Args:
            timestamp: the stream's own time of the frame [s]; None if it has none.
            arrival: when it arrived, on the run's clock [s].

        Returns:
            The capture time on the run's clock [s]; never later than arrival - latency.
        """
        if timestamp is None:
            return arrival - self._latency
        if timestamp < self._newest:
            self._before, self._current, self._since = inf, inf, arrival
        elif arrival - self._since > WINDOW:
            self._before, self._current, self._since = self._current, inf, arrival
        self._newest = timestamp
        self._current = min(self._current, arrival - timestamp)
        return timestamp + min(self._before, self._current) - self._latency
