"""An emulated FIRASim: robots on a UDP port that drive on until they are told otherwise.

Packets are read by hand from the description: Packet.cmd = 1, Commands.robot_commands = 1,
Command: id = 1, yellowteam = 2, wheel_left = 6, wheel_right = 7 (rad/s); what is missing is 0.
"""

from dataclasses import dataclass
from time import monotonic

from tests.hardware.udp import UdpServer
from tests.hardware.wire import NotProtobuf, fields

ROBOTS = 5  # of each team, ids 0 to 4


@dataclass(frozen=True)
class Told:
    """One command to one robot.

    Attributes:
        t: when it came, monotonic [s].
        yellow: its team.
        robot: its id.
        left: wheel speed [rad/s].
        right: wheel speed [rad/s].
    """

    t: float
    yellow: bool
    robot: int
    left: float
    right: float


class FiraSim(UdpServer):
    """The simulator's command port.

    Attributes:
        told: all commands.
        packets: how many could be read.
        errors: datagrams that could not.
        strangers: commands for robots that are not on the field.
    """

    def __init__(self, port: int = 0) -> None:
        """Listen.

        Args:
            port: 0: a free one.
        """
        self.told: list[Told] = []
        self.packets, self.errors, self.strangers = 0, 0, 0
        super().__init__(port)

    def wheels(self, robot: int, yellow: bool = False) -> tuple[float, float] | None:
        """What a robot's wheels do, for ever if nothing else comes [rad/s]; None: never told."""
        for told in reversed(self.told):
            if (told.robot, told.yellow) == (robot, yellow):
                return told.left, told.right
        return None

    def received(self, data: bytes) -> None:
        """Obey one packet; one that cannot be read whole changes nothing."""
        try:
            commands = [_command(raw) for raw in _robot_commands(data)]
        except (NotProtobuf, TypeError):
            self.errors += 1
            return
        self.packets += 1
        for told in commands:
            if told.robot < ROBOTS:
                self.told.append(told)
            else:
                self.strangers += 1


def _robot_commands(data: bytes) -> list[bytes]:
    found = []
    for number, commands in fields(data):
        for inner, command in fields(_bytes(commands)) if number == 1 else ():
            found += [_bytes(command)] if inner == 1 else []
    return found


def _command(data: bytes) -> Told:
    values = {number: value for number, value in fields(data) if number in (1, 2, 6, 7)}
    left, right = values.get(6, 0.0), values.get(7, 0.0)
    if not isinstance(left, float) or not isinstance(right, float):
        raise NotProtobuf("wheel speeds are doubles")
    robot = values.get(1, 0)
    if not isinstance(robot, int):
        raise NotProtobuf("an id is a whole number")
    return Told(monotonic(), bool(values.get(2, 0)), robot, left, right)


def _bytes(value: int | float | bytes) -> bytes:
    if not isinstance(value, bytes):
        raise NotProtobuf("a message has a length")
    return value
