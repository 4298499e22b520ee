"""Functions compiled to machine code: once per machine and version, then kept on disk."""

from collections.abc import Callable
from functools import cache
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
_ALONE = "vision"  # compiles no function of control along
_CONFIG: Any = numba.config
_GIVEN_PLACE = _CONFIG.CACHE_DIR


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function of numbers, arrays and values when it is first called.

    The compiler may add up sums in another order, but always in the same: the same input gives the
    same bits on one machine. Division by zero gives inf or nan, as in numpy. Other threads run on
    while it runs.

    Args:
        function: loops over scalars and arrays, in the subset of Python that numba knows.

    Returns:
        The function, compiled.
    """
    return _kept(function, {"nogil": True})


def compiled_part(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function that only compiled functions call; half the work for the compiler.

    Args:
        function: as for `compiled`.

    Returns:
        The function, compiled.
    """
    return _kept(function, _BARE)


def _kept(function: Callable[P, R], options: dict[str, Any]) -> Callable[P, R]:
    """Compiled with its machine code kept in a folder that stands for all sources of its packages.

    The compiler itself looks at the caller's file only: code that calls a function changed in
    another file would be taken for up to date.
    """
    _CONFIG.CACHE_DIR = _GIVEN_PLACE or _place(function.__module__.rpartition(".")[0])
    fast: Callable[P, R] = numba.njit(**options, **_HOW)(function)
    _CONFIG.CACHE_DIR = _GIVEN_PLACE
    return fast


@cache
def _place(package: str) -> str:
    """Folder for the machine code of a package; "" where nobody may write: numba then finds one."""
    root = Path(__file__).parents[1]
    here = root.joinpath(*package.split("."))
    laws = () if package == _ALONE else (root / "control",)  # they are compiled along
    around = [folder for folder in here.parents if root in folder.parents]
    read = sorted({path for folder in (here, *around, *laws) for path in folder.glob("*.py")})
    sources = b"".join(path.read_bytes() for path in read)
    folder = here / "__pycache__" / (_NAME + sha256(sources).hexdigest()[:16])
    if folder.is_dir():
        return str(folder)
    try:
        for outdated in folder.parent.glob(_NAME + "*"):
            rmtree(outdated, ignore_errors=True)
        folder.mkdir(parents=True, exist_ok=True)  # another process may be as far
    except OSError:
        return ""
    return str(folder)
