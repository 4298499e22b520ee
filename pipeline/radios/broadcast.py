"""Robots that share one link: every message tells all of them what their wheels do."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from time import sleep

from control.command import Command, RobotId
from control.unicycle import WheelSpeeds
from pipeline.errors import RadioError
from pipeline.ports import Clock
from pipeline.radios.link import Link
from pipeline.radios.newest import LinkSettings, NewestSender
from pipeline.radios.report import RobotReport
from pipeline.radios.screen import Screen
from pipeline.radios.wheels import Wheels, limited_wheels

OPEN_TIMEOUT = 5.0  # for the link to come up [s]
STOP_TIMEOUT, CLOSE_TIMEOUT = 0.5, 0.4  # together less than a second [s]
_STANDING = WheelSpeeds(0.0, 0.0)

Speeds = Mapping[RobotId, WheelSpeeds]


@dataclass(frozen=True, slots=True)
class Channel:
    """A link to several robots and its language.

    Attributes:
        place: its port or address.
        open: opens the link; raises RadioError.
        encode: writes one message of wheel speeds [m/s].
        bytes_per_second: what the link carries [B/s].
        longest: of a message to all robots [B].
        refusal: how long the other machine may take to refuse the first message [s].
    """

    place: str
    open: Callable[[str], Link]
    encode: Callable[[Speeds], bytes]
    bytes_per_second: float
    longest: int
    refusal: float = 0.0


class BroadcastRadio:
    """A command sink whose robots neither answer nor, for all anybody knows, stop by themselves.

    So its sender stops them when no command has come for a while; no program does if the host dies.

    Attributes:
        screen: counts commands that were held back before the link.
        unknown: commands for robots that are not reached.
        min_period: how often the longest message fits into the link's budget [s].
    """

    def __init__(
        self,
        robots: tuple[RobotId, ...],
        channel: Channel,
        wheels: Wheels,
        silence: float,
        clock: Clock,
    ) -> None:
        """Open the link and let all robots stand.

        Args:
            robots: who is reached.
            channel: link and language.
            wheels: of the robots.
            silence: after so long without a command they are stopped [s].
            clock: the run's clock, on which commands go stale.

        Raises:
            RadioError: if the link cannot be opened within 5 s.
        """
        self._robots, self._channel, self._wheels, self._clock = robots, channel, wheels, clock
        self.screen, self.unknown, self._garbage = Screen(), 0, 0
        self.min_period = channel.longest / channel.bytes_per_second
        self._told: dict[RobotId, tuple[WheelSpeeds, float]] = {}
        self._stop = channel.encode(dict.fromkeys(robots, _STANDING))
        settings = LinkSettings(
            channel.place, self._stop, channel.bytes_per_second, silence=silence
        )
        self._sender = NewestSender(settings, clock, self._connect, self._hear)
        if not self._sender.connected(OPEN_TIMEOUT):
            error = self._sender.error
            self.close()
            raise error or RadioError(
                f"radio {channel.place}: does not open within {OPEN_TIMEOUT:g} s"
            )

    @property
    def reports(self) -> tuple[RobotReport, ...]:
        """How each robot's link is doing: they share one, and its counts."""
        up, error, counts = self._sender.up, self._sender.error, self._sender.counts
        said = None if error is None else str(error)
        return tuple(
            RobotReport(robot, self._channel.place, up, said, counts, self._garbage)
            for robot in self._robots
        )

    @property
    def notes(self) -> tuple[str, ...]:
        """What else is to be told: commands for nobody."""
        nobody = f"radio: {self.unknown} commands were for robots that are not reached"
        return (nobody,) if self.unknown else ()

    def send(self, commands: tuple[Command, ...], now: float) -> tuple[RobotId, ...]:
        """Hand the link one message with everybody's newest speeds; never waits.

        A robot whose last command has gone stale is told to stand; one that was never commanded
        is left out.

        Args:
            commands: at most one per robot.
            now: the moment of the cycle [s]; a command with valid_until < now is not sent.

        Returns:
            All robots if the link is down, and robots that are not reached.
        """
        strangers: list[RobotId] = []
        passed = self.screen.passed(commands, now)
        for command in passed:
            if command.robot_id in self._robots:
                track, fastest = self._wheels.track_width, self._wheels.fastest
                speeds = limited_wheels(command.twist, track, fastest)
                self._told[command.robot_id] = speeds, command.valid_until
            else:
                strangers.append(command.robot_id)
        self.unknown += len(strangers)
        if len(passed) > len(strangers):
            self._offer(now)
        return (*(() if self._sender.up else self._robots), *strangers)

    def stop(self, now: float) -> None:  # noqa: ARG002 - stops are sent at once, whatever the time
        """Tell every robot to stand, three times, within half a second even if the link blocks.

        Args:
            now: the moment of the call [s].
        """
        self._told.clear()
        self._sender.request_stop()
        self._sender.stopped(STOP_TIMEOUT)

    def close(self) -> None:
        """Stop every robot and release the link. Safe to call twice; takes less than a second."""
        self.stop(self._clock.now())
        self._sender.close()
        self._sender.ended(CLOSE_TIMEOUT)

    def _offer(self, now: float) -> None:
        fresh = {robot: told for robot, told in self._told.items() if told[1] >= now}
        speeds = {robot: fresh.get(robot, (_STANDING, now))[0] for robot in self._told}
        self._sender.offer(self._channel.encode(speeds), min(until for _, until in fresh.values()))

    def _connect(self) -> Link:
        link = self._channel.open(self._channel.place)
        try:
            link.write(self._stop)
            sleep(self._channel.refusal)
            self._hear(link.read())
        except RadioError:
            link.close()
            raise
        return link

    def _hear(self, data: bytes) -> None:
        self._garbage += len(data)  # these robots have nothing to say
