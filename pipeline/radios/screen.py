"""The last look at commands before a radio: nothing stale or non-finite passes, all is counted."""

from dataclasses import dataclass
from math import isfinite

from control.command import Command


@dataclass(slots=True)
class Screen:
    """Counts what it holds back.

    Attributes:
        stale: commands older than their valid_until.
        refused: commands that were not finite.
    """

    stale: int = 0
    refused: int = 0

    def passed(self, commands: tuple[Command, ...], now: float) -> tuple[Command, ...]:
        """Let through what may be sent.

        Args:
            commands: at most one per robot.
            now: the moment of the cycle [s].

        Returns:
            The finite ones that are still valid, in their order.
        """
        return tuple(command for command in commands if self._passes(command, now))

    def _passes(self, command: Command, now: float) -> bool:
        if not (isfinite(command.twist.v) and isfinite(command.twist.omega)):
            self.refused += 1
            return False
        fresh = command.valid_until >= now  # false for NaN too
        self.stale += not fresh
        return fresh
