"""Rows of numbers that grow for as long as a run lasts: eight bytes a number, no objects."""

from array import array
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray


class Rows:
    """Rows of one shape, added one by one."""

    def __init__(self, *shape: int) -> None:
        """Start empty.

        Args:
            shape: of a row; none: a number.
        """
        self._shape, self._numbers = shape, array("d")

    def append(self, numbers: Iterable[float]) -> None:
        """Add a row.

        Args:
            numbers: of the row, the last index fastest.
        """
        self._numbers.extend(numbers)

    def table(self) -> NDArray[np.float64]:
        """All so far.

        Returns:
            Shape (N, *shape), a copy.
        """
        return np.array(self._numbers, dtype=np.float64).reshape(-1, *self._shape)
