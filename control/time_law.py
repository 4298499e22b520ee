"""Time laws: how far along its curve a plan is at a time, so that the curve stays regular at rest.

A plan is p(t) = P(S(t)). The curve P never stands still, so its heading and curvature are defined
everywhere; S' is a share of the curve's own pace: 0 at a standstill, 1 on the way.
"""

from dataclasses import dataclass, field

import numpy as np
from scipy.interpolate import CubicHermiteSpline, PPoly

from control.motion_model import Array


@dataclass(frozen=True, slots=True)
class TimeLaw:
    """S' as cubics between breaks; what is left of a cubic is a cubic, which replanning needs.

    Attributes:
        times: of the breaks, from 0 to the duration [s].
        paces: S' there, 0 to 1 [1].
        slopes: S'' there [1/s].
    """

    times: tuple[float, ...]
    paces: tuple[float, ...]
    slopes: tuple[float, ...]
    _way: PPoly = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        pace = CubicHermiteSpline(self.times, self.paces, self.slopes)
        object.__setattr__(self, "_way", pace.antiderivative())

    @property
    def duration(self) -> float:
        """Where the law ends [s]."""
        return self.times[-1]

    def at(self, t: Array) -> Array:
        """S and its derivatives.

        Args:
            t: (n,) times, 0 to the duration [s].

        Returns:
            (4, n): S, S', S'', S''' [s, 1, 1/s, 1/s^2].
        """
        s, pace, slope, bend = (self._way(t, order) for order in range(4))
        return np.array([s, np.maximum(pace, 0.0), slope, bend])  # a standstill is exactly 0

    def rest(self, t: float) -> "TimeLaw":
        """What is left of the law after a time, on a clock of its own.

        Args:
            t: 0 <= t < duration [s].

        Returns:
            The same S' from t on.
        """
        _, pace, slope, _ = self.at(np.array([t]))[:, 0].tolist()
        later = [i for i, at in enumerate(self.times) if at > t]
        return TimeLaw(
            (0.0, *(self.times[i] - t for i in later)),
            (pace, *(self.paces[i] for i in later)),
            (slope, *(self.slopes[i] for i in later)),
        )


def ramps(duration: float, ramp: float, first: float, slope: float, last: float) -> TimeLaw:
    """A law that leaves one pace, holds the curve's own, and ends in another one.

    Args:
        duration: > 0 [s].
        ramp: duration of the first and of the last ramp, less than half of it all [s].
        first: S' at the start, 0 to 1 [1].
        slope: S'' at the start [1/s].
        last: S' at the end, 0 to 1 [1].

    Returns:
        The law; its first ramp is shortened where the slope would lead it beyond 0 or 1.
    """
    room = 3.0 * (1.0 - first if slope > 0.0 else first)  # of a monotone cubic
    start = ramp if abs(slope) * ramp <= room else room / abs(slope)
    times = (0.0, start, duration - ramp, duration)
    return TimeLaw(times, (first, 1.0, 1.0, last), (slope, 0.0, 0.0, 0.0))
