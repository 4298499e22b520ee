"""Ctrl-C and SIGTERM as a question the loop asks, so that robots are stopped and files closed."""

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

SIGNALS = (signal.SIGINT, signal.SIGTERM)


@contextmanager
def interruption() -> Iterator[Callable[[], bool]]:
    """Take over Ctrl-C and SIGTERM while a run lasts; signals during the shutdown are ignored.

    Yields:
        A function that tells whether one has come.
    """
    came: list[int] = []

    def _note(number: int, frame: FrameType | None) -> None:
        del frame
        came.append(number)

    before = {number: signal.signal(number, _note) for number in SIGNALS}
    try:
        yield lambda: bool(came)
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
