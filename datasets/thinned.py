"""Rows of numbers in bounded memory, for runs that last a day."""

from array import array
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

MOST = 40_000
"""Rows that are kept at most: 400 s of cycles at 100 Hz."""


class Thinned:
    """Rows of numbers; of more than can be kept every second one goes: they stay even in time."""

    def __init__(self, columns: int, most: int = MOST) -> None:
        """Begin without a row.

        Args:
            columns: numbers in a row, > 0.
            most: rows that are kept, even, > 0.
        """
        self._columns, self._most = columns, most
        self._numbers, self._stride, self._count = array("d"), 1, 0

    def add(self, row: Iterable[float]) -> None:
        """Take a row, or let it go.

        Args:
            row: its numbers.
        """
        if self._count % self._stride == 0:
            self._numbers.extend(row)
            if len(self._numbers) == self._most * self._columns:
                self._numbers = array("d", self.table()[::2].tobytes())
                self._stride *= 2
        self._count += 1

    def table(self) -> Floats:
        """What is kept, in order.

        Returns:
            Shape (N, columns), a copy.
        """
        return np.array(self._numbers).reshape(-1, self._columns)
