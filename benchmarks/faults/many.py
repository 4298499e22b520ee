"""Mission after mission, some processes at a time; the same results however many there are."""

from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from dataclasses import dataclass
from itertools import count
from multiprocessing import get_context

import cv2

from benchmarks.faults.drive import drive
from benchmarks.faults.missions import TURNS
from benchmarks.faults.verdict import Verdict, judge

AHEAD = 3  # missions that a process has waiting


@dataclass(frozen=True, slots=True)
class Mission:
    """A mission that was driven and judged.

    Attributes:
        number: of the mission.
        seed: of all missions.
        course: its name.
        verdict: what became of it.
    """

    number: int
    seed: int
    course: str
    verdict: Verdict

    @property
    def broken(self) -> tuple[str, ...]:
        """All promises that were broken, in words."""
        return (*self.verdict.broken, *(b for o in self.verdict.outcomes for b in o.broken))


def mission(number: int, seed: int) -> Mission:
    """Drive and judge a mission.

    Args:
        number: of the mission, >= 0.
        seed: of all missions, >= 0.

    Returns:
        What became of it.
    """
    cv2.setNumThreads(1)
    return Mission(number, seed, TURNS[number % len(TURNS)], judge(drive(number, seed)))


def missions(
    seconds: float, seed: int, jobs: int, tell: Callable[[float], None]
) -> Iterator[Mission]:
    """Drive until enough time was simulated.

    Args:
        seconds: of all missions together [s].
        seed: of all missions, >= 0.
        jobs: processes at a time.
        tell: takes the share that is done.

    Yields:
        The missions in their order.
    """
    done, numbers = 0.0, count()
    with ProcessPoolExecutor(jobs, get_context("spawn")) as pool:
        waiting: deque[Future[Mission]] = deque()
        while done < seconds:
            while len(waiting) < AHEAD * jobs:
                waiting.append(pool.submit(mission, next(numbers), seed))
            one = waiting.popleft().result()
            done += one.verdict.end
            tell(min(1.0, done / seconds))
            yield one
        pool.shutdown(cancel_futures=True)
