"""What is switched off at the end of a `with` statement, whatever happened in it."""

from types import TracebackType
from typing import Self


class Closed:
    """Base of robots' other ends: `close` is called at the end of a `with` statement."""

    def close(self) -> None:
        """Switch it off. Safe to call twice."""
        raise NotImplementedError

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()
