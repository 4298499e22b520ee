"""One thing that was checked before anything moves."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that was checked.

    Attributes:
        topic: short name.
        holds: whether it is as it should be.
        detail: the numbers, and the remedy where it does not hold.
        binding: whether a check fails without it; else it is told as not guaranteed.
    """

    topic: str
    holds: bool
    detail: str
    binding: bool = True
