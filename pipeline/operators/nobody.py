"""Nobody at the controls."""

from datasets.cycle import NO_ORDERS, Orders


class Nobody:
    """An operator that wants nothing."""

    def orders(self, now: float) -> Orders:  # noqa: ARG002 (the port's)
        """Nothing is wanted.

        Args:
            now: the moment of the cycle [s].

        Returns:
            No orders.
        """
        return NO_ORDERS

    def close(self) -> None:
        """Give nothing back. Safe to call twice."""
