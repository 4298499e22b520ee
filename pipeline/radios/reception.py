"""Where robots connect that call the host: each is asked who it is, and let in or refused."""

import socket
import threading
from collections import Counter
from collections.abc import Callable
from contextlib import suppress

from control.command import RobotId
from pipeline.errors import RadioError
from pipeline.radios import miabot_text as text
from pipeline.radios.address import parse_address
from pipeline.radios.miabot_line import ask_number
from pipeline.radios.tcp import TcpLink, reason

AT_ONCE = 16  # callers that are being asked at the same time; further ones are refused
BACKLOG = 128  # callers that the system keeps until they are looked at
ALIVE_TIMEOUT = 0.5  # for a robot that drives to show that it is still there [s]
ARRIVAL_TIMEOUT = 0.1  # how long a sender waits for its robot before it looks up [s]
TAKEN_TIMEOUT = 5.0  # a link that was let in is served within, also after a failure [s]
REASONS = 20  # different reasons for a refusal that are kept; all are counted


class Reception:
    """A TCP server for robots."""

    def __init__(self, place: str, robots: tuple[RobotId, ...], timeout_ms: int) -> None:
        """Begin to listen; nobody is let in before `admit`.

        Args:
            place: HOST:PORT to listen at.
            robots: who belongs to the formation; their ids are the numbers the robots tell.
            timeout_ms: of the robots' own deadman, set before anything else [ms].

        Raises:
            RadioError: if the address cannot be listened at.
        """
        self.place, self._timeout_ms = place, timeout_ms
        host, port = parse_address(place)
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        try:
            self._server = socket.create_server((host, port), family=family, backlog=BACKLOG)
        except (OSError, UnicodeError) as error:
            raise RadioError(f"radio {place}: cannot listen: {reason(error)}") from error
        self._doors = {robot: _Door() for robot in robots}
        self._asked = threading.BoundedSemaphore(AT_ONCE)
        self._refused: Counter[str] = Counter()
        self._counting = threading.Lock()
        self._closing = False
        self._answers: Callable[[RobotId, float], bool] = lambda _robot, _timeout: False

    @property
    def notes(self) -> tuple[str, ...]:
        """Who was refused, why, and how often."""
        with self._counting:
            return tuple(f"refused {count} times: {why}" for why, count in self._refused.items())

    def admit(self, answers: Callable[[RobotId, float], bool]) -> None:
        """Begin to let robots in.

        Args:
            answers: whether a robot that is being served answers within a time [s].
        """
        self._answers = answers
        threading.Thread(target=self._accept, name=self.place, daemon=True).start()

    def door_of(self, robot: RobotId) -> Callable[[str], TcpLink | None]:
        """Where a robot's newest link is handed out.

        Args:
            robot: its id.

        Returns:
            A function that waits a moment for it; None: it has not come.
        """
        return lambda _place: self._doors[robot].take(ARRIVAL_TIMEOUT)

    def close(self) -> None:
        """Let nobody in any more. Safe to call twice; never fails."""
        self._closing = True
        with suppress(OSError):  # wakes `accept`, which a mere close would not
            self._server.shutdown(socket.SHUT_RDWR)
        with suppress(OSError):
            self._server.close()
        for door in self._doors.values():
            link = door.take(0.0)
            if link is not None:
                link.close()

    def _accept(self) -> None:
        while not self._closing:
            try:
                connection, address = self._server.accept()
            except OSError:
                return  # closed
            if self._asked.acquire(blocking=False):
                link = TcpLink(connection, str(address[0]))
                threading.Thread(target=self._ask, args=(link,), daemon=True).start()
            else:  # without a word: a flood must not hold up the next caller
                self._count(f"{address[0]}: too many callers at once")
                connection.close()

    def _ask(self, link: TcpLink) -> None:
        try:
            link.write(text.timeout_command(self._timeout_ms))
            self._let_in(link, ask_number(link, text.ReplyParser(), link.place))
        except RadioError as error:
            self._refuse(link, str(error).removeprefix("radio "))
        finally:
            self._asked.release()

    def _let_in(self, link: TcpLink, number: int) -> None:
        door = self._doors.get(number)
        if door is None:
            self._refuse(link, f"{link.place}: robot {number} is not in the formation")
            return
        with door.lock:  # one caller at a time for each robot
            if not door.free(TAKEN_TIMEOUT) or self._answers(number, ALIVE_TIMEOUT):
                self._refuse(link, f"{link.place}: a second robot {number}, the first one answers")
            else:
                door.put(link)
        if self._closing and (late := door.take(0.0)):
            late.close()

    def _refuse(self, link: TcpLink, why: str) -> None:
        self._count(why)
        with suppress(RadioError):
            link.write(text.STOP)
        link.close()

    def _count(self, why: str) -> None:
        with self._counting:
            known = why in self._refused or len(self._refused) < REASONS
            self._refused[why if known else "others"] += 1


class _Door:
    """Where a robot's newest link waits for its sender."""

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self._news = threading.Condition()
        self._waiting: TcpLink | None = None
        self._served: TcpLink | None = None

    def put(self, link: TcpLink) -> None:
        """Hand in a link; the one before it is given up."""
        with self._news:
            if self._served is not None:
                self._served.hang_up("the robot has connected anew")
            self._waiting = link
            self._news.notify_all()

    def take(self, timeout: float) -> TcpLink | None:
        """Take what waits."""
        with self._news:
            self._news.wait_for(lambda: self._waiting is not None, timeout)
            link, self._waiting = self._waiting, None
            self._served = link or self._served
            self._news.notify_all()
            return link

    def free(self, timeout: float) -> bool:
        """Wait until nothing waits here."""
        with self._news:
            return self._news.wait_for(lambda: self._waiting is None, timeout)
