"""Taking times that can be trusted: many calls, interleaved, medians, ratios to a floor."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import perf_counter

import numpy as np

Call = Callable[[], object]


@dataclass(frozen=True, slots=True)
class Timed:
    """How long something took.

    Attributes:
        name: what.
        p50_us: median [us].
        p99_us: 99th percentile [us].
        floor: name of the row it is compared with, "" for none.
    """

    name: str
    p50_us: float
    p99_us: float
    floor: str = ""


def interleaved(calls: Sequence[tuple[str, Call, str]], rounds: int) -> list[Timed]:
    """Time several calls in turn, so that a change of the machine's speed meets all alike.

    Args:
        calls: name, what to call, name of the row it is compared with.
        rounds: calls of each; a tenth more is made first and not counted.

    Returns:
        One row per call, in the given order.
    """
    times = np.empty((rounds, len(calls)))
    for turn in range(-rounds // 10, rounds):
        for column, (_, call, _) in enumerate(calls):
            start = perf_counter()
            call()
            if turn >= 0:
                times[turn, column] = perf_counter() - start
    middle, high = 1e6 * np.percentile(times, (50, 99), axis=0)
    return [
        Timed(name, float(a), float(b), floor)
        for (name, _, floor), a, b in zip(calls, middle, high, strict=True)
    ]
