"""What was dropped, held back or lost in a run: everything is counted, and told at the end."""

from collections.abc import Iterator
from typing import Protocol, runtime_checkable

from pipeline.cameras.report import Reporting, told
from pipeline.live import Rig
from pipeline.ports import CommandSink
from pipeline.radios.report import SIMULATED, RobotReport
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
    """Say what the parts of a rig have dropped or held back, and how its links did.

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
    yield from _links(link_reports(rig.sink))
    for observer in rig.observers:
        if isinstance(observer, Dropping) and observer.dropped:
            what = type(observer).__name__
            yield f"{what}: {observer.dropped} cycles were dropped because it was behind"
        if isinstance(observer, Noting):
            yield from observer.notes


def _links(reports: tuple[RobotReport, ...]) -> Iterator[str]:
    """A line per link; none for simulated ones that lost and held back nothing."""
    for report in reports:
        c = report.counts
        if report.place != SIMULATED or c.replaced or c.stale or c.lost or c.doubled:
            yield f"robot {report.robot_id} on {report.place}: " + ", ".join(_parts(report))


def _parts(report: RobotReport) -> Iterator[str]:
    c, trip = report.counts, report.round_trip
    yield f"{c.sent} messages sent, {c.replaced} overtaken by newer ones, {c.stale} stale"
    yield f"{c.failures} failures"
    yield f"{report.garbage} bytes of garbage"
    told = (
        (c.lost, "lost"),
        (c.doubled, "arrived twice"),
        (c.silences, "stops because no command came"),
        (report.foreign, "replies of another robot"),
    )
    yield from (f"{count} {what}" for count, what in told if count)
    if trip is not None and trip.p50 is not None and trip.longest is not None:
        yield f"round trip {1e3 * trip.p50:.1f} ms (p50), {1e3 * trip.longest:.1f} ms (max)"
    if trip is not None and trip.loss is not None:
        yield f"{100.0 * trip.loss:.1f} % of {trip.asked} questions unanswered"
