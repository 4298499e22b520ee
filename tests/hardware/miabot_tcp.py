"""Emulated Miabots on TCP, in both roles: one that listens, and one that calls a host."""

import select
import socket
import threading
from collections.abc import Callable
from contextlib import suppress
from time import monotonic

from tests.hardware.closed import Closed
from tests.hardware.miabot_robot import Miabot

STRIDE = 0.02  # longest sleep [s]


class TcpMiabot(Closed):
    """A robot that listens on a port, or calls a host and calls again when it was cut off.

    Attributes:
        robot: the firmware.
        place: HOST:PORT where it listens, or which it calls.
        calls: connections so far.
        deaf: while true it takes bytes and answers nothing: its radio is up, its processor is not.
    """

    def __init__(
        self,
        robot: Miabot,
        host: str | None = None,
        clock: Callable[[], float] = monotonic,
        again: bool = True,
    ) -> None:
        """Switch it on.

        Args:
            robot: the firmware.
            host: HOST:PORT it calls; None: it listens on a free port of loopback.
            clock: the robot's time.
            again: whether it calls again when it was cut off.
        """
        self.robot, self._clock, self._again = robot, clock, again
        self.calls, self.deaf = 0, False
        self._server = None if host else socket.create_server(("127.0.0.1", 0))
        if self._server is not None:
            self._server.settimeout(STRIDE)
            host = f"127.0.0.1:{self._server.getsockname()[1]}"
        assert host is not None
        self.place = host
        self._talk: socket.socket | None = None
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._live, daemon=True)
        self._thread.start()

    def say(self, data: bytes) -> None:
        """Send anything to whoever is connected."""
        assert self._talk is not None
        self._talk.sendall(data)

    def cut(self) -> None:
        """Break the present connection off."""
        if self._talk is not None:
            self._talk.shutdown(socket.SHUT_RDWR)

    def close(self) -> None:
        """Switch it off. Safe to call twice."""
        self._ending.set()
        self._thread.join()
        if self._server is not None:
            self._server.close()

    def _live(self) -> None:
        while not self._ending.is_set():
            self._talk = self._connected()
            if self._talk is not None:
                self.calls += 1
                with suppress(OSError):
                    self._serve(self._talk)
                self._talk.close()
                if self._server is None and not self._again:
                    return
            self.robot.wake(self._clock())
            self._ending.wait(STRIDE)

    def _connected(self) -> socket.socket | None:
        try:
            if self._server is not None:
                return self._server.accept()[0]
            host, _, port = self.place.rpartition(":")
            return socket.create_connection((host, int(port)), 1.0)
        except OSError:
            return None

    def _serve(self, talk: socket.socket) -> None:
        while not self._ending.is_set():
            wait = min(max(self.robot.due() - self._clock(), 0.0), STRIDE)
            ready, _, _ = select.select((talk,), (), (), wait)
            data = talk.recv(4096) if ready else b""
            if ready and not data:
                return
            t = self._clock()
            answer = b"" if self.deaf else self.robot.receive(data, t)
            answer += self.robot.wake(t)
            if answer:
                talk.sendall(answer)


def free_port() -> int:
    """A TCP port that nobody uses now."""
    with socket.create_server(("127.0.0.1", 0)) as probe:
        return int(probe.getsockname()[1])
