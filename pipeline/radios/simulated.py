"""The link to simulated robots: delay, loss and a limited bandwidth, all repeatable."""

from math import inf

import numpy as np

from control.command import Command, RobotId
from control.unicycle import Twist
from datasets.world import World
from pipeline.radios.budget import Budget
from pipeline.radios.newest import STOP_SPACING, STOPS
from pipeline.radios.screen import Screen

MESSAGE_SIZE = 12  # of a typical wheel command, "[=-500,-500]" [B]


class SimulatedRadio:
    """Hands commands to a world.

    Attributes:
        min_period: how often a command fits into the bandwidth [s].
        screen: counts what was held back.
        sent: messages that went on air, with those that were lost.
        lost: messages that never arrived.
        replaced: messages overtaken by a newer one while the link was busy.
    """

    def __init__(
        self,
        world: World,
        delay: float = 0.005,
        loss: float = 0.0,
        bandwidth_Bps: float | None = None,
        seed: int = 0,
    ) -> None:
        """Connect to the robots of a world.

        Args:
            world: its robots obey.
            delay: from sending to the wheels [s].
            loss: probability that a message never arrives, in [0, 1].
            bandwidth_Bps: what the link to each robot carries [B/s]; None: without limit.
            seed: of the losses.
        """
        self._world, self._delay, self._loss = world, delay, loss
        self._rng = np.random.default_rng(seed)
        rate = inf if bandwidth_Bps is None else bandwidth_Bps
        self._budgets = {plant.robot_id: Budget(rate) for plant in world.plants}
        self._waiting: dict[RobotId, Command] = {}
        self.min_period = MESSAGE_SIZE / rate
        self.screen, self.sent, self.lost, self.replaced = Screen(), 0, 0, 0

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
        for command in self.screen.passed(commands, now):
            self.replaced += command.robot_id in self._waiting
            self._waiting[command.robot_id] = command
        for command in tuple(self._waiting.values()):
            if self._free(command.robot_id, now):
                del self._waiting[command.robot_id]
                for fresh in self.screen.passed((command,), now):
                    self._transmit(fresh.robot_id, fresh.twist, now)
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

    def _transmit(self, robot_id: RobotId, twist: Twist, t: float) -> None:
        self.sent += 1
        if robot_id in self._budgets:
            self._budgets[robot_id].spend(MESSAGE_SIZE, t)
        if self._rng.random() < self._loss:
            self.lost += 1
            return
        self._world.command(robot_id, twist, t + self._delay)
