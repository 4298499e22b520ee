"""One thing that was checked before anything moves: of a scenario, or of the machine."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that was checked.

    Attributes:
        topic: short name.
        holds: whether it is as it should be.
        detail: the numbers, and the remedy where it does not hold and none is given apart.
        binding: whether a check fails without it; else it is told as not guaranteed.
        remedy: what to do, empty where nothing is to be done.
    """

    topic: str
    holds: bool
    detail: str
    binding: bool = True
    remedy: str = ""

    @property
    def verdict(self) -> str:
        """In one word: fine, warning or bad."""
        return "fine" if self.holds else "bad" if self.binding else "warning"
