"""Orders by signals, for buttons and scripts: SIGUSR1 stops everything, SIGUSR2 arms again."""

import signal
from types import FrameType
from typing import Any

from datasets.cycle import Orders

HALT, ARM = "SIGUSR1", "SIGUSR2"


class Signals:
    """An operator who sends signals to this process; a system without them has none."""

    def __init__(self) -> None:
        """Take the two signals over."""
        self._came: list[str] = []
        self._before: dict[str, Any] = {
            name: signal.signal(getattr(signal, name), self._note)
            for name in (HALT, ARM)
            if hasattr(signal, name)
        }

    def orders(self, now: float) -> Orders:  # noqa: ARG002 (the port's)
        """What has come since the last time.

        Args:
            now: the moment of the cycle [s].

        Returns:
            The orders; a stop comes before an arming.
        """
        if not self._came:
            return Orders()
        came, self._came = self._came, []
        return Orders(halt=HALT in came, arm=ARM in came and HALT not in came)

    def close(self) -> None:
        """Give the signals back. Safe to call twice."""
        before, self._before = self._before, {}
        for name, handler in before.items():
            signal.signal(getattr(signal, name), handler)

    def _note(self, number: int, frame: FrameType | None) -> None:
        del frame
        self._came.append(signal.Signals(number).name)
