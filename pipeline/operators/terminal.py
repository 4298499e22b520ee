"""The keyboard of the terminal that the program runs in."""

import os
import select
import sys
from contextlib import suppress
from typing import Any

from control.keyed import KeyDrive
from datasets.cycle import Orders
from pipeline.errors import ConfigError
from pipeline.operators.keys import Keys

READ_AT_ONCE = 64  # bytes; a flood of keys never holds up a cycle


class Terminal:
    """An operator who types; Ctrl-C still interrupts."""

    def __init__(self, drive: KeyDrive | None, stdin: int = 0) -> None:
        """Take single keys from the terminal, unseen.

        Args:
            drive: how the leader may be driven; None: not at all.
            stdin: file descriptor of the terminal.

        Raises:
            ConfigError: if it is no terminal.
        """
        import termios
        import tty

        if not os.isatty(stdin):
            raise ConfigError("keys need a terminal: this program's input is none")
        self._stdin, self._keys = stdin, Keys(drive)
        self._before: list[Any] | None = termios.tcgetattr(stdin)
        tty.setcbreak(stdin, termios.TCSANOW)

    def orders(self, now: float) -> Orders:
        """What was typed since the last time; never waits.

        Args:
            now: the moment of the cycle [s].

        Returns:
            The orders.
        """
        return self._keys.read(self._typed(), now)

    def close(self) -> None:
        """Give the terminal back as it was. Safe to call twice."""
        import termios

        before, self._before = self._before, None
        if before is not None and not _is_in_background(self._stdin):
            with suppress(termios.error):  # the terminal may be gone
                termios.tcsetattr(self._stdin, termios.TCSANOW, before)

    def _typed(self) -> bytes:
        if _is_in_background(self._stdin):
            return b""
        ready, _, _ = select.select([self._stdin], [], [], 0.0)
        try:
            return os.read(self._stdin, READ_AT_ONCE) if ready else b""
        except OSError:  # the terminal is gone; the run goes on without it
            return b""


def there_is_a_terminal() -> bool:
    """Whether somebody may type.

    Returns:
        True if input and messages are a terminal's, and this program is not in its background.
    """
    terminals = sys.stdin is not None and sys.stdin.isatty() and sys.stderr.isatty()
    return terminals and not _is_in_background(sys.stdin.fileno())


def _is_in_background(stdin: int) -> bool:
    """Whether a touch of the terminal would suspend this program: a shell's job behind others."""
    try:
        return os.tcgetpgrp(stdin) != os.getpgrp()
    except OSError:  # not the terminal that controls this program, or none
        return False
