"""Miabot PROs over serial links: a sender per robot, the robots' own timeout, replies."""

from collections.abc import Callable
from dataclasses import dataclass, field
from time import monotonic, sleep

from control.command import Command, RobotId
from pipeline.errors import RadioError
from pipeline.ports import Clock
from pipeline.radios import miabot_text as text
from pipeline.radios.link import Link, SerialLink
from pipeline.radios.newest import LinkCounts, LinkSettings, NewestSender
from pipeline.radios.screen import Screen

CONNECT_TIMEOUT = 10.0  # Bluetooth takes seconds to page a robot [s]
ANSWER_TIMEOUT = 1.0  # for "who are you" [s]
STOP_TIMEOUT, CLOSE_TIMEOUT = 0.5, 0.4  # together less than a second, for all links at once [s]


@dataclass(frozen=True, slots=True)
class MiabotPort:
    """Which robot listens where.

    Attributes:
        robot_id: the robot.
        port: its serial device.
    """

    robot_id: RobotId
    port: str


@dataclass(frozen=True, slots=True)
class MiabotSettings:
    """What is common to all links.

    Attributes:
        drive: scale and track width of the robots.
        timeout_ms: after which a robot without commands stops itself [ms].
        bytes_per_second: what a link carries [B/s].
        ask_who: whether a robot must answer "who are you" at every connect.
        encoder_period_ms: how often robots report their encoders [ms]; None: never.
    """

    drive: text.Drive = field(default_factory=text.Drive)
    timeout_ms: int = 300
    bytes_per_second: float = 1150.0
    ask_who: bool = False
    encoder_period_ms: int | None = None


@dataclass(frozen=True, slots=True)
class MiabotReport:
    """How one link is doing.

    Attributes:
        robot_id: the robot.
        port: its serial device.
        up: whether the link is connected.
        error: why not, None if it is.
        counts: what became of the messages.
        garbage: bytes received that were no reply.
        encoders: the latest counts, None before the first.
    """

    robot_id: RobotId
    port: str
    up: bool
    error: str | None
    counts: LinkCounts
    garbage: int
    encoders: text.EncoderCounts | None


class MiabotRadio:
    """A command sink for Miabots.

    Attributes:
        screen: counts commands that were held back before any link.
        unknown: commands for robots that have no port.
    """

    def __init__(
        self, ports: tuple[MiabotPort, ...], settings: MiabotSettings, clock: Clock
    ) -> None:
        """Connect to all robots at once, and set their own timeout.

        Args:
            ports: one per robot.
            settings: common to all.
            clock: the run's clock, on which commands go stale.

        Raises:
            RadioError: if a port cannot be opened or a robot does not answer; all are closed then.
        """
        self._settings, self._clock = settings, clock
        self.screen, self.unknown = Screen(), 0
        self._robots = {port.robot_id: _Miabot(port, settings, clock) for port in ports}
        deadline = monotonic() + CONNECT_TIMEOUT
        for robot in self._robots.values():
            if not robot.sender.connected(max(0.0, deadline - monotonic())):
                error = robot.sender.error
                self.close()
                raise error or RadioError(
                    f"radio {robot.port}: does not connect within {CONNECT_TIMEOUT:g} s"
                )

    @property
    def min_period(self) -> float:
        """How often the longest wheel command fits into a link's budget [s]."""
        return text.LONGEST_COMMAND / self._settings.bytes_per_second

    @property
    def reports(self) -> tuple[MiabotReport, ...]:
        """How each link is doing, in the order of the ports."""
        return tuple(robot.report() for robot in self._robots.values())

    def send(self, commands: tuple[Command, ...], now: float) -> tuple[RobotId, ...]:
        """Hand each link its newest command; never waits.

        Args:
            commands: at most one per robot.
            now: the moment of the cycle [s]; a command with valid_until < now is not sent.

        Returns:
            Robots whose link is down, and robots without a port.
        """
        portless: list[RobotId] = []
        for command in self.screen.passed(commands, now):
            robot = self._robots.get(command.robot_id)
            if robot is None:
                portless.append(command.robot_id)
                continue
            units = text.wheel_units(command.twist, self._settings.drive)
            robot.sender.offer(text.speed_command(*units), command.valid_until)
        self.unknown += len(portless)
        down = [robot_id for robot_id, robot in self._robots.items() if not robot.sender.up]
        return (*down, *portless)

    def stop(self, now: float) -> None:  # noqa: ARG002 - stops are sent at once, whatever the time
        """Send stop to every robot, three times, within half a second even if ports block.

        Args:
            now: the moment of the call [s].
        """
        deadline = monotonic() + STOP_TIMEOUT
        for robot in self._robots.values():
            robot.sender.request_stop()
        for robot in self._robots.values():
            robot.sender.stopped(max(0.0, deadline - monotonic()))

    def close(self) -> None:
        """Stop every robot and release the ports. Safe to call twice; takes less than a second."""
        self.stop(self._clock.now())
        deadline = monotonic() + CLOSE_TIMEOUT
        for robot in self._robots.values():
            robot.sender.close()
        for robot in self._robots.values():
            robot.sender.ended(max(0.0, deadline - monotonic()))


class _Miabot:
    """One robot: its sender and what it has said."""

    def __init__(self, port: MiabotPort, settings: MiabotSettings, clock: Clock) -> None:
        self.robot_id, self.port, self._settings = port.robot_id, port.port, settings
        self._parser = text.ReplyParser()
        self._encoders: text.EncoderCounts | None = None
        self.sender = NewestSender(
            LinkSettings(port.port, text.STOP, settings.bytes_per_second),
            clock,
            self._connect,
            self._hear,
        )

    def report(self) -> MiabotReport:
        """Say how the link is doing.

        Returns:
            State, counts and encoders.
        """
        sender = self.sender
        error = None if sender.error is None else str(sender.error)
        garbage, encoders = self._parser.garbage, self._encoders
        return MiabotReport(
            self.robot_id, self.port, sender.up, error, sender.counts, garbage, encoders
        )

    def _connect(self) -> Link:
        link = SerialLink(self.port)
        try:
            self._greet(link)
        except RadioError:
            link.close()
            raise
        return link

    def _greet(self, link: Link) -> None:
        """Set the robot's own deadman first; then see who is there."""
        link.write(text.timeout_command(self._settings.timeout_ms))
        if self._settings.ask_who:
            link.write(text.WHO_ARE_YOU)
            _await(lambda: any(r.startswith("test#") for r in self._replies(link)), self.port)
        if self._settings.encoder_period_ms is not None:
            link.write(text.encoder_stream_command(self._settings.encoder_period_ms))

    def _replies(self, link: Link) -> tuple[str, ...]:
        return self._parser.feed(link.read())

    def _hear(self, data: bytes) -> None:
        for reply in self._parser.feed(data):
            self._encoders = text.encoder_counts(reply) or self._encoders


def _await(answered: Callable[[], bool], port: str) -> None:
    deadline = monotonic() + ANSWER_TIMEOUT
    while not answered():
        if monotonic() > deadline:
            raise RadioError(f"radio {port}: no Miabot answers within {ANSWER_TIMEOUT:g} s")
        sleep(0.005)
