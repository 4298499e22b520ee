"""Miabot PROs, each on a link of its own: commands out, and how the links are doing."""

from collections.abc import Callable
from time import monotonic

from control.command import Command, RobotId
from pipeline.errors import RadioError
from pipeline.ports import Clock
from pipeline.radios import miabot_text as text
from pipeline.radios.miabot_line import MiabotLine, MiabotPort, MiabotSettings
from pipeline.radios.reception import Reception
from pipeline.radios.report import RobotReport
from pipeline.radios.screen import Screen

CONNECT_TIMEOUT = 10.0  # Bluetooth takes seconds to page a robot [s]
STOP_TIMEOUT, CLOSE_TIMEOUT = 0.5, 0.4  # together less than a second, for all links at once [s]
_LOOK = 0.1  # how often somebody who waits is asked whether he still wants to [s]


class MiabotRadio:
    """A command sink for Miabots.

    Attributes:
        screen: counts commands that were held back before any link.
        unknown: commands for robots that have no port.
    """

    def __init__(
        self,
        ports: tuple[MiabotPort, ...],
        settings: MiabotSettings,
        clock: Clock,
        patience: float = CONNECT_TIMEOUT,
        interrupted: Callable[[], bool] = lambda: False,
        reception: Reception | None = None,
    ) -> None:
        """Connect to all robots at once, and set their own timeout.

        Args:
            ports: one per robot.
            settings: common to all.
            clock: the run's clock, on which commands go stale.
            patience: for all robots together [s].
            interrupted: asked while robots are waited for.
            reception: where robots connect that call themselves; closed with the radio.

        Raises:
            RadioError: if a port cannot be opened or a robot does not answer; all are closed then.
            KeyboardInterrupt: if the wait was interrupted; all are closed then.
        """
        self._settings, self._clock, self._reception = settings, clock, reception
        self.screen, self.unknown = Screen(), 0
        self._robots = {port.robot_id: MiabotLine(port, settings, clock) for port in ports}
        if reception is not None:
            reception.admit(self._answers)
        try:
            self._wait_for_all(patience, interrupted)
        except BaseException:
            self.close()
            raise

    @property
    def min_period(self) -> float:
        """How often the longest wheel command fits into a link's budget [s]."""
        return text.LONGEST_COMMAND / self._settings.bytes_per_second

    @property
    def reports(self) -> tuple[RobotReport, ...]:
        """How each link is doing, in the order of the ports."""
        return tuple(robot.report() for robot in self._robots.values())

    @property
    def notes(self) -> tuple[str, ...]:
        """What else is to be told: who was refused, and commands for nobody."""
        refused = () if self._reception is None else self._reception.notes
        portless = f"radio: {self.unknown} commands were for robots without a port"
        return (*refused, portless) if self.unknown else refused

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
        if self._reception is not None:
            self._reception.close()
        deadline = monotonic() + CLOSE_TIMEOUT
        for robot in self._robots.values():
            robot.sender.close()
        for robot in self._robots.values():
            robot.sender.ended(max(0.0, deadline - monotonic()))

    def _wait_for_all(self, patience: float, interrupted: Callable[[], bool]) -> None:
        deadline = monotonic() + patience
        for robot in self._robots.values():
            while not robot.sender.connected(min(_LOOK, max(0.0, deadline - monotonic()))):
                if robot.sender.error is not None:
                    raise robot.sender.error
                if interrupted():
                    raise KeyboardInterrupt
                if monotonic() >= deadline:
                    raise RadioError(self._missing(patience))

    def _missing(self, patience: float) -> str:
        """Who has not come, in one line."""
        missing = [robot for robot in self._robots.values() if not robot.sender.up]
        if self._reception is None:
            return f"radio {missing[0].port}: does not connect within {patience:g} s"
        names = ", ".join(str(robot.robot_id) for robot in missing)
        return (
            f"radio {self._reception.place}: robot{'s' * (len(missing) > 1)} {names} of "
            f"{len(self._robots)} did not connect within {patience:g} s"
            + "".join(f"; {note}" for note in self._reception.notes)
        )

    def _answers(self, robot_id: RobotId, timeout: float) -> bool:
        return self._robots[robot_id].answers(timeout)
