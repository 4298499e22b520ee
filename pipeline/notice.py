"""A word to the user on the way: what takes longer than usual, what was lost and came back."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Timer


def tell(text: str) -> None:
    """Say one line on stderr.

    Args:
        text: what to say.
    """
    clean = "\r\x1b[K" if sys.stderr.isatty() else ""  # a progress line may stand there
    print(f"{clean}echelon: {text}", file=sys.stderr)  # noqa: T201 (stderr)


@contextmanager
def told_after(seconds: float, text: str) -> Iterator[None]:
    """Say something on stderr if the work takes long.

    Args:
        seconds: the patience.
        text: what to say.

    Yields:
        While the work is done.
    """
    timer = Timer(seconds, tell, (text,))
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
