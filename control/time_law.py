"""Time laws: how far along its curve a plan is at a time.

A plan is p(t) = P(S(t)). At a standstill p has no direction, so P never stands still: S' falls to
0 instead, and heading and curvature are those of P. On the way S' is 1.
"""

from dataclasses import dataclass, field

import numpy as np
import scipy

from control.motion_model import Array


@dataclass(frozen=True, slots=True)
class TimeLaw:
    """S' as cubics between breaks.

    Attributes:
        times: of the breaks, from 0 to the duration [s].
        paces: S' there, 0 to 1 [1].
        slopes: S'' there [1/s].
    """

    times: tuple[float, ...]
    paces: tuple[float, ...]
    slopes: tuple[float, ...]
    _way: "scipy.interpolate.PPoly" = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        pace = scipy.interpolate.CubicHermiteSpline(self.times, self.paces, self.slopes)
        object.__setattr__(self, "_way", pace.antiderivative())

    @property
    def duration(self) -> float:
        """Where the law ends [s]."""
        return self.times[-1]

    @property
    def end(self) -> float:
        """S at the end [s]."""
        return float(self._way(self.duration))

    def at(self, t: Array) -> Array:
        """S and its derivatives; those of the ends outside the law.

        Args:
            t: (n,) times [s].

        Returns:
            (3, n): S, S', S'' [s, 1, 1/s].
        """
        inside = t.clip(0.0, self.duration)
        s, pace, slope = (self._way(inside, order) for order in range(3))
        pace = np.where(inside < self.duration, pace.clip(0.0, 1.0), self.paces[-1])
        return np.array([s.clip(0.0, self.end), pace, slope])

    def rest(self, t: float) -> "TimeLaw":
        """What is left of the law after a time: what is left of a cubic is a cubic.

        Args:
            t: 0 <= t < duration [s].

        Returns:
            The same S' from t on.
        """
        _, pace, slope = self.at(np.array([t]))[:, 0].tolist()
        later = sum(at <= t for at in self.times)
        times = tuple(at - t for at in self.times[later:])
        return TimeLaw((0.0, *times), (pace, *self.paces[later:]), (slope, *self.slopes[later:]))


def ramps(duration: float, ramp: float, first: float, slope: float, last: float) -> TimeLaw:
    """A law that leaves one pace, holds 1, and ends in another one.

    Args:
        duration: > 0 [s].
        ramp: duration of the first and of the last ramp, less than half of it all [s].
        first: S' at the start, 0 to 1 [1].
        slope: S'' at the start [1/s].
        last: S' at the end, 0 to 1 [1].

    Returns:
        The law; its first ramp is shorter where the slope would lead it beyond 0 or 1.
    """
    room = 3.0 * (1.0 - first if slope > 0.0 else first)  # of a monotone cubic
    start = ramp if abs(slope) * ramp <= room else room / abs(slope)
    times = (0.0, start, duration - ramp, duration)
    return TimeLaw(times, (first, 1.0, 1.0, last), (slope, 0.0, 0.0, 0.0))
