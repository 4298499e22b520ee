"""Time courses of one value: the paper's smooth step, and key frames with smooth transitions."""

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import sqrt, tanh
from typing import Protocol

from control.actuation import require_finite
from control.differentiator import unwrapped
from control.errors import ControlError

_ROUNDING = 1e-9  # by which transitions may overlap: sums of decimal times are not exact [s]


@dataclass(frozen=True, slots=True)
class Step:
    """One change of a value.

    Attributes:
        t: when it changes [s].
        before: value before [m or rad].
        after: value after [m or rad].
    """

    t: float
    before: float
    after: float


class Profile(Protocol):
    """A value as a function of time, smooth enough for h^d of (27): two continuous derivatives."""

    def at(self, t: float) -> tuple[float, float, float]:
        """Value and its first two derivatives.

        Args:
            t: time on the mission's clock [s].

        Returns:
            Value, first and second derivative [m or rad, per s, per s^2].
        """
        ...

    @property
    def steps(self) -> tuple[Step, ...]:
        """Its changes, ascending in time; none for a value that stays."""
        ...

    @property
    def changes(self) -> tuple[float, ...]:
        """Times of its changes, ascending [s]."""
        ...

    @property
    def peak_rate(self) -> float:
        """Greatest magnitude of the first derivative [m/s or rad/s]."""
        ...

    @property
    def peak_acceleration(self) -> float:
        """Greatest magnitude of the second derivative [m/s^2 or rad/s^2]."""
        ...


@dataclass(frozen=True, slots=True)
class TanhStep:
    """A smooth step: (before + after)/2 + (after - before)/2 tanh(rate (time - t)).

    The paper's l^d (section V); its change is told at the middle.

    Attributes:
        before: value long before the step [m or rad].
        after: value long after the step [m or rad].
        t: middle of the step [s].
        rate: steepness [1/s].
    """

    before: float
    after: float
    t: float = 0.0
    rate: float = 10.0

    def at(self, t: float) -> tuple[float, float, float]:
        """Value and its first two derivatives.

        Args:
            t: time on the mission's clock [s].

        Returns:
            Value, first and second derivative [m or rad, per s, per s^2].
        """
        half = 0.5 * (self.after - self.before)
        th = tanh(self.rate * (t - self.t))
        slope = half * self.rate * (1.0 - th * th)
        value = 0.5 * (self.after + self.before) + half * th
        return value, slope, -2.0 * self.rate * th * slope

    @property
    def steps(self) -> tuple[Step, ...]:
        """The step, if it is one."""
        moves = self.before != self.after
        return (Step(self.t, self.before, self.after),) if moves else ()

    @property
    def changes(self) -> tuple[float, ...]:
        """The middle of the step, if it is one [s]."""
        return tuple(step.t for step in self.steps)

    @property
    def peak_rate(self) -> float:
        """Greatest magnitude of the first derivative, at the middle [m/s or rad/s]."""
        return abs(0.5 * (self.after - self.before) * self.rate)

    @property
    def peak_acceleration(self) -> float:
        """Greatest magnitude of the second derivative, at tanh^2 = 1/3 [m/s^2 or rad/s^2]."""
        return self.peak_rate * abs(self.rate) * 4.0 / (3.0 * sqrt(3.0))

    @classmethod
    def constant(cls, value: float) -> "TanhStep":
        """A value that never changes.

        Args:
            value: the value [m or rad].

        Returns:
            A step from the value to itself.
        """
        return cls(value, value)


@dataclass(frozen=True, slots=True)
class KeyFrames:
    """Values held one after the other, with transitions of stated durations between them.

    A transition is the quintic 10 s^3 - 15 s^4 + 6 s^5 of the share s of its duration: rate and
    acceleration are 0 at both ends, so that value, rate and acceleration never jump, and the value
    stays between the two it connects. It *begins* at its time, where TanhStep has its middle.

    Attributes:
        times: (N,) when each transition begins, ascending [s].
        values: (N + 1,) the value before the first transition, and after each [m or rad].
        durations: (N,) of the transitions, > 0 [s].

    Raises:
        ControlError: if the lengths do not match, a number is not finite, a duration is not
            positive, or a transition begins before the one before it has ended.
    """

    times: tuple[float, ...]
    values: tuple[float, ...]
    durations: tuple[float, ...]

    def __post_init__(self) -> None:
        n = len(self.times)
        if not len(self.values) - 1 == n == len(self.durations):
            raise ControlError(
                f"key frames with {n} times need {n + 1} values and {n} durations, got "
                f"{len(self.values)} and {len(self.durations)}"
            )
        require_finite("key frames", *self.times, *self.values, *self.durations)
        _refuse_overlap(self.times, self.durations)

    @classmethod
    def turning(
        cls, times: Sequence[float], bearings: Sequence[float], durations: Sequence[float]
    ) -> "KeyFrames":
        """Key frames of an angle: every transition turns by the shorter way.

        Values may thus leave (-pi, pi]. Which way half a turn goes is left to rounding: a frame
        between the two says it.

        Args:
            times: (N,) when each transition begins, ascending [s].
            bearings: (N + 1,) angles, equal to within whole turns to those wanted [rad].
            durations: (N,) of the transitions, > 0 [s].

        Returns:
            The key frames, the first value as given.
        """
        return cls(tuple(times), unwrapped(bearings), tuple(durations))

    def at(self, t: float) -> tuple[float, float, float]:
        """Value and its first two derivatives.

        Args:
            t: time on the mission's clock [s].

        Returns:
            Value, first and second derivative [m or rad, per s, per s^2].
        """
        k = bisect_right(self.times, t)  # transitions begun
        if k == 0:
            return self.values[0], 0.0, 0.0
        before, after, duration = self.values[k - 1], self.values[k], self.durations[k - 1]
        s = (t - self.times[k - 1]) / duration
        if s >= 1.0:
            return after, 0.0, 0.0
        rise, rest = (after - before) / duration, s * (1.0 - s)
        return (
            before + (after - before) * s * s * s * (10.0 - s * (15.0 - 6.0 * s)),
            rise * 30.0 * rest * rest,
            rise / duration * 60.0 * rest * (1.0 - 2.0 * s),
        )

    @property
    def steps(self) -> tuple[Step, ...]:
        """The transitions that change something, at the times at which they begin."""
        between = zip(self.times, pairwise(self.values), strict=True)
        return tuple(Step(t, before, after) for t, (before, after) in between if before != after)

    @property
    def changes(self) -> tuple[float, ...]:
        """When the transitions that change something begin, ascending [s]."""
        return tuple(step.t for step in self.steps)

    @property
    def peak_rate(self) -> float:
        """Greatest magnitude of the first derivative, 15/8 of a mean rate [m/s or rad/s]."""
        return max((15.0 / 8.0 * rate for rate, _ in self._mean_rates()), default=0.0)

    @property
    def peak_acceleration(self) -> float:
        """Greatest second derivative, 10/sqrt 3 mean rates per duration [m/s^2 or rad/s^2]."""
        peaks = (10.0 / sqrt(3.0) * rate / duration for rate, duration in self._mean_rates())
        return max(peaks, default=0.0)

    def _mean_rates(self) -> list[tuple[float, float]]:
        """Magnitude of the mean rate of every transition, and its duration [s]."""
        rises = [abs(after - before) for before, after in pairwise(self.values)]
        return [(rise / T, T) for rise, T in zip(rises, self.durations, strict=True)]


def _refuse_overlap(times: tuple[float, ...], durations: tuple[float, ...]) -> None:
    if not all(duration > 0.0 for duration in durations):
        raise ControlError(f"a transition must last > 0 s, got {min(durations):g} s: give it time")
    ends = [t + duration for t, duration in zip(times, durations, strict=True)]
    for (begin, later), end in zip(pairwise(times), ends[:-1], strict=True):
        if later <= begin or later < end - _ROUNDING:
            raise ControlError(
                f"the transition at {later:g} s begins before the one at {begin:g} s has ended at "
                f"{end:g} s: shorten that one or begin later"
            )
