"""Functions compiled to machine code: once per machine and version, then kept on disk."""

from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from shutil import rmtree
from typing import Any, ParamSpec, TypeVar

import numba

P = ParamSpec("P")
R = TypeVar("R")

_FREEDOM = {"reassoc", "contract", "nsz"}  # of the compiler; inf and nan keep their meaning
_HOW: dict[str, Any] = {"cache": True, "error_model": "numpy", "fastmath": _FREEDOM}
_BARE: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
_NAME = "compiled-"
_CONFIG: Any = numba.config


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function of numbers and arrays when it is first called.

    The compiler may add up sums in another order, but always in the same: the same input gives the
    same bits on one machine. Division by zero gives inf or nan, as in numpy.

    Args:
        function: loops over scalars and arrays, in the subset of Python that numba knows.

    Returns:
        The function, compiled.
    """
    fast: Callable[P, R] = numba.njit(**_HOW)(function)
    return fast


def compiled_part(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function that only compiled functions call; half the work for the compiler.

    Args:
        function: as for `compiled`.

    Returns:
        The function, compiled.
    """
    fast: Callable[P, R] = numba.njit(**_BARE, **_HOW)(function)
    return fast


def _keep_by_content() -> None:
    """Keep machine code under a name that stands for all sources.

    The compiler itself looks at the caller's file only: code that calls a function changed in
    another file would be taken for up to date.
    """
    here = Path(__file__).parent
    sources = b"".join(path.read_bytes() for path in sorted(here.glob("*.py")))
    folder = here / "__pycache__" / (_NAME + sha256(sources).hexdigest()[:16])
    if _CONFIG.CACHE_DIR or folder.is_dir():
        _CONFIG.CACHE_DIR = _CONFIG.CACHE_DIR or str(folder)
        return
    try:
        for outdated in folder.parent.glob(_NAME + "*"):
            rmtree(outdated, ignore_errors=True)
        folder.mkdir(parents=True)
        _CONFIG.CACHE_DIR = str(folder)
    except OSError:
        return  # installed where nobody may write: the compiler finds a place of its own


_keep_by_content()
