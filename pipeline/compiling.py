"""A word to the user while machine code is made; loading what is kept on disk needs none."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from numba.core import event

from pipeline.notice import tell


class _Compiling(event.Listener):
    """Says something when the compiler first starts."""

    def __init__(self, text: str) -> None:
        self._text, self._told = text, False

    def on_start(self, event: Any) -> None:  # noqa: ARG002 (numba's port)
        """The compiler has something to do."""
        if not self._told:
            self._told = True
            tell(self._text)

    def on_end(self, event: Any) -> None:
        """Nothing to say."""


@contextmanager
def told_of_compiling(what: str, takes: str) -> Iterator[None]:
    """Say on stderr that something is compiled, if it is.

    Args:
        what: is compiled while this is open.
        takes: how long, in words.

    Yields:
        While the work is done.
    """
    text = f"compiling {what} for this processor, this once ({takes})"
    with event.install_listener("numba:compile", _Compiling(text)):
        yield
