"""Measure, write docs/limits.md and build/limits.csv; some minutes, always the same numbers."""

import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from time import perf_counter
from typing import TypeVar

from benchmarks.limits import effects, grid
from benchmarks.limits.page import page, table

PAGE, TABLE = Path("docs/limits.md"), Path("build/limits.csv")
Item = TypeVar("Item")


def main() -> None:
    """Measure and write."""
    start = perf_counter()
    cells = list(_told("noise x blur x size", grid.cells(), grid.count()))
    rows = list(_told("effects", effects.rows(), effects.count()))
    TABLE.parent.mkdir(exist_ok=True)
    TABLE.write_text(table(cells, rows))
    PAGE.write_text(page(cells, rows))
    print(f"{PAGE}, {TABLE}: {perf_counter() - start:.0f} s")


def _told(what: str, items: Iterable[Item], count: int) -> Iterator[Item]:
    """Pass on and tell how far it is."""
    for number, item in enumerate(items, 1):
        end = "\n" if number == count or not sys.stderr.isatty() else "\r"
        if end == "\r" or number % 10 == 0 or number == count:
            print(f"{what}: {number} of {count}", end=end, file=sys.stderr, flush=True)
        yield item


main()
