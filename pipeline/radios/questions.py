"""How long a robot takes to answer: a question at a low rate, one at a time."""

import threading
from collections import deque
from math import inf
from statistics import median

from pipeline.radios.report import RoundTrip

PERIOD = 0.5  # between two questions that are answered [s]
PATIENCE = 0.5  # an answer that takes longer has not come, and it is asked again at once [s]
SILENT = 2  # questions in a row that a robot may leave unanswered, once it has answered
KEPT = 256  # answers the median is of


class Questions:
    """Keeps the one question that is out, and the times of the answers. Any thread may call it."""

    def __init__(self, period: float = PERIOD) -> None:
        """Start with a question due.

        Args:
            period: between two questions [s].
        """
        self._period, self._lock = period, threading.Condition()
        self._next = -inf
        self._out: float | None = None
        self._answers: deque[float] = deque(maxlen=KEPT)
        self._answered, self._unanswered, self._missed, self._longest = 0, 0, 0, 0.0

    def due(self, now: float) -> bool:
        """Whether it is time to ask; what is out for too long is given up.

        Args:
            now: present time [s].

        Returns:
            True if the next question may go.
        """
        with self._lock:
            if self._out is not None and now - self._out >= PATIENCE:
                self._out, self._next = None, -inf
                self._unanswered, self._missed = self._unanswered + 1, self._missed + 1
            return self._out is None and now >= self._next

    def ask_soon(self) -> None:
        """Make the next question due at once."""
        with self._lock:
            self._next = -inf

    def asked(self, now: float) -> None:
        """Note that a question is being sent.

        Args:
            now: present time [s].
        """
        with self._lock:
            self._out, self._next = now, now + self._period

    def answered(self, now: float) -> None:
        """Note an answer; one that nobody waits for is only a sign of life.

        Args:
            now: present time [s].
        """
        with self._lock:
            self._missed = 0
            if self._out is None:
                return
            took, self._out = now - self._out, None
            self._answers.append(took)
            self._answered, self._longest = self._answered + 1, max(self._longest, took)
            self._lock.notify_all()

    def dropped(self) -> None:
        """Forget the question that is out: its link is gone, and no answer can come."""
        with self._lock:
            self._unanswered += self._out is not None
            self._out, self._missed = None, 0

    def is_out(self, now: float, patience: float) -> bool:
        """Whether an answer may come any moment.

        Args:
            now: present time [s].
            patience: answers later than this are not worth watching for [s].

        Returns:
            True if a question younger than that is out.
        """
        out = self._out
        return out is not None and now - out < patience

    def answered_within(self, timeout: float) -> bool:
        """Wait for a further answer.

        Args:
            timeout: longest wait [s].

        Returns:
            Whether one came.
        """
        with self._lock:
            before = self._answered
            return self._lock.wait_for(lambda: self._answered > before, timeout)

    @property
    def silent(self) -> bool:
        """Whether a robot that has answered before does so no longer."""
        with self._lock:
            return self._answered > 0 and self._missed >= SILENT

    @property
    def tally(self) -> RoundTrip:
        """All so far."""
        with self._lock:
            some = bool(self._answers)
            return RoundTrip(
                self._answered + self._unanswered,
                self._unanswered,
                median(self._answers) if some else None,
                self._longest if some else None,
            )
