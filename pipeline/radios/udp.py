"""Datagrams to one address. UDP has no link: only a refusal by the other machine can be noticed."""

import socket
from contextlib import suppress

from pipeline.errors import RadioError
from pipeline.radios.address import parse_address
from pipeline.radios.link import READ_AT_ONCE
from pipeline.radios.tcp import reason

DATAGRAMS_AT_ONCE = 256  # what is taken in one go, so that a flood never holds up a command


class UdpLink:
    """A UDP socket that sends to one address; see Link."""

    def __init__(self, place: str) -> None:
        """Open a socket.

        Args:
            place: HOST:PORT.

        Raises:
            RadioError: if there is no such host.
        """
        self._place = place
        host, port = parse_address(place)
        try:
            family, kind, *_, address = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[0]
            self._socket = socket.socket(family, kind)
            self._socket.setblocking(False)
            self._socket.connect(address)
        except (OSError, UnicodeError) as error:
            raise RadioError(f"radio {place}: cannot open: {reason(error)}") from error

    def write(self, data: bytes) -> None:
        """Send one datagram, without waiting.

        Args:
            data: the message.

        Raises:
            RadioError: if the system or the other machine refuses it.
        """
        try:
            self._socket.send(data)
        except OSError as error:
            raise RadioError(f"radio {self._place}: cannot send: {_refusal(error)}") from error

    def read(self) -> bytes:
        """Take what has arrived, without waiting.

        Returns:
            At most 8191 bytes of at most 256 datagrams, empty if there are none.

        Raises:
            RadioError: if the other machine refused what was sent.
        """
        data = b""
        try:
            for _ in range(DATAGRAMS_AT_ONCE):
                data += self._socket.recv(READ_AT_ONCE)
                if len(data) >= READ_AT_ONCE:
                    break
        except BlockingIOError:
            pass  # that was all
        except OSError as error:
            raise RadioError(f"radio {self._place}: cannot send: {_refusal(error)}") from error
        return data

    def discard(self) -> None:
        """Nothing waits in a UDP socket."""

    def close(self) -> None:
        """Release the socket. Safe to call twice; never fails."""
        with suppress(OSError):
            self._socket.close()


def _refusal(error: OSError) -> str:
    refused = isinstance(error, ConnectionRefusedError)
    return "nobody listens there" if refused else reason(error)
