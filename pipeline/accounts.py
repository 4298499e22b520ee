"""What was dropped, held back or lost in a run: everything is counted, and told at the end."""

from collections.abc import Iterator
from typing import Protocol, runtime_checkable

from pipeline.cameras.report import Reporting, told
from pipeline.live import Rig
from pipeline.radios.miabot import MiabotRadio, MiabotReport
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


def account(rig: Rig) -> tuple[str, ...]:
    """Say what the parts of a rig have dropped or held back, and how its links did.

    Args:
        rig: after the run.

    Returns:
        One line per part that has something to say; nothing was lost where there is none.
    """
    return tuple(_lines(rig))


def _lines(rig: Rig) -> Iterator[str]:
    if isinstance(rig.source, Reporting):
        yield from told(rig.source.report)
    for sink in rig.sink.parts if isinstance(rig.sink, Tee) else (rig.sink,):
        if isinstance(sink, Screened) and (sink.screen.stale or sink.screen.refused):
            held = sink.screen
            yield f"radio: {held.stale} stale and {held.refused} non-finite commands were not sent"
        if isinstance(sink, MiabotRadio):
            if sink.unknown:
                yield f"radio: {sink.unknown} commands were for robots without a port"
            yield from map(_link, sink.reports)
    for observer in rig.observers:
        if isinstance(observer, Dropping) and observer.dropped:
            what = type(observer).__name__
            yield f"{what}: {observer.dropped} cycles were dropped because it was behind"


def _link(report: MiabotReport) -> str:
    """One line about a link to a robot."""
    c = report.counts
    return (
        f"robot {report.robot_id} on {report.port}: {c.sent} messages sent, {c.replaced} overtaken "
        f"by newer ones, {c.stale} stale, {c.failures} failures, {report.garbage} bytes of garbage"
    )
