"""What was dropped or held back in a run: everything is counted, and told at the end."""

from collections.abc import Iterator
from typing import Protocol, runtime_checkable

from pipeline.cameras.report import Reporting, told
from pipeline.live import Rig
from pipeline.ports import CommandSink
from pipeline.radios.report import RobotReport
from pipeline.radios.screen import Screen
from pipeline.rigs import Tee


@runtime_checkable
class Dropping(Protocol):
    """A recorder or viewer that counts what it passed over."""

    @property
    def dropped(self) -> int:
        """How much it was so far."""
        ...


@runtime_checkable
class Screened(Protocol):
    """A radio that counts commands it did not send."""

    @property
    def screen(self) -> Screen:
        """The counts."""
        ...


@runtime_checkable
class Linked(Protocol):
    """A radio that says how the link to each robot is doing."""

    @property
    def reports(self) -> tuple[RobotReport, ...]:
        """One per robot."""
        ...


@runtime_checkable
class Noting(Protocol):
    """A radio or an observer that has more to tell."""

    @property
    def notes(self) -> tuple[str, ...]:
        """One line each."""
        ...


def account(rig: Rig) -> tuple[str, ...]:
    """Say what the parts of a rig have dropped or held back; `pipeline.links` tells of links.

    Args:
        rig: after the run.

    Returns:
        One line per part that has something to say; nothing was lost where there is none.
    """
    return tuple(_lines(rig))


def link_reports(sink: CommandSink) -> tuple[RobotReport, ...]:
    """How every link of a radio is doing.

    Args:
        sink: any radio, also two that get the same commands.

    Returns:
        One report per robot and link.
    """
    parts = sink.parts if isinstance(sink, Tee) else (sink,)
    return tuple(report for part in parts if isinstance(part, Linked) for report in part.reports)


def _lines(rig: Rig) -> Iterator[str]:
    if isinstance(rig.source, Reporting):
        yield from told(rig.source.report)
    for sink in rig.sink.parts if isinstance(rig.sink, Tee) else (rig.sink,):
        if isinstance(sink, Screened) and (sink.screen.stale or sink.screen.refused):
            held = sink.screen
            yield f"radio: {held.stale} stale and {held.refused} non-finite commands were not sent"
        if isinstance(sink, Noting):
            yield from sink.notes
    for observer in rig.observers:
        if isinstance(observer, Dropping) and observer.dropped:
            what = type(observer).__name__
            yield f"{what}: {observer.dropped} cycles were dropped because it was behind"
        if isinstance(observer, Noting):
            yield from observer.notes
