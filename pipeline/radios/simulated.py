"""The link to simulated robots: delay, loss and a limited bandwidth, all repeatable."""

from collections import deque
from dataclasses import dataclass, field
from math import inf

import numpy as np

from control.command import Command, RobotId
from control.unicycle import Twist
from datasets.world import World
from pipeline.radios.budget import Budget
from pipeline.radios.newest import RATE_WINDOW, STOP_SPACING, STOPS
from pipeline.radios.report import SIMULATED, LinkCounts, RobotReport
from pipeline.radios.screen import Screen

MESSAGE_SIZE = 12  # of a typical wheel command, "[=-500,-500]" [B]


@dataclass(frozen=True, slots=True)
class Copies:
    """Messages that arrive twice.

    Attributes:
        share: of the messages that arrive, in [0, 1).
        delay: a copy comes up to so much after its message, as drawn [s].
    """

    share: float = 0.0
    delay: float = 0.01


_NO_COPIES = Copies()


@dataclass(slots=True)
class _Tally:
    """What became of one robot's messages."""

    sent: int = 0
    replaced: int = 0
    stale: int = 0
    lost: int = 0
    doubled: int = 0
    times: deque[float] = field(default_factory=lambda: deque(maxlen=1000))


class SimulatedRadio:
    """Hands commands to a world.

    Attributes:
        min_period: how often a command fits into the bandwidth [s].
        screen: counts what was held back.
    """

    def __init__(
        self,
        world: World,
        delay: float = 0.005,
        loss: float = 0.0,
        bandwidth_Bps: float | None = None,
        seed: int = 0,
        copies: Copies = _NO_COPIES,
    ) -> None:
        """Connect to the robots of a world.

        Args:
            world: its robots obey.
            delay: from sending to the wheels [s].
            loss: probability that a message never arrives, in [0, 1].
            bandwidth_Bps: what the link to each robot carries [B/s]; None: without limit.
            seed: of losses and copies.
            copies: messages that arrive twice, the second time perhaps behind a newer one.
        """
        self._world, self._delay, self._loss, self._copies = world, delay, loss, copies
        self._rng, self._copy_rng = np.random.default_rng(seed), np.random.default_rng((seed, 1))
        rate = inf if bandwidth_Bps is None else bandwidth_Bps
        self._budgets = {plant.robot_id: Budget(rate) for plant in world.plants}
        self._tallies = {plant.robot_id: _Tally() for plant in world.plants}
        self._waiting: dict[RobotId, Command] = {}
        self.min_period = MESSAGE_SIZE / rate
        self.screen, self._now = Screen(), 0.0

    @property
    def sent(self) -> int:
        """Messages that went on air, with those that were lost."""
        return sum(tally.sent for tally in self._tallies.values())

    @property
    def lost(self) -> int:
        """Messages that never arrived."""
        return sum(tally.lost for tally in self._tallies.values())

    @property
    def replaced(self) -> int:
        """Messages overtaken by a newer one while the link was busy."""
        return sum(tally.replaced for tally in self._tallies.values())

    @property
    def doubled(self) -> int:
        """Messages that arrived twice."""
        return sum(tally.doubled for tally in self._tallies.values())

    @property
    def reports(self) -> tuple[RobotReport, ...]:
        """How each robot's link is doing; its round trip is not asked for, its losses are known."""
        return tuple(self._report(robot, tally) for robot, tally in self._tallies.items())

    def send(self, commands: tuple[Command, ...], now: float) -> tuple[RobotId, ...]:
        """Send the newest commands; while a link is busy only the newest waits.

        Args:
            commands: at most one per robot.
            now: the moment of the cycle [s]; a command with valid_until < now is not sent.

        Returns:
            Nobody: simulated links do not break.

        Raises:
            SimulationError: if the world has no such robot.
        """
        self._now = now
        for command in self.screen.passed(commands, now):
            if command.robot_id in self._waiting:
                self._tallies[command.robot_id].replaced += 1
            self._waiting[command.robot_id] = command
        for command in tuple(self._waiting.values()):
            if self._free(command.robot_id, now):
                del self._waiting[command.robot_id]
                self._send_if_fresh(command, now)
        return ()

    def stop(self, now: float) -> None:
        """Send stop to every robot, three times.

        Args:
            now: the moment of the call [s].
        """
        self._waiting.clear()
        for repeat in range(STOPS):
            for robot_id in self._budgets:
                self._transmit(robot_id, Twist(0.0, 0.0), now + repeat * STOP_SPACING)

    def close(self) -> None:
        """Release nothing. Safe to call twice."""

    def _free(self, robot_id: RobotId, now: float) -> bool:
        budget = self._budgets.get(robot_id)
        return budget is None or budget.wait(now) == 0.0

    def _send_if_fresh(self, command: Command, now: float) -> None:
        """A command that waited may have gone stale."""
        if self.screen.passed((command,), now):
            self._transmit(command.robot_id, command.twist, now)
        else:
            self._tallies[command.robot_id].stale += 1

    def _transmit(self, robot_id: RobotId, twist: Twist, t: float) -> None:
        tally = self._tallies.setdefault(robot_id, _Tally())  # the world refuses strangers
        tally.sent += 1
        tally.times.append(t)
        if robot_id in self._budgets:
            self._budgets[robot_id].spend(MESSAGE_SIZE, t)
        if self._rng.random() < self._loss:
            tally.lost += 1
            return
        self._world.command(robot_id, twist, t + self._delay)
        if self._copies.share and self._copy_rng.random() < self._copies.share:
            tally.doubled += 1
            late = self._copies.delay * self._copy_rng.random()
            self._world.command(robot_id, twist, t + self._delay + late)

    def _report(self, robot: RobotId, tally: _Tally) -> RobotReport:
        rate = sum(t > self._now - RATE_WINDOW for t in tally.times) / RATE_WINDOW
        counts = LinkCounts(
            tally.sent, tally.replaced, tally.stale, 1, 0, rate, lost=tally.lost,
            doubled=tally.doubled,
        )  # fmt: skip
        return RobotReport(robot, SIMULATED, True, None, counts)
