"""When a camera was away and why: kept for reports, told to the user once each."""

from collections import deque
from dataclasses import dataclass, replace

KEPT = 100  # of the latest outages


@dataclass(frozen=True, slots=True)
class Outage:
    """A time without the camera.

    Attributes:
        t_lost: when it was found to be lost [s].
        reason: one line.
        t_back: when its first picture came again [s], None if it is still away.
    """

    t_lost: float
    reason: str
    t_back: float | None = None


class Outages:
    """The outages of one camera; who shares them between threads holds a lock."""

    def __init__(self, camera_id: str) -> None:
        """Begin with the camera there.

        Args:
            camera_id: its name, for messages.
        """
        self._camera_id = camera_id
        self._past: deque[Outage] = deque(maxlen=KEPT)
        self._told = ""

    @property
    def all(self) -> tuple[Outage, ...]:
        """The latest outages, the present one last."""
        return tuple(self._past)

    @property
    def away(self) -> bool:
        """Whether the camera is lost at present."""
        return bool(self._past) and self._past[-1].t_back is None

    def lose(self, reason: str, now: float) -> str | None:
        """The camera is lost, or could not be opened again.

        Args:
            reason: one line that names the camera.
            now: the moment [s].

        Returns:
            A line for the user; None if it would be the one before.
        """
        if not self.away:
            self._past.append(Outage(now, reason))
        if reason == self._told:
            return None
        self._told = reason
        return f"{reason}; it is opened again"

    def end(self, now: float) -> str:
        """A good picture has come again.

        Args:
            now: its arrival [s].

        Returns:
            A line for the user.
        """
        outage = self._past.pop()
        self._past.append(replace(outage, t_back=now))
        self._told = ""
        return f"camera {self._camera_id}: back after {now - outage.t_lost:.1f} s"
