"""A two-way line of bytes to robots: what every kind of link offers, and the serial one."""

import errno
import os
from contextlib import suppress
from time import sleep
from typing import Any, Protocol

from pipeline.errors import RadioError

try:
    from termios import error as _TerminalError  # no OSError, though it is one in all but name
except ImportError:  # a system without terminals
    _TerminalError = OSError  # type: ignore[misc, assignment]

FAILURES = (OSError, ValueError, _TerminalError)  # all that a serial port is known to raise
READ_AT_ONCE = 4096  # what is taken in one go, so that a flood never holds up a command [B]
WRITE_TIMEOUT = 0.1  # a port that takes nothing for longer has failed [s]


class Link(Protocol):
    """Bytes to and from one robot; every call returns within a bounded time."""

    def write(self, data: bytes) -> None:
        """Send all of it.

        Args:
            data: the message.

        Raises:
            RadioError: if the link is gone or does not take it in time.
        """
        ...

    def read(self) -> bytes:
        """Take what has arrived, without waiting.

        Returns:
            At most 4096 bytes, empty if there are none.

        Raises:
            RadioError: if the link is gone.
        """
        ...

    def discard(self) -> None:
        """Throw away what was written and has not left yet. Never fails."""
        ...

    def close(self) -> None:
        """Release the link. Safe to call twice; never fails."""
        ...


class SerialLink:
    """A serial device, such as /dev/rfcomm0 for Bluetooth; see Link."""

    def __init__(self, port: str, baudrate: int = 115_200) -> None:
        """Open the port.

        Args:
            port: its path or name.
            baudrate: of a real wire; Bluetooth and ptys ignore it [1/s].

        Raises:
            RadioError: if it is missing, busy or not allowed.
        """
        import serial

        self._port = port
        try:
            self._serial: Any = serial.Serial(
                port, baudrate, timeout=0, write_timeout=WRITE_TIMEOUT, exclusive=True
            )
        except FAILURES as error:
            raise RadioError(f"radio {port}: cannot open: {_reason(error)}") from error

    def write(self, data: bytes) -> None:
        """Send all of it.

        Args:
            data: the message.

        Raises:
            RadioError: if the port is gone or does not take it within 0.1 s.
        """
        try:
            self._serial.write(data)
        except FAILURES as error:
            raise RadioError(f"radio {self._port}: cannot write: {_reason(error)}") from error

    def read(self) -> bytes:
        """Take what has arrived, without waiting.

        Returns:
            At most 4096 bytes, empty if there are none.

        Raises:
            RadioError: if the port is gone.
        """
        try:
            waiting = min(self._serial.in_waiting, READ_AT_ONCE)
            return bytes(self._serial.read(waiting)) if waiting else b""
        except FAILURES as error:
            raise RadioError(f"radio {self._port}: cannot read: {_reason(error)}") from error

    def discard(self) -> None:
        """Throw away what was written and has not left yet. Never fails."""
        with suppress(*FAILURES):  # the port may be gone, and with it what was written
            self._serial.reset_output_buffer()

    def close(self) -> None:
        """Release the port; the last words get 0.1 s to leave. Safe to call twice; never fails."""
        with suppress(*FAILURES):
            if not self._drained():
                self.discard()  # else the system waits for a blocked port to drain, up to 30 s
        with suppress(*FAILURES):
            self._serial.close()

    def _drained(self) -> bool:
        for _ in range(10):
            if not self._serial.is_open or self._serial.out_waiting == 0:
                return True
            sleep(WRITE_TIMEOUT / 10)
        return False


def _reason(error: Exception) -> str:
    """The system's words for what happened, where there are any."""
    number = getattr(error, "errno", None)
    if number is None and error.args and isinstance(error.args[0], int):
        number = error.args[0]
    if number in (errno.EAGAIN, errno.EBUSY):
        return "another program uses it"
    return os.strerror(number) if isinstance(number, int) else str(error).lower()
