"""A UDP port that is served by a thread."""

import socket
import threading

from tests.hardware.closed import Closed

LARGEST = 65_536  # of a datagram [B]


class UdpServer(Closed):
    """Takes datagrams until it is closed.

    Attributes:
        place: HOST:PORT it listens at.
    """

    def __init__(self, port: int = 0) -> None:
        """Listen on loopback.

        Args:
            port: 0: a free one.
        """
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
        self._socket.bind(("127.0.0.1", port))
        self._socket.settimeout(0.05)
        self.port = int(self._socket.getsockname()[1])
        self.place = f"127.0.0.1:{self.port}"
        self.sender: tuple[str, int] | None = None
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def received(self, data: bytes) -> None:
        """Take one datagram.

        Args:
            data: its bytes.
        """
        raise NotImplementedError

    def say(self, data: bytes) -> None:
        """Send a datagram back to whoever sent the last one.

        Args:
            data: its bytes.
        """
        assert self.sender is not None
        self._socket.sendto(data, self.sender)

    def close(self) -> None:
        """Stop listening. Safe to call twice."""
        self._ending.set()
        self._thread.join()
        self._socket.close()

    def _serve(self) -> None:
        while not self._ending.is_set():
            try:
                data, self.sender = self._socket.recvfrom(LARGEST)
            except TimeoutError:
                continue
            self.received(data)
