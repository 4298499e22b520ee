"""How many bytes a link carries, and when the next message may go."""

from math import inf

_SLACK = 1e-9  # shorter waits are rounding [s]


class Budget:
    """Spaces messages so that they never exceed the link's rate: no burst, no queue behind them."""

    def __init__(self, bytes_per_second: float) -> None:
        """Start idle.

        Args:
            bytes_per_second: what the link carries, > 0, may be infinite [B/s].
        """
        self._rate = bytes_per_second
        self._free_at = -inf

    def wait(self, now: float) -> float:
        """Say how long the next message has to wait.

        Args:
            now: present time [s].

        Returns:
            Time until the link is free, 0 if it is [s].
        """
        wait = self._free_at - now
        return wait if wait > _SLACK else 0.0

    def spend(self, size: int, now: float) -> None:
        """Book a message that is being sent.

        Args:
            size: its length [B].
            now: present time [s].
        """
        self._free_at = max(now, self._free_at) + self.min_period(size)

    def min_period(self, size: int) -> float:
        """Say how often a message fits.

        Args:
            size: its length [B].

        Returns:
            The shortest period the link sustains [s].
        """
        return size / self._rate
