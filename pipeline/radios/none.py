"""No radio: commands are computed and shown, and reach nobody."""

from control.command import Command, RobotId
from pipeline.radios.screen import Screen


class NoRadio:
    """A command sink without robots.

    Attributes:
        screen: counts what no radio would have sent.
        shown: commands that a radio would have sent.
        min_period: 0: any rate is carried [s].
    """

    def __init__(self) -> None:
        """Start counting."""
        self.screen, self.shown, self.min_period = Screen(), 0, 0.0

    def send(self, commands: tuple[Command, ...], now: float) -> tuple[RobotId, ...]:
        """Count the commands.

        Args:
            commands: at most one per robot.
            now: the moment of the cycle [s].

        Returns:
            Nobody: there is no link to lose.
        """
        self.shown += len(self.screen.passed(commands, now))
        return ()

    def stop(self, now: float) -> None:
        """Stop nobody.

        Args:
            now: the moment of the call [s].
        """

    def close(self) -> None:
        """Release nothing."""
