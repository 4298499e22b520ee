"""How far long work has come: a bar on one line of the terminal."""

import sys
import time

INTERVAL = 0.2  # between two drawings [s]
WIDTH = 40  # of the bar, in letters


class Bar:
    """Rewrites one line of stderr, if that is a terminal."""

    def __init__(self, total: int, what: str) -> None:
        """Prepare the line.

        Args:
            total: how much there is to do, > 0.
            what: its name, e.g. "runs".
        """
        self._total, self._what, self._done = total, what, 0
        self._began = self._shown = time.monotonic()
        self._active = sys.stderr.isatty()

    def advance(self, done: int) -> None:
        """Draw the line again if the last one is old enough.

        Args:
            done: how much more is done.
        """
        self._done += done
        now = time.monotonic()
        if not self._active or now - self._shown < INTERVAL:
            return
        self._shown, share = now, self._done / self._total
        left = (now - self._began) * (1.0 - share) / share
        bar = ("#" * round(WIDTH * share)).ljust(WIDTH, ".")
        sys.stderr.write(f"\r[{bar}] {self._done} of {self._total} {self._what}, {left:.0f} s left  ")
        sys.stderr.flush()

    def close(self) -> None:
        """Leave a clean line. Safe to call twice."""
        if self._active:
            sys.stderr.write("\r" + " " * (WIDTH + 60) + "\r")
            sys.stderr.flush()
        self._active = False
