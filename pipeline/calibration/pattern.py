"""What a robot is told while it is calibrated: twists that bring it back to where it began."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate
from math import hypot, inf

from control.actuation import DriveGain
from control.history import SentCommands
from control.motion_model import MotionModel, roll
from control.unicycle import Twist, UnicycleState
from pipeline.steering import STANDSTILL

GREATEST_GAIN = 2.2
"""Robots may be this much faster than believed: sources differ by 2 about a Miabot's scale."""

_LAGS = (0.005, 0.05, 0.2)  # of robots that are reckoned with [s]
_STEP = 0.01  # of the walk along a pattern [s]


@dataclass(frozen=True, slots=True)
class Stretch:
    """A twist that is held.

    Attributes:
        duration: for how long [s].
        twist: commanded [m/s, rad/s].
    """

    duration: float
    twist: Twist


@dataclass(frozen=True, slots=True)
class Pattern:
    """Stretches in a row, from standstill to standstill.

    Attributes:
        stretches: in their order.
    """

    stretches: tuple[Stretch, ...]

    @property
    def duration(self) -> float:
        """Of all stretches [s]."""
        return sum(stretch.duration for stretch in self.stretches)

    def at(self, t: float) -> tuple[Twist, float]:
        """What is commanded at a time.

        Args:
            t: since the beginning, >= 0 [s].

        Returns:
            The twist, and for how long it will still be held; standstill for ever after the end
            [m/s, rad/s; s].
        """
        ends = accumulate(stretch.duration for stretch in self.stretches)
        for stretch, end in zip(self.stretches, ends, strict=True):
            if t < end:
                return stretch.twist, end - t
        return STANDSTILL, inf

    def reach(self) -> float:
        """How far a robot gets from where it began, even if it is as fast as `GREATEST_GAIN`.

        Returns:
            Of the middle of its axle [m].
        """
        return max(_farthest(self, lag) for lag in _LAGS)


def chirp(durations: Sequence[float], v: float, omega: float) -> tuple[Stretch, ...]:
    """Forth and back, ever shorter.

    Args:
        durations: of the stretches [s].
        v: forward speed of the first one [m/s].
        omega: its turning [rad/s].

    Returns:
        Stretches with alternating signs.
    """
    signs = [(-1.0) ** number for number in range(len(durations))]
    return tuple(
        Stretch(duration, Twist(sign * v, sign * omega))
        for duration, sign in zip(durations, signs, strict=True)
    )


def there_and_back(stretches: Sequence[Stretch]) -> tuple[Stretch, ...]:
    """Drive stretches, then the same way back: it ends where it began, whatever the gains are.

    Args:
        stretches: the way there.

    Returns:
        The way there and back.
    """
    back = [
        Stretch(s.duration, Twist(-s.twist.v, -s.twist.omega)) for s in reversed(tuple(stretches))
    ]
    return (*stretches, *back)


_SWINGS = (0.2, 0.4, 0.3, 0.2, 0.15, 0.1)  # about the middle, shrinking [s]
_BEFORE = (Stretch(0.3, STANDSTILL),)  # poses at rest
_AFTER = (Stretch(0.5, STANDSTILL),)  # until the last command has had its effect
_PAUSE = (Stretch(0.1, STANDSTILL),)

DRIVING = Pattern(
    _BEFORE
    + there_and_back(
        (
            *chirp(_SWINGS, 0.0, 4.0),
            *_PAUSE,
            *chirp(_SWINGS, 0.15, 0.0),
            *_PAUSE,
            *chirp(_SWINGS[:4], 0.15, 2.0),
        )
    )
    + _AFTER
)
"""Turns, steps forth and back, and arcs: all that the fit needs, within a hand's breadth."""

TURNING = Pattern(_BEFORE + there_and_back((Stretch(0.4, Twist(0.0, 2.0)),)) + _AFTER)
"""To the left by 0.8 rad and back, in place."""


def _farthest(pattern: Pattern, lag: float) -> float:
    """Greatest distance from the start under GREATEST_GAIN and a lag [m]."""
    model, gain = MotionModel(lag), DriveGain(GREATEST_GAIN, GREATEST_GAIN)
    starts = accumulate((s.duration for s in pattern.stretches), initial=0.0)
    twists = tuple(stretch.twist for stretch in pattern.stretches)
    sent = SentCommands(tuple(starts)[:-1], twists)
    state, farthest = UnicycleState(0.0, 0.0, 0.0, 0.0, 0.0), 0.0
    for step in range(round(pattern.duration / _STEP)):
        state = roll(state, step * _STEP, (step + 1) * _STEP, sent, model, gain)
        farthest = max(farthest, hypot(state.x, state.y))
    return farthest
