"""Ctrl-C, SIGTERM and a closed terminal as a question the loop asks, so that robots are stopped."""

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

NAMES = ("SIGINT", "SIGTERM", "SIGHUP")  # not all of them everywhere


@contextmanager
def interruption() -> Iterator[Callable[[], bool]]:
    """Take over Ctrl-C, SIGTERM and SIGHUP while a run lasts; those of the shutdown are ignored.

    A SIGHUP that is ignored already, as nohup wants it, stays so.

    Yields:
        A function that tells whether one has come.
    """
    came: list[int] = []

    def _note(number: int, frame: FrameType | None) -> None:
        del frame
        came.append(number)

    before = {number: signal.signal(number, _note) for number in _taken()}
    try:
        yield lambda: bool(came)
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _taken() -> Iterator[int]:
    for name in NAMES:
        number = getattr(signal, name, None)
        kept = name == "SIGHUP" and signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
        if number is not None and not kept:
            yield number
