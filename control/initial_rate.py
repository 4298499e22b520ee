"""The rate of a signal that was watched for a moment, and how well it is known.

For h'(0) when robots already move at the start (Assumption 5, Remark 5 case 2). Plain floats.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from statistics import stdev

from control.differentiator import begin_differentiator, differentiate
from control.errors import ControlError

MIN_SAMPLES = 6
"""Fewer samples tell a rate, but not how well it is known."""

_FIRST = 5  # periods over which the first slope is taken, at most half of them
_LATEST = 3  # estimates whose spread is told, at least


@dataclass(frozen=True, slots=True)
class InitialRate:
    """A rate and how well it is known.

    Attributes:
        rate: of the signal at the last sample [unit per s].
        spread: standard deviation of the estimates in the last third of the samples [unit per s].
    """

    rate: float
    spread: float


def initial_rate(times: Sequence[float], values: Sequence[float], lipschitz: float) -> InitialRate:
    """Rate of a signal that was watched for a moment, for h'(0) of (25): Remark 5, case 2.

    Args:
        times: (N,) capture times, N >= 6, ascending [s].
        values: (N,) the signal, angles unwrapped.
        lipschitz: bound of the signal's third derivative, > 0 [unit per s^3].

    Returns:
        The differentiator's last estimate, and how much the latest ones differ.

    Raises:
        ControlError: if there are fewer than 6 samples, the lengths differ or a sample is unusable.
    """
    if len(times) != len(values) or len(times) < MIN_SAMPLES:
        raise ControlError(
            f"a rate needs {MIN_SAMPLES} samples, got {len(times)} times, {len(values)} values"
        )
    if not all(before < after for before, after in pairwise(times)):
        raise ControlError(f"a rate needs ascending times, got {', '.join(map(str, times))} s")
    first = min(_FIRST, (len(times) - 1) // 2)
    slope = (values[first] - values[0]) / (times[first] - times[0])
    # begun at its first slope it need not converge from 0, which takes longer than watching does
    memory = begin_differentiator(times[first], values[first], lipschitz, rate=slope)
    course = [slope]
    for t, value in zip(times[first + 1 :], values[first + 1 :], strict=True):
        memory = differentiate(memory, t, value)
        course.append(memory.rate)
    return InitialRate(course[-1], stdev(course[-max(_LATEST, len(course) // 3) :]))
