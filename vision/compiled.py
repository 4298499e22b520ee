"""Functions compiled to machine code: once per machine and version, then kept on disk."""

from collections.abc import Callable
from typing import ParamSpec, TypeVar

from numba import njit

P = ParamSpec("P")
R = TypeVar("R")

_FREEDOM = {"reassoc", "contract", "nsz"}  # of the compiler; inf and nan keep their meaning


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function of numbers and arrays when it is first called.

    The compiler may add up sums in another order, but always in the same: the same input gives the
    same bits on one machine. Division by zero gives inf or nan, as in numpy.

    Args:
        function: loops over scalars and arrays, in the subset of Python that numba knows.

    Returns:
        The function, compiled.
    """
    decorate = njit(cache=True, error_model="numpy", fastmath=_FREEDOM, nogil=True)
    fast: Callable[P, R] = decorate(function)
    return fast
