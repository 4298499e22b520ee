"""One source, two ways to run: as Python in the live loop, as machine code in a batch of runs.

A `compilable` function stays Python when Python calls it; a compiled function that calls it takes
it into its machine code. `control.value` lets frozen dataclasses go along.
"""

from collections.abc import Callable
from typing import ParamSpec, TypeVar

from numba.extending import register_jitable

P = ParamSpec("P")
R = TypeVar("R")


def compilable(function: Callable[P, R]) -> Callable[P, R]:
    """Let compiled functions call a function that Python runs as it is.

    Args:
        function: works on numbers, tuples and values, in the subset of Python that numba knows.

    Returns:
        The function itself.
    """
    plain: Callable[P, R] = register_jitable(error_model="numpy")(function)
    return plain
