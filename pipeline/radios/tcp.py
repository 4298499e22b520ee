"""A TCP connection to a robot, whichever side made it; nothing stale waits long in its buffers."""

import os
import socket
import struct
import sys
from collections import deque
from contextlib import suppress
from time import monotonic, sleep

from pipeline.errors import RadioError
from pipeline.radios.address import parse_address
from pipeline.radios.link import READ_AT_ONCE, WRITE_TIMEOUT

try:
    import fcntl
    import termios
except ImportError:  # a system without them: what waits cannot be known there
    fcntl = None  # type: ignore[assignment]

DIAL_TIMEOUT = 3.0  # for a robot to take the call [s]
# A robot that confirms nothing for so long is gone. Confirmations are put off by up to 0.25 s; what
# has not arrived after 0.5 s is stale, and the robot has stopped itself [s].
UNCONFIRMED = 0.5
_DROP = struct.pack("ii", 1, 0)  # SO_LINGER: on, for no time
_NAP = 0.001  # between two looks at a busy connection [s]
# Notice within about 3 s that the other end has vanished without a word.
_OPTIONS = (
    ("SOL_SOCKET", "SO_KEEPALIVE", 1),
    ("IPPROTO_TCP", "TCP_NODELAY", 1),
    ("IPPROTO_TCP", "TCP_KEEPIDLE", 1),
    ("IPPROTO_TCP", "TCP_KEEPINTVL", 1),
    ("IPPROTO_TCP", "TCP_KEEPCNT", 2),
)


class TcpLink:
    """A connected TCP socket; see Link."""

    def __init__(self, connection: socket.socket, place: str) -> None:
        """Take over a connection.

        Args:
            connection: connected; closed by `close`.
            place: the other end's address, for messages.
        """
        self._socket, self._place, self._hung_up = connection, place, ""
        self._written = 0  # bytes so far
        self._unconfirmed: deque[tuple[int, float]] = deque()  # up to which byte, when [B, s]
        connection.setblocking(False)
        for level, name, value in _OPTIONS:
            if hasattr(socket, name):
                with suppress(OSError):  # the other end may be gone already; `read` will tell
                    connection.setsockopt(getattr(socket, level), getattr(socket, name), value)

    @property
    def place(self) -> str:
        """The other end's address."""
        return self._place

    def write(self, data: bytes) -> None:
        """Send all of it.

        Args:
            data: the message.

        Raises:
            RadioError: if the connection is gone, does not take it within 0.1 s, or the other end
                has confirmed nothing for 0.5 s.
        """
        deadline, view = monotonic() + WRITE_TIMEOUT, memoryview(data)
        try:
            self._need_confirmation()
            while view := view[self._send(view) :]:
                if monotonic() > deadline:
                    raise RadioError(f"radio {self._place}: takes nothing for {WRITE_TIMEOUT:g} s")
                sleep(_NAP)
        except OSError as error:
            raise RadioError(f"radio {self._place}: cannot write: {reason(error)}") from error

    def read(self) -> bytes:
        """Take what has arrived, without waiting.

        Returns:
            At most 4096 bytes, empty if there are none.

        Raises:
            RadioError: if the connection is gone or was hung up, or the other end has confirmed
                nothing for 0.5 s.
        """
        if self._hung_up:
            raise RadioError(f"radio {self._place}: {self._hung_up}")
        try:
            self._need_confirmation()
            data = self._socket.recv(READ_AT_ONCE)
        except BlockingIOError:
            return b""
        except OSError as error:
            raise RadioError(f"radio {self._place}: cannot read: {reason(error)}") from error
        if not data:
            raise RadioError(f"radio {self._place}: the robot has closed the connection")
        return data

    def discard(self) -> None:
        """TCP takes nothing back: what is under way is dropped by `close`."""

    def hang_up(self, why: str) -> None:
        """Make the next `read` fail, so that whoever serves the link gives it up. Never fails.

        Args:
            why: for the error.
        """
        self._hung_up = why

    def close(self) -> None:
        """Release it; the last words get 0.1 s to leave. Safe to call twice; never fails."""
        deadline = monotonic() + WRITE_TIMEOUT
        with suppress(OSError):
            while self._underway() and monotonic() < deadline:
                sleep(_NAP)
            if self._underway():  # a reset drops it; else it would arrive late
                self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _DROP)
        with suppress(OSError):
            self._socket.close()

    def _send(self, data: memoryview) -> int:
        try:
            sent = self._socket.send(data)
        except BlockingIOError:
            return 0
        self._written += sent
        self._unconfirmed.append((self._written, monotonic()))
        return sent

    def _need_confirmation(self) -> None:
        """Look how old the oldest byte is that the other end has not confirmed."""
        confirmed = self._written - self._underway()
        while self._unconfirmed and self._unconfirmed[0][0] <= confirmed:
            self._unconfirmed.popleft()
        if self._unconfirmed and monotonic() - self._unconfirmed[0][1] > UNCONFIRMED:
            raise RadioError(f"radio {self._place}: confirms nothing for {UNCONFIRMED:g} s")

    def _underway(self) -> int:
        """Bytes the other end has not confirmed; 0 where the system does not say."""
        if fcntl is None:
            return 0
        answer = fcntl.ioctl(self._socket.fileno(), termios.TIOCOUTQ, bytes(4))
        return int.from_bytes(answer, sys.byteorder)


def dial(place: str) -> TcpLink:
    """Call a robot that listens.

    Args:
        place: HOST:PORT.

    Returns:
        The link.

    Raises:
        RadioError: if nobody answers within 3 s.
    """
    try:
        return TcpLink(socket.create_connection(parse_address(place), DIAL_TIMEOUT), place)
    except (OSError, UnicodeError) as error:
        raise RadioError(f"radio {place}: cannot connect: {reason(error)}") from error


def reason(error: Exception) -> str:
    """The system's words for what happened to a socket.

    Args:
        error: as raised.

    Returns:
        A few words.
    """
    number = getattr(error, "errno", None)
    if isinstance(error, TimeoutError):
        return f"no answer within {DIAL_TIMEOUT:g} s"
    if isinstance(error, socket.gaierror) or not isinstance(number, int):
        return "no such host" if isinstance(error, (socket.gaierror, UnicodeError)) else str(error)
    return os.strerror(number)
