"""Signals as questions the loop asks: Ctrl-C, SIGTERM and a closed terminal; orders by others.

It imports nothing heavy: who may be stopped must be so from the first moment.
"""

import signal
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from types import FrameType

NAMES = ("SIGINT", "SIGTERM", "SIGHUP")  # not all of them everywhere
HALT, ARM = "SIGUSR1", "SIGUSR2"


@contextmanager
def interruption() -> Iterator[Callable[[], bool]]:
    """Take over Ctrl-C, SIGTERM and SIGHUP while a run lasts; those of the shutdown are ignored.

    A SIGHUP that is ignored already, as nohup wants it, stays so.

    Yields:
        A function that tells whether one has come.
    """
    hangup = getattr(signal, "SIGHUP", None)
    kept = hangup is not None and signal.getsignal(hangup) is signal.SIG_IGN
    with noted([name for name in NAMES if name != "SIGHUP" or not kept]) as came:
        yield lambda: bool(came)


@contextmanager
def noted(names: Sequence[str]) -> Iterator[list[str]]:
    """Take signals over for a while, so that they do nothing but be noted.

    Args:
        names: of the signals; those that this system has not are left out.

    Yields:
        Names of those that have come, in their order; whoever reads them takes them out.
    """
    came: list[str] = []

    def _note(number: int, frame: FrameType | None) -> None:
        del frame
        came.append(signal.Signals(number).name)

    numbers = [getattr(signal, name) for name in names if hasattr(signal, name)]
    before = {number: signal.signal(number, _note) for number in numbers}
    try:
        yield came
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
