"""Taking times that can be trusted: many calls in turns, medians, ratios to a floor."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import perf_counter, process_time

import numpy as np

Call = Callable[[], object]

_FEWEST = 5
_IN_A_ROW = 4  # calls of a turn: the first finds nothing of its own in the caches


@dataclass(frozen=True, slots=True)
class Timed:
    """How long something took.

    Attributes:
        first_us: median of the first calls after others had the processor, caches cold [us].
        min_us: shortest [us].
        median_us: median [us].
        p90_us: 90th percentile [us].
        max_us: longest [us].
        cpu_us: median of what the processor spent on it; on a busy machine it is less than the
            median, which counts the time in which other programs had the processor [us].
        rounds: calls that were timed.
    """

    first_us: float
    min_us: float
    median_us: float
    p90_us: float
    max_us: float
    cpu_us: float
    rounds: int


def interleaved(calls: Sequence[Call], rounds: int, longest_s: float) -> list[Timed]:
    """Time several calls in turn, so that a change of the machine's speed meets all alike.

    Args:
        calls: what to call, each a few times in a row; the first time counts for itself.
        rounds: turns; a tenth more is made first and not counted.
        longest_s: slower calls skip turns so as not to take longer in all, but 5 are made.

    Returns:
        One row per call, in the given order.
    """
    times: list[list[list[tuple[float, float]]]] = [[] for _ in calls]
    every = [_pace(call, rounds, longest_s) for call in calls]
    for turn in range(-(rounds // 10), rounds):
        for call, pace, row in zip(calls, every, times, strict=True):
            if turn % pace:
                continue
            taken = [_taken(call) for _ in range(_IN_A_ROW)]
            if turn >= 0:
                row.append(taken)
    return [_timed(np.array(row)) for row in times]


def _taken(call: Call) -> tuple[float, float]:
    """Time, and processor time, of a call [s]."""
    start, busy = perf_counter(), process_time()
    call()
    return perf_counter() - start, process_time() - busy


def _pace(call: Call, rounds: int, longest_s: float) -> int:
    """Every how many turns a call may be made."""
    affordable = longest_s / (_IN_A_ROW * _taken(call)[0])
    return max(1, min(int(np.ceil(rounds / affordable)), rounds // _FEWEST))


def _timed(times: np.ndarray) -> Timed:
    """Sum up times and processor times, shape (turns, calls in a row, 2) [s]."""
    first, others = 1e6 * times[:, 0, 0], 1e6 * times[:, 1:].reshape(-1, 2)
    shortest, middle, high, longest = np.percentile(others[:, 0], (0, 50, 90, 100)).tolist()
    busy = float(np.median(others[:, 1]))
    return Timed(float(np.median(first)), shortest, middle, high, longest, busy, len(others))
