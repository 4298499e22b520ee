"""How far a run has come, on one line of the terminal."""

import sys
import time
from math import degrees

from control.geometry import wrap_angle
from datasets.cycle import Moment, PairState

INTERVAL = 0.2  # between two lines [s]


class Progress:
    """An observer that rewrites one line of stderr, if that is a terminal."""

    def __init__(self, duration: float | None) -> None:
        """Prepare the line.

        Args:
            duration: of the run; None: unknown [s].
        """
        self._duration = duration
        self._shown = 0.0
        self._active = sys.stderr.isatty()

    def observe(self, moment: Moment) -> None:
        """Rewrite the line if the last one is old enough.

        Args:
            moment: the cycle.
        """
        now = time.monotonic()
        if not self._active or now - self._shown < INTERVAL:
            return
        self._shown = now
        end = "" if self._duration is None else f" of {self._duration:.1f}"
        errors = "  ".join(_error(pair) for pair in moment.cycle.pairs)
        line = f"{moment.tick.t:6.1f}{end} s  {moment.cycle.phase:<9}  {errors}"
        sys.stderr.write("\r" + line[:118].ljust(118))
        sys.stderr.flush()

    def close(self) -> None:
        """Leave a clean line. Safe to call twice."""
        if self._active and self._shown:
            sys.stderr.write("\r" + " " * 118 + "\r")
            sys.stderr.flush()
        self._active = False


def _error(pair: PairState) -> str:
    """A pair's errors in words."""
    distance = 1e3 * (pair.reference.distance - pair.relative.distance)
    bearing = degrees(wrap_angle(pair.reference.bearing - pair.relative.bearing))
    return f"{pair.leader}<-{pair.follower} {distance:+5.0f} mm {bearing:+5.1f} deg"
