"""What a study is. One file a study; `pipeline/studies/all.py` lists them."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol, TypeAlias

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Progress: TypeAlias = Callable[[float], None]
"""Is told the share that is done, 0 to 1, a few times a second; raises to end the study."""

Cell: TypeAlias = str | int | float | None
"""Of a table; None where there is no value."""


@dataclass(frozen=True, slots=True)
class Result:
    """What a study found.

    Attributes:
        header: names of the columns, numbers with their unit: "period_ms".
        rows: as many cells each.
        draw: makes the figure; called under the house style.
    """

    header: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    draw: "Callable[[], Figure]"


class Study(Protocol):
    """A question. Its size (runs, values that are swept) is its fields, made for the figure by
    default and small in tests; studies that differ in a field may share a class."""

    @property
    def name(self) -> str:
        """In the command line and of the files, e.g. "sampled-twisting"."""
        ...

    @property
    def summary(self) -> str:
        """One line for the list of studies."""
        ...

    def run(self, progress: Progress) -> Result:
        """Compute; the same size gives the same result.

        Args:
            progress: to be called now and then.

        Returns:
            Table and figure.
        """
        ...
