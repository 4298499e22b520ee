"""What changes the state of a run, told as it happens."""

from collections.abc import Callable

from datasets.cycle import Cycle, Moment

STANDING = ("holding", "stopped", "given-up")
"""States that are told when they are entered or left."""


class Transitions:
    """An observer that tells why a run stands, and when it goes on."""

    def __init__(self, say: Callable[[str], None], waits: bool) -> None:
        """Begin before the first cycle.

        Args:
            say: takes one line.
            waits: whether a run that is armed waits for a person.
        """
        self._say, self._told = say, (*STANDING, *(("armed",) if waits else ()))
        self._phase = "idle"

    def observe(self, moment: Moment) -> None:
        """Tell a change.

        Args:
            moment: the cycle.
        """
        before, cycle = self._phase, moment.cycle
        self._phase = cycle.phase
        if before != cycle.phase and (before in self._told or cycle.phase in self._told):
            self._say(f"{cycle.t:.2f} s: {before} -> {cycle.phase}{_reason(cycle)}")

    def close(self) -> None:
        """Release nothing. Safe to call twice."""


def _reason(cycle: Cycle) -> str:
    """What the safety rules said in this cycle, of most concern first."""
    events = sorted(cycle.events, key=lambda event: event.robot_id is not None)
    reasons = (
        event.detail if event.robot_id is None else f"robot {event.robot_id}: {event.detail}"
        for event in events
        if event.kind != "kept-apart"
    )
    reason = next(reasons, "")
    return f" ({reason})" if reason else ""
