"""One Miabot: how it is greeted, the sender that serves its link, and what it has said."""

from collections.abc import Callable
from dataclasses import dataclass, field
from time import monotonic, sleep

from control.command import RobotId
from pipeline.errors import RadioError
from pipeline.ports import Clock
from pipeline.radios import miabot_text as text
from pipeline.radios.link import Link, SerialLink
from pipeline.radios.newest import LinkSettings, NewestSender
from pipeline.radios.report import RobotReport

ANSWER_TIMEOUT = 1.0  # for "who are you" [s]

Open = Callable[[str], Link | None]


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
class MiabotPort:
    """Which robot is reached where.

    Attributes:
        robot_id: the robot.
        port: its serial device or address.
        open: opens the link to a port; None: nobody is there yet.
        named: whether the robot must answer "who are you" with its id, at every connect.
    """

    robot_id: RobotId
    port: str
    open: Open = SerialLink
    named: bool = False


class MiabotLine:
    """One robot: its sender and what it has said."""

    def __init__(self, port: MiabotPort, settings: MiabotSettings, clock: Clock) -> None:
        """Start to connect.

        Args:
            port: where the robot is.
            settings: common to all links.
            clock: the run's clock, on which commands go stale.
        """
        self.robot_id, self.port = port.robot_id, port.port
        self._open, self._named, self._settings = port.open, port.named, settings
        self._clock, self._parser = clock, text.ReplyParser()
        self._foreign, self._nonsense, self._has_answered = 0, 0, False
        self._encoders: text.EncoderCounts | None = None
        self.sender = NewestSender(
            LinkSettings(port.port, text.STOP, settings.bytes_per_second, text.WHO_ARE_YOU),
            clock,
            self._connect,
            self._hear,
        )

    def report(self) -> RobotReport:
        """Say how the link is doing.

        Returns:
            State, counts, round trips and encoders.
        """
        sender = self.sender
        return RobotReport(
            self.robot_id,
            self.port,
            sender.up,
            None if sender.error is None else str(sender.error),
            sender.counts,
            self._parser.garbage + self._nonsense,
            self._foreign,
            sender.questions.tally,
            self._encoders,
        )

    def answers(self, timeout: float) -> bool:
        """Find out whether the robot on the present link is alive.

        Args:
            timeout: its patience [s].

        Returns:
            Whether it answers.
        """
        self.sender.questions.ask_soon()
        return self.sender.up and self.sender.questions.answered_within(timeout)

    def _connect(self) -> Link | None:
        link = self._open(self.port)
        if link is None:
            return None
        try:
            self._greet(link)
        except RadioError:
            link.close()
            raise
        return link

    def _greet(self, link: Link) -> None:
        """Set the robot's own deadman first; then see who is there."""
        link.write(text.timeout_command(self._settings.timeout_ms))
        if self._settings.ask_who or self._named or self._has_answered:
            number = ask_number(link, self._parser, self.port)
            if self._named and isinstance(self.robot_id, int) and number != self.robot_id:
                raise RadioError(
                    f"radio {self.port}: robot {number} answers, not robot {self.robot_id}"
                )
        if self._settings.encoder_period_ms is not None:
            link.write(text.encoder_stream_command(self._settings.encoder_period_ms))

    def _hear(self, data: bytes) -> None:
        for reply in self._parser.feed(data):
            number, encoders = text.robot_number(reply), text.encoder_counts(reply)
            self._encoders = encoders or self._encoders
            if number is not None:
                self._has_answered = True
                self.sender.questions.answered(self._clock.now())
                self._foreign += isinstance(self.robot_id, int) and number != self.robot_id
            elif encoders is None:
                self._nonsense += len(reply) + len("<>")


def ask_number(link: Link, parser: text.ReplyParser, place: str) -> int:
    """Ask a robot who it is.

    Args:
        link: to the robot; nobody else may read it meanwhile.
        parser: of what it says.
        place: the robot's port or address, for the error.

    Returns:
        Its number.

    Raises:
        RadioError: if the link is gone or nothing answers within a second.
    """
    link.write(text.WHO_ARE_YOU)
    deadline = monotonic() + ANSWER_TIMEOUT
    while monotonic() < deadline:
        for reply in parser.feed(link.read()):
            number = text.robot_number(reply)
            if number is not None:
                return number
        sleep(0.005)
    raise RadioError(f"radio {place}: no Miabot answers within {ANSWER_TIMEOUT:g} s")
