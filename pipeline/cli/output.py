"""What a command says: tables for people, or one JSON object for programs."""

import json
import sys
from collections.abc import Iterable, Iterator, Sequence
from math import pi
from typing import Any

from datasets.cycle import SafetyEvent
from datasets.sightings import VisionScore
from datasets.truth import Arrival, Latencies, RunResult
from pipeline.cadence import Cadence
from pipeline.finding import Finding
from pipeline.links import LinkRow, link_advice


class Output:
    """The one place that writes to stdout; everything else goes to stderr."""

    def __init__(self, as_json: bool) -> None:
        """Choose the form.

        Args:
            as_json: one JSON object instead of tables.
        """
        self.as_json = as_json

    def say(self, text: str) -> None:
        """Tell a person something on the way; with JSON it goes to stderr.

        Args:
            text: one line.
        """
        print(text, file=sys.stderr if self.as_json else sys.stdout)

    def object(self, value: dict[str, Any]) -> None:
        """Print one JSON object.

        Args:
            value: JSON-able.
        """
        print(json.dumps(value, allow_nan=False))  # noqa: T201

    def result(self, result: RunResult, extra: dict[str, Any] | None = None) -> None:
        """Print the result of a run.

        Args:
            result: scores and times.
            extra: further keys of the JSON object.
        """
        if self.as_json:
            self.object(result.to_json() | (extra or {}))
        else:
            for title, header, rows in _run_tables(result):
                self.table(title, header, rows)

    def cadence(self, cadence: Cadence) -> None:
        """Print how a run kept its time; with JSON, which has the figures, only what is wrong.

        Args:
            cadence: after the run.
        """
        if not self.as_json:
            rows = [
                (name, *(f"{value:.2f}" for value in values)) for name, *values in cadence.rows()
            ]
            self.table("Cadence", ("what", "median ms", "99 % ms", "most ms"), rows)
        for line in cadence.advice():
            self.say(line)

    def links(self, links: Sequence[LinkRow]) -> None:
        """Print how the links of a run did; with JSON, as `cadence`.

        Args:
            links: those that have something to tell.
        """
        if links and not self.as_json:
            self.table("Links", LINKS, map(_link, links))
        for line in link_advice(links):
            self.say(line)

    def findings(self, scenario: str, findings: Sequence[Finding]) -> None:
        """Print what was checked.

        Args:
            scenario: its name.
            findings: in reading order.
        """
        if self.as_json:
            rows = [
                {"topic": f.topic, "holds": f.holds, "binding": f.binding, "detail": f.detail}
                for f in findings
            ]
            self.object({"scenario": scenario, "findings": rows})
            return
        for finding in findings:
            mark = "ok" if finding.holds else "FAILS" if finding.binding else "open"
            self.say(f"{mark:6} {finding.topic}: {finding.detail}")

    def diagnosis(self, findings: Sequence[Finding]) -> None:
        """Print what was found about the machine.

        Args:
            findings: in reading order.
        """
        if self.as_json:
            rows = [
                {
                    "topic": f.topic,
                    "found": f.detail,
                    "verdict": f.verdict,
                    "remedy": f.remedy or None,
                }
                for f in findings
            ]
            self.object({"findings": rows})
            return
        for finding in findings:
            self.say(f"{finding.verdict:8} {finding.topic}: {finding.detail}")
            if finding.remedy:
                self.say(f"{'':8} -> {finding.remedy}")

    def table(self, title: str, header: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
        """Print a table with aligned columns.

        Args:
            title: above it.
            header: names of the columns, with units.
            rows: cells as text.
        """
        lines = [tuple(header), *map(tuple, rows)]
        widths = [max(len(line[i]) for line in lines) for i in range(len(header))]
        print(f"\n{title}")  # noqa: T201
        for line in lines:
            cells = (cell.rjust(width) for cell, width in zip(line, widths, strict=True))
            print("  " + "  ".join(cells))  # noqa: T201


Rows = Sequence[Sequence[str]]
Tables = Iterator[tuple[str, Sequence[str], Rows]]


def _run_tables(result: RunResult) -> Tables:
    """The result of a run as tables for people."""
    whose = "true" if result.truth else "estimated"
    title = (
        f"{result.scenario}: {result.duration_s:.2f} s in {result.wall_s:.2f} s, "
        f"{result.frames} frames, {result.commands_sent} commands"
    )
    yield f"{title}\nFollowers ({whose} errors, last 20 % of the run)", *_followers(result)
    if result.vision is not None:
        yield "Vision against the truth", *_vision(result.vision)
    if result.latency_ms is not None:
        yield "Latency", *_latencies(result.latency_ms, result.arrival)
    yield "Run", ("what", "value"), _run(result)


def _followers(result: RunResult) -> tuple[Sequence[str], Rows]:
    header = (
        "robot", "follows", "distance rms mm", "max mm", "bearing rms deg", "max deg",
        "settled at s", "v max m/s", "omega max rad/s",
    )  # fmt: skip
    rows = [
        (
            str(f.follower), ", ".join(map(str, f.leaders)), _number(f.distance_rms_m, 1e3),
            _number(f.distance_max_m, 1e3), _number(f.bearing_rms_rad, 180 / pi),
            _number(f.bearing_max_rad, 180 / pi), _number(f.settled_at_s), _number(f.v_max_mps),
            _number(f.omega_max_radps),
        )
        for f in result.followers
    ]  # fmt: skip
    return header, rows


def _vision(vision: VisionScore) -> tuple[Sequence[str], Rows]:
    header = ("recall %", "false ids", "position rms mm", "heading rms deg")
    row = (
        _number(vision.recall, 100.0), str(vision.false_ids),
        _number(vision.position_rms_m, 1e3), _number(vision.heading_rms_rad, 180 / pi),
    )  # fmt: skip
    return header, [row]


def _latencies(times: Latencies, arrival: Arrival | None) -> tuple[Sequence[str], Rows]:
    """Capture to arrival where it is known, then computing times."""
    rows = [("capture to arrival", arrival.p50, arrival.p99)] if arrival else []
    rows += [
        ("vision", times.vision_p50, times.vision_p99),
        ("whole step", times.step_p50, times.step_p99),
        ("frame to command", times.frame_to_command_p50, times.frame_to_command_p99),
    ]
    return ("stage", "median ms", "99 % ms"), [(n, f"{a:.2f}", f"{b:.2f}") for n, a, b in rows]


def _run(result: RunResult) -> Rows:
    leader = result.leader.position_rms_m if result.leader else None
    rows = [
        ("leader off its plan, rms mm", _number(leader, 1e3)),
        ("least clearance between bodies mm", _number(result.min_clearance_m, 1e3)),
        ("safety events", str(len(result.safety_events))),
    ]
    rows += [(f"frames that show robot {s.robot_id}", str(s.frames)) for s in result.seen]
    rows += [(f"  {e.t:.2f} s {e.kind}", _event(e)) for e in result.safety_events[:20]]
    return rows + [("note", note) for note in result.notes]


LINKS = (
    "robot", "on", "asked 1/s", "carried 1/s", "overtaken", "stale", "lost", "twice", "failures",
    "round trip ms", "most ms", "unanswered %",
)  # fmt: skip


def _link(row: LinkRow) -> Sequence[str]:
    counts = (row.overtaken, row.stale, row.lost, row.doubled, row.failures)
    trip = (row.round_trip_p50_s, row.round_trip_max_s)
    return (
        str(row.robot_id), row.place, _number(row.asked_per_s), _number(row.carried_per_s),
        *map(str, counts), *(_number(value, 1e3) for value in trip), _number(row.unanswered, 100.0),
    )  # fmt: skip


def _event(event: SafetyEvent) -> str:
    who = "all" if event.robot_id is None else f"robot {event.robot_id}"
    return f"{who}: {event.detail}"


def _number(value: float | None, factor: float = 1.0) -> str:
    """A number with two decimals, or a dash where nobody knows."""
    return "-" if value is None else f"{factor * value:.2f}"
