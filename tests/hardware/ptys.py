"""Serial ports with robots at their far ends: ptys, which can be unplugged or blocked."""

import os
import select
import threading
import tty
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from queue import SimpleQueue
from tempfile import TemporaryDirectory
from time import monotonic
from typing import Protocol

from tests.hardware.closed import Closed

STRIDE = 0.05  # longest sleep of the robots' thread [s]
NOTHING = b" " * 1024  # what no robot takes for a command


class Firmware(Protocol):
    """What sits at the far end of a serial line."""

    def receive(self, data: bytes, t: float) -> bytes:
        """Take bytes, and answer."""
        ...

    def wake(self, t: float) -> bytes:
        """Do what is due by now."""
        ...

    def due(self) -> float:
        """When it has to be woken next [s]."""
        ...


class Line:
    """A robot and its port, which keeps its path through all that happens to it."""

    def __init__(self, robot: Firmware, path: Path) -> None:
        """Plug it in.

        Args:
            robot: who listens.
            path: of the port.
        """
        self.robot, self.path, self.deaf, self.full = robot, path, False, False
        self.master = self._slave = -1
        self.plug()

    @property
    def heard(self) -> bool:
        """Whether the robot takes what is sent."""
        return self.master >= 0 and not self.deaf

    def plug(self) -> None:
        """Be there, behind a new pty at the same path."""
        self.master, self._slave = os.openpty()
        tty.setraw(self._slave)
        os.set_blocking(self._slave, False)
        self.path.symlink_to(os.ttyname(self._slave))

    def unplug(self) -> None:
        """Be gone; who has the port open sees it go. Safe to call twice."""
        if self.master >= 0:
            self.path.unlink()
            os.close(self.master)
            os.close(self._slave)
            self.master = -1

    def deafen(self, t: float, full: bool) -> None:
        """Read nothing any more; with a full buffer the port takes nothing either."""
        if self.heard:  # what has been sent by now has arrived
            self.serve(bool(select.select((self.master,), (), (), 0.0)[0]), t)
        self.deaf, self.full = True, full
        self._fill()

    def listen(self) -> None:
        """Read again, first of all what has been waiting."""
        self.deaf = self.full = False

    def serve(self, ready: bool, t: float) -> None:
        """Let the robot hear, wake and answer; keep a blocked port's buffer full."""
        data = os.read(self.master, 4096) if ready and self.heard else b""
        answer = self.robot.receive(data, t) + self.robot.wake(t)
        if answer and self.heard:
            os.write(self.master, answer)
        self._fill()

    def _fill(self) -> None:
        """Whoever blocks a line leaves no room for what is sent after somebody has cleared it."""
        with suppress(BlockingIOError):
            while self.full and self.master >= 0:
                os.write(self._slave, NOTHING)


class Ptys(Closed):
    """Robots on ptys, served by one thread.

    Attributes:
        paths: serial ports the robots are reached through, in their order.
    """

    def __init__(self, robots: Sequence[Firmware], clock: Callable[[], float] = monotonic) -> None:
        """Open a pty per robot.

        Args:
            robots: who listens.
            clock: the robots' time.
        """
        self._clock, self._folder = clock, TemporaryDirectory()
        places = [Path(self._folder.name) / f"port-{n}" for n in range(1, len(robots) + 1)]
        self._lines = [Line(robot, place) for robot, place in zip(robots, places, strict=True)]
        self.paths = [str(place) for place in places]
        self._orders: SimpleQueue[Callable[[], None] | None] = SimpleQueue()
        self._bell, self._ring = os.pipe()
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def unplug(self, n: int) -> None:
        """Pull a port out; nobody can open it meanwhile.

        Args:
            n: its index.
        """
        self._order(self._lines[n].unplug)

    def plug(self, n: int) -> None:
        """Put a port in that was pulled out.

        Args:
            n: its index.
        """
        self._order(self._lines[n].plug)

    def deafen(self, n: int, full: bool) -> None:
        """Let a robot read nothing any more.

        Args:
            n: its index.
            full: its port takes nothing either; else it takes all for a while, and keeps it.
        """
        self._order(lambda: self._lines[n].deafen(self._clock(), full))

    def listen(self, n: int) -> None:
        """Let a robot read again.

        Args:
            n: its index.
        """
        self._order(self._lines[n].listen)

    def close(self) -> None:
        """Unplug all robots; whoever has a port open sees it go. Safe to call twice."""
        if not self._thread.is_alive():
            return
        self._order(None)
        self._thread.join()
        for line in self._lines:
            line.unplug()
        os.close(self._bell)
        os.close(self._ring)
        self._folder.cleanup()

    def _order(self, order: Callable[[], None] | None) -> None:
        """Have the thread do it: it alone touches the ptys."""
        self._orders.put(order)
        os.write(self._ring, b"x")

    def _serve(self) -> None:
        while True:
            wait = min(line.robot.due() for line in self._lines) - self._clock()
            waiting = (*(line.master for line in self._lines if line.heard), self._bell)
            ready, _, _ = select.select(waiting, (), (), max(0.0, min(wait, STRIDE)))
            for line in self._lines:
                line.serve(line.master in ready, self._clock())
            if self._bell in ready and not self._obey(len(os.read(self._bell, 4096))):
                return

    def _obey(self, count: int) -> bool:
        """Do what was ordered. Returns whether to go on."""
        for _ in range(count):
            order = self._orders.get_nowait()
            if order is None:
                return False
            order()
        return True
