"""The commands already sent to a robot."""

from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass

from control.errors import ControlError
from control.unicycle import Twist

KEEP = 1.0
"""How long sent commands are remembered [s]: longer than any frame is old."""

_STANDSTILL = Twist(0.0, 0.0)


@dataclass(frozen=True, slots=True)
class SentCommands:
    """Commands of one robot with the times from which they hold, oldest first. Immutable.

    Attributes:
        times: when each command takes effect, ascending [s].
        twists: the commands [m/s, rad/s].
    """

    times: tuple[float, ...] = ()
    twists: tuple[Twist, ...] = ()

    def append(self, t_effective: float, twist: Twist) -> "SentCommands":
        """History with one more command, without those nobody can ask for any more.

        Args:
            t_effective: when the command takes effect; not before the last one [s].
            twist: the command [m/s, rad/s].

        Returns:
            The longer history; at least KEEP seconds of it stay.

        Raises:
            ControlError: if the command is older than the last one.
        """
        if self.times and t_effective < self.times[-1]:
            raise ControlError(f"command for {t_effective} s sent after one for {self.times[-1]} s")
        # the command in force KEEP seconds ago must stay
        first = max(bisect_right(self.times, t_effective - KEEP) - 1, 0)
        return SentCommands((*self.times[first:], t_effective), (*self.twists[first:], twist))

    def in_force(self, t: float) -> Twist:
        """The command in force at a time.

        Args:
            t: time [s].

        Returns:
            The last command that took effect by t; standstill before the first [m/s, rad/s].
        """
        index = bisect_right(self.times, t)
        return self.twists[index - 1] if index else _STANDSTILL

    def between(self, t0: float, t1: float) -> Iterator[tuple[float, Twist]]:
        """The commands in force during an interval.

        Args:
            t0: start [s].
            t1: end; nothing is yielded unless t1 > t0 [s].

        Yields:
            How long each command holds within the interval, and the command [s; m/s, rad/s].
        """
        index = bisect_right(self.times, t0)
        while t0 < t1:
            end = min(self.times[index], t1) if index < len(self.times) else t1
            yield end - t0, self.twists[index - 1] if index else _STANDSTILL
            t0, index = end, index + 1
