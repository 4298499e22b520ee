"""Several operators of one run: any may stop it."""

from collections.abc import Sequence

from datasets.cycle import Orders
from pipeline.ports import Operator


class Together:
    """Operators who are asked one after the other."""

    def __init__(self, parts: Sequence[Operator]) -> None:
        """Join them.

        Args:
            parts: the operators; the first that drives the leader does.
        """
        self._parts = parts

    def orders(self, now: float) -> Orders:
        """What any of them wants.

        Args:
            now: the moment of the cycle [s].

        Returns:
            The orders; a stop comes before an arming.
        """
        all_ = [part.orders(now) for part in self._parts]
        halt = any(orders.halt for orders in all_)
        return Orders(
            next((orders.drive for orders in all_ if orders.drive), None),
            halt,
            any(orders.arm for orders in all_) and not halt,
            any(orders.report for orders in all_),
        )

    def close(self) -> None:
        """Let all of them go. Safe to call twice."""
        for part in self._parts:
            part.close()
