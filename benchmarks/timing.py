"""Taking times that can be trusted: many calls, interleaved, medians, ratios to a floor."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import perf_counter, process_time

import numpy as np

Call = Callable[[], object]

_FEWEST = 5


@dataclass(frozen=True, slots=True)
class Timed:
    """How long something took.

    Attributes:
        min_us: shortest [us].
        median_us: median [us].
        p90_us: 90th percentile [us].
        max_us: longest [us].
        cpu_us: median of what the processor spent on it; on a busy machine it is less than the
            median, which counts the time in which other programs had the processor [us].
        rounds: calls that were timed.
    """

    min_us: float
    median_us: float
    p90_us: float
    max_us: float
    cpu_us: float
    rounds: int


def interleaved(calls: Sequence[Call], rounds: int, longest_s: float) -> list[Timed]:
    """Time several calls in turn, so that a change of the machine's speed meets all alike.

    Args:
        calls: what to call.
        rounds: calls of each; a tenth more is made first and not counted.
        longest_s: slower calls skip rounds so as not to take longer in all, but 5 are made.

    Returns:
        One row per call, in the given order.
    """
    times: list[list[tuple[float, float]]] = [[] for _ in calls]
    every = [_pace(call, rounds, longest_s) for call in calls]
    for turn in range(-(rounds // 10), rounds):
        for call, pace, row in zip(calls, every, times, strict=True):
            if turn % pace:
                continue
            start, busy = perf_counter(), process_time()
            call()
            end = perf_counter(), process_time()
            if turn >= 0:
                row.append((end[0] - start, end[1] - busy))
    return [_timed(np.array(row)) for row in times]


def _pace(call: Call, rounds: int, longest_s: float) -> int:
    """Every how many rounds a call may be made."""
    start = perf_counter()
    call()
    affordable = longest_s / (perf_counter() - start)
    return max(1, min(int(np.ceil(rounds / affordable)), rounds // _FEWEST))


def _timed(times: np.ndarray) -> Timed:
    """Sum up times and processor times, shape (N, 2) [s]."""
    shortest, middle, high, longest = 1e6 * np.percentile(times[:, 0], (0, 50, 90, 100))
    busy = 1e6 * float(np.median(times[:, 1]))
    return Timed(float(shortest), float(middle), float(high), float(longest), busy, len(times))
