"""Whether the machine keeps a beat: how late a waiting loop wakes."""

import numpy as np
from numpy.typing import NDArray

from pipeline.clock import MonotonicClock
from pipeline.finding import Finding
from pipeline.ports import Clock

PERIOD, SECONDS = 0.01, 2.0  # 100 Hz [s]
GOOD, BAD = 1.0, 5.0  # lateness that is seldom passed: none to mind; half a period [ms]


def lateness(clock: Clock, period: float = PERIOD, seconds: float = SECONDS) -> NDArray[np.float64]:
    """Wait for moment after moment, as the loop does.

    Args:
        clock: to wait on.
        period: between two moments [s].
        seconds: how long [s].

    Returns:
        How late each wait ended [s]; one that was passed before is late by that much.
    """
    late, start = [], clock.now()
    for n in range(1, round(seconds / period) + 1):
        due = start + n * period
        clock.wait_until(due)
        late.append(clock.now() - due)
    return np.array(late)


def beat(late: NDArray[np.float64]) -> Finding:
    """Judge how late waits ended.

    Args:
        late: for each wait [s].

    Returns:
        A warning if one in a hundred is late by more than 1 ms, bad by more than 5 ms.
    """
    middle, high = 1e3 * np.percentile(late, (50, 99))
    detail = f"late by {middle:.2f} ms (median), {high:.2f} ms (99 %), {1e3 * late.max():.2f} ms"
    detail += f" (most) at {1.0 / PERIOD:.0f} Hz"
    remedy = "" if high <= GOOD else "end other programs; see processor speed and cores"
    return Finding("beat", not remedy, detail, bool(high > BAD), remedy)


def keep_beat() -> Finding:
    """Measure for two seconds.

    Returns:
        As `beat`.
    """
    return beat(lateness(MonotonicClock()))
