"""Orders by signals, for buttons and scripts: SIGUSR1 stops everything, SIGUSR2 arms again."""

from datasets.cycle import Orders
from pipeline.interruption import ARM, HALT


class Signals:
    """An operator who sends signals to this process."""

    def __init__(self, came: list[str]) -> None:
        """Listen.

        Args:
            came: names of the signals, noted from the program's first moment: a stop that is sent
                before there is a run is an order of its first cycle. See `interruption.noted`.
        """
        self._came = came

    def orders(self, now: float) -> Orders:  # noqa: ARG002 (the port's)
        """What has come since the last time.

        Args:
            now: the moment of the cycle [s].

        Returns:
            The orders; a stop comes before an arming.
        """
        if not self._came:
            return Orders()
        came = self._came[:]
        del self._came[: len(came)]  # one may come between these two lines
        return Orders(halt=HALT in came, arm=ARM in came and HALT not in came)

    def close(self) -> None:
        """Give nothing back. Safe to call twice."""
