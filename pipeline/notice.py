"""A word to the user where something takes longer than usual."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Timer


@contextmanager
def told_after(seconds: float, text: str) -> Iterator[None]:
    """Say something on stderr if the work takes long.

    Args:
        seconds: the patience.
        text: what to say.

    Yields:
        While the work is done.
    """
    timer = Timer(seconds, lambda: print(f"echelon: {text}", file=sys.stderr))  # noqa: T201 (stderr)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
