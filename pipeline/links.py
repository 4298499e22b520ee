"""How the radio links of a run did: what was asked of each, what it carried, what helps."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from control.command import RobotId
from pipeline.radios.report import SIMULATED, RobotReport

ENOUGH = 0.9  # share of the commands that a link should carry
SILENT = 0.05  # share of questions without an answer from which a robot is hard to reach


@dataclass(frozen=True, slots=True)
class LinkRow:
    """One robot's link in a run.

    Attributes:
        robot_id: the robot.
        place: its port or address.
        asked_per_s: commands asked of it while the robots were driven, None if none was [1/s].
        carried_per_s: commands it carried meanwhile, None as before [1/s].
        overtaken: commands that a newer one replaced before the link was free.
        stale: commands that were too old when their turn came.
        lost: messages known to have been lost on the way.
        doubled: messages known to have arrived twice.
        failures: times it went down or could not be opened.
        silences: times robots were stopped because no command had come.
        garbage: bytes received that were no known reply.
        foreign: replies that name another robot.
        round_trip_p50_s: median; None where robots do not answer [s].
        round_trip_max_s: longest; None as before [s].
        unanswered: share of the questions; None as before.
    """

    robot_id: RobotId
    place: str
    asked_per_s: float | None
    carried_per_s: float | None
    overtaken: int
    stale: int
    lost: int
    doubled: int
    failures: int
    silences: int
    garbage: int
    foreign: int
    round_trip_p50_s: float | None
    round_trip_max_s: float | None
    unanswered: float | None

    def to_json(self) -> dict[str, Any]:
        """The row for other programs.

        Returns:
            A JSON-able object.
        """
        return asdict(self)


def link_rows(
    reports: Sequence[RobotReport], asked: Mapping[RobotId, int], seconds: float
) -> tuple[LinkRow, ...]:
    """Say how links did.

    Args:
        reports: of all links.
        asked: commands for each robot.
        seconds: over which they came [s].

    Returns:
        A row per robot and link; none for simulated ones that lost and held back nothing.
    """
    return tuple(_row(r, asked.get(r.robot_id, 0), seconds) for r in reports if _tells(r))


def link_advice(rows: Sequence[LinkRow]) -> Iterator[str]:
    """Say what is not as it should be, and what helps.

    Args:
        rows: of a run.

    Yields:
        One line each; nothing where all is well.
    """
    for row in rows:
        yield from (f"robot {row.robot_id} on {row.place}: {text}" for text in _advice(row))


def _tells(report: RobotReport) -> bool:
    c = report.counts
    return bool(report.place != SIMULATED or c.replaced or c.stale or c.lost or c.doubled)


def _row(report: RobotReport, asked: int, seconds: float) -> LinkRow:
    c, trip = report.counts, report.round_trip
    known = bool(asked) and seconds > 0.0
    return LinkRow(
        report.robot_id,
        report.place,
        asked / seconds if known else None,
        c.sent / seconds if known else None,
        c.replaced,
        c.stale,
        c.lost,
        c.doubled,
        c.failures,
        c.silences,
        report.garbage,
        report.foreign,
        trip.p50 if trip else None,
        trip.longest if trip else None,
        trip.loss if trip else None,
    )


def _advice(row: LinkRow) -> Iterator[str]:
    asked, carried = row.asked_per_s, row.carried_per_s
    if asked is not None and carried is not None and carried < ENOUGH * asked:
        yield (
            f"{carried:.0f} of {asked:.0f} commands/s are carried: a longer --command-period; or "
            "radio.link_bytes_per_s, if the link is faster than that"
        )
    if row.failures:
        yield f"the link failed {row.failures} times: battery, distance, plug"
    if row.unanswered is not None and row.unanswered > SILENT:
        yield f"{100.0 * row.unanswered:.0f} % of its questions got no answer: battery, distance"
    if row.foreign:
        yield f"{row.foreign} replies name another robot: two robots share a link or a number"
    if row.garbage:
        yield f"{row.garbage} bytes of garbage came: another device's port, or a disturbed link"
    if row.lost or row.doubled:
        yield f"{row.lost} messages were lost, {row.doubled} arrived twice"
    if row.silences:
        yield f"the robots were stopped {row.silences} times because no command came"
