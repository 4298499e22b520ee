"""How far a run or a computation has come, on one line of the terminal."""

import sys
import time
from math import degrees

from control.geometry import wrap_angle
from datasets.cycle import Moment, PairState

INTERVAL = 0.2  # between two lines [s]
_WIDTH, _BAR = 118, 40  # characters


class _Line:
    """One line of stderr that is written again and again, if that is a terminal."""

    def __init__(self) -> None:
        self._shown = 0.0
        self._active = sys.stderr.isatty()

    def due(self) -> bool:
        """Whether the line is to be seen and the last one is old enough."""
        return self._active and time.monotonic() - self._shown >= INTERVAL

    def show(self, text: str) -> None:
        """Rewrite the line."""
        self._shown = time.monotonic()
        sys.stderr.write("\r" + text[:_WIDTH].ljust(_WIDTH))
        sys.stderr.flush()

    def close(self) -> None:
        """Leave a clean line. Safe to call twice."""
        if self._active and self._shown:
            sys.stderr.write("\r" + " " * _WIDTH + "\r")
            sys.stderr.flush()
        self._active = False


class Progress:
    """An observer that says how far a run has come."""

    def __init__(self, duration: float | None) -> None:
        """Prepare the line.

        Args:
            duration: of the run; None: unknown [s].
        """
        self._duration = duration
        self._line = _Line()

    def observe(self, moment: Moment) -> None:
        """Rewrite the line if the last one is old enough.

        Args:
            moment: the cycle.
        """
        if not self._line.due():
            return
        end = "" if self._duration is None else f" of {self._duration:.1f}"
        errors = "  ".join(_error(pair) for pair in moment.cycle.pairs)
        self._line.show(f"{moment.tick.t:6.1f}{end} s  {moment.cycle.phase:<9}  {errors}")

    def close(self) -> None:
        """Leave a clean line. Safe to call twice."""
        self._line.close()


class ShareLine:
    """Says which share of a computation is done."""

    def __init__(self, what: str) -> None:
        """Prepare the line.

        Args:
            what: is computed.
        """
        self._what = what
        self._line = _Line()

    def show(self, share: float) -> None:
        """Rewrite the line if the last one is old enough.

        Args:
            share: that is done, 0 to 1.
        """
        if self._line.due():
            bar = "#" * round(_BAR * share)
            self._line.show(f"{self._what}  {bar:.<{_BAR}} {100.0 * share:3.0f} %")

    def close(self) -> None:
        """Leave a clean line. Safe to call twice."""
        self._line.close()


def _error(pair: PairState) -> str:
    """A pair's errors in words."""
    distance = 1e3 * (pair.reference.distance - pair.relative.distance)
    bearing = degrees(wrap_angle(pair.reference.bearing - pair.relative.bearing))
    return f"{pair.leader}<-{pair.follower} {distance:+5.0f} mm {bearing:+5.1f} deg"
