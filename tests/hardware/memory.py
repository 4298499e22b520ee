"""How much memory a process holds over time, as Linux tells it."""

from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from time import monotonic

import numpy as np

WARM = 60.0  # what is set up in the first minute is no growth [s]
MB = 1024.0  # kB


@dataclass(frozen=True, slots=True)
class Growth:
    """Memory of a process.

    Attributes:
        warm: after a minute, or at the first look of a shorter life [MB].
        last: at the last look [MB].
        rate: slope of the line of least squares from `warm` on; None if that was short [MB/min].
    """

    warm: float
    last: float
    rate: float | None

    def __str__(self) -> str:
        rate = "-" if self.rate is None else f"{self.rate:.2f}"
        return f"{self.warm:.1f}, {self.last:.1f}; {rate}"


class Memory:
    """Looks at a process, or at the youngest child of one, now and then."""

    def __init__(self, pid: int) -> None:
        """Begin.

        Args:
            pid: of the process.
        """
        self._pid, self._child, self._start = pid, False, monotonic()
        self._seen: list[tuple[float, float]] = []

    @classmethod
    def of_child(cls, pid: int) -> "Memory":
        """Of the child that a process has started, once there is one.

        Args:
            pid: of the parent.

        Returns:
            Who looks.
        """
        memory = cls(pid)
        memory._child = True
        return memory

    @property
    def growth(self) -> Growth:
        """What was seen."""
        t, held = np.array(self._seen or [(0.0, 0.0)]).T
        late = t >= (WARM if t[-1] > WARM else 0.0)
        enough = t[-1] - WARM > WARM / 2.0
        rate = float(60.0 * np.polyfit(t[late], held[late], 1)[0]) if enough else None
        return Growth(float(held[late][0]), float(held[-1]), rate)

    def look(self) -> None:
        """Take note of what it holds now; nothing if it is gone."""
        with suppress(OSError, StopIteration):
            lines = Path(f"/proc/{self._looked_at()}/status").read_text().splitlines()
            held = next(line.split()[1] for line in lines if line.startswith("VmRSS"))
            self._seen.append((monotonic() - self._start, int(held) / MB))

    def _looked_at(self) -> int:
        if not self._child:
            return self._pid
        tasks = Path(f"/proc/{self._pid}/task").glob("*/children")
        children = (child for task in tasks for child in task.read_text().split())
        return int(next(children))
