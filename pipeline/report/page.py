"""The page of a report: one HTML file that needs nothing beside it."""

import json
from base64 import b64encode
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape
from math import degrees

import numpy as np

from datasets.recorded import SessionEnd, SessionHeader
from datasets.sightings import VisionScore
from datasets.truth import Latencies, RunResult
from pipeline.report.series import Series
from pipeline.viewers.stage import name_of

_LOOK = """
:root { color-scheme: light; --ink: #20242a; --soft: #5a6068; --line: #dfe3e8; }
body { font: 16px/1.5 system-ui, sans-serif; color: var(--ink); max-width: 60rem;
  margin: 2.5rem auto; padding: 0 1.2rem; background: #fff; }
h1 { font-size: 1.7rem; margin: 0; } h2 { font-size: 1.15rem; margin: 2.2rem 0 .4rem; }
p.lead, figcaption, .soft { color: var(--soft); } p.lead { margin: .2rem 0 1.4rem; }
figure { margin: 1.6rem 0; } img { width: 100%; height: auto; display: block; }
figcaption { font-size: .9rem; max-width: 46rem; } figcaption b { color: var(--ink); }
.wide { overflow-x: auto; } table { border-collapse: collapse; font-size: .92rem; }
th, td { padding: .3rem .9rem .3rem 0; text-align: right; border-bottom: 1px solid var(--line);
  font-variant-numeric: tabular-nums; } th:first-child, td:first-child { text-align: left; }
th { font-weight: 600; color: var(--soft); } pre { font-size: .78rem; overflow-x: auto;
  background: #f6f7f9; padding: 1rem; border-radius: 6px; } .warn { color: #a33b00; }
"""

Cell = str | float | int | None
Row = tuple[Cell, ...]


@dataclass(frozen=True, slots=True)
class Chapter:
    """A figure with what it shows.

    Attributes:
        stem: of its file's name.
        title: short.
        caption: one or two sentences.
        png: the picture.
    """

    stem: str
    title: str
    caption: str
    png: bytes


@dataclass(frozen=True, slots=True)
class Summary:
    """What the page says in numbers.

    Attributes:
        header: of the session.
        end: how the session ends.
        result: of the run.
        series: of the run.
    """

    header: SessionHeader
    end: SessionEnd
    result: RunResult
    series: Series


def page(summary: Summary, chapters: Sequence[Chapter]) -> str:
    """Write the page.

    Args:
        summary: the numbers.
        chapters: the figures.

    Returns:
        HTML with all pictures inside.
    """
    parts = [
        _lead(summary),
        _section("Followers", _followers(summary)),
        *map(_figure, chapters),
        _section("The run in numbers", _numbers(summary)),
        _section("Safety events", _events(summary)),
        _section("Phases", _table(("from  [s]", "phase"), _phases(summary.series))),
        _section("Software", _table(("", "version"), summary.header.versions)),
        _settings(summary.header),
    ]
    title = escape(f"Echelon: {summary.header.name}")
    head = f'<meta charset="utf-8"><title>{title}</title><style>{_LOOK}</style>'
    size = '<meta name="viewport" content="width=device-width, initial-scale=1">'
    body = "\n".join(parts)
    return (
        f'<!doctype html>\n<html lang="en"><head>{head}{size}</head>\n<body>{body}</body></html>\n'
    )


def _lead(summary: Summary) -> str:
    result, end = summary.result, summary.end
    known = "true states known" if result.truth else "no truth: errors are of the estimates"
    seed = "" if summary.header.seed is None else f"seed {summary.header.seed}, "
    text = f"{result.duration_s:.2f} s, {result.frames} frames, {seed}{known}"
    warnings = []
    if not end.complete:
        warnings.append("The recording was cut off before its end; all that was kept is shown.")
    if end.dropped:
        warnings.append(f"{end.dropped} cycles are missing: the recorder could not keep up.")
    said = "".join(f'<p class="warn">{escape(warning)}</p>' for warning in warnings)
    name = escape(summary.header.name)
    return f'<h1>Session "{name}"</h1><p class="lead">{escape(text)}</p>{said}'


def _followers(summary: Summary) -> str:
    head = (
        "robot", "follows", "distance rms  [mm]", "max  [mm]", "bearing rms  [deg]", "max  [deg]",
        "in place at  [s]", "fastest  [m/s]", "fastest turn  [rad/s]",
    )  # fmt: skip
    rows = [
        (
            name_of(f.follower),
            ", ".join(map(name_of, f.leaders)),
            _times(f.distance_rms_m, 1e3),
            _times(f.distance_max_m, 1e3),
            _times(f.bearing_rms_rad, degrees(1.0)),
            _times(f.bearing_max_rad, degrees(1.0)),
            f.settled_at_s,
            f.v_max_mps,
            f.omega_max_radps,
        )
        for f in summary.result.followers
    ]
    note = "Errors over the last fifth of the run; in place: within 2 cm and 0.1 rad from then on."
    return _table(head, rows) + f'<p class="soft">{note}</p>'


def _numbers(summary: Summary) -> str:
    result, series = summary.result, summary.series
    leader = result.leader
    rejected = int(series.frames[:, 2].sum())
    found = float(series.frames[:, 1].mean()) if len(series.frames) else None
    rows: list[Row] = [
        ("leader off its plan, rms", _times(leader.position_rms_m if leader else None, 1e3), "mm"),
        ("least distance between two bodies", _times(result.min_clearance_m, 1e3), "mm"),
        ("robots found in a frame, mean", found, ""),
        ("candidates rejected", rejected, ""),
        ("commands sent", result.commands_sent, ""),
        ("cycles the recorder dropped", summary.end.dropped, ""),
    ]
    rows += _vision_rows(result.vision) if result.vision else []
    rows += _latency_rows(result.latency_ms) if result.latency_ms else []
    notes = "".join(f"<p>{escape(note)}</p>" for note in series.notes)
    return _table(("", "value", "unit"), rows) + notes


def _vision_rows(vision: VisionScore) -> list[Row]:
    return [
        ("recall of robots in view", _times(vision.recall, 100.0), "%"),
        ("false identities", vision.false_ids, ""),
        ("position error of detections, rms", _times(vision.position_rms_m, 1e3), "mm"),
        ("heading error of detections, rms", _times(vision.heading_rms_rad, degrees(1.0)), "deg"),
    ]


def _latency_rows(latency: Latencies) -> list[Row]:
    """Median and 99th percentile."""
    pairs = (
        ("vision", latency.vision_p50, latency.vision_p99),
        ("cycle with a frame", latency.step_p50, latency.step_p99),
        ("frame to command", latency.frame_to_command_p50, latency.frame_to_command_p99),
    )
    return [
        (f"{what}, median / 99 %", f"{mid:.2f} / {high:.2f}", "ms") for what, mid, high in pairs
    ]


def _events(summary: Summary) -> str:
    events = summary.series.events
    if not events:
        return "<p>None.</p>"
    rows = [
        (round(e.t, 3), e.kind, "all" if e.robot_id is None else name_of(e.robot_id), e.detail)
        for e in events
    ]
    return _table(("capture clock  [s]", "kind", "robot", "what"), rows)


def _phases(series: Series) -> list[Row]:
    return [(round(t, 3), phase) for t, phase in series.phases]


def _settings(header: SessionHeader) -> str:
    """The scenario in full, folded away."""
    try:
        text = json.dumps(json.loads(header.scenario), indent=1)
    except ValueError:
        text = header.scenario
    folded = f"<details><summary>the full scenario</summary><pre>{escape(text)}</pre></details>"
    return _section("Settings", folded)


def _figure(chapter: Chapter) -> str:
    data = b64encode(chapter.png).decode()
    image = f'<img alt="{escape(chapter.title)}" src="data:image/png;base64,{data}">'
    caption = f"<b>{escape(chapter.title)}.</b> {escape(chapter.caption)}"
    return f"<figure>{image}<figcaption>{caption}</figcaption></figure>"


def _section(title: str, content: str) -> str:
    return f"<h2>{escape(title)}</h2>{content}"


def _table(head: Sequence[str], rows: Iterable[Sequence[Cell]]) -> str:
    top = "".join(f"<th>{escape(text)}</th>" for text in head)
    lines = ("".join(f"<td>{_cell(cell)}</td>" for cell in row) for row in rows)
    body = "".join(f"<tr>{line}</tr>" for line in lines)
    return f'<div class="wide"><table><tr>{top}</tr>{body}</table></div>'


def _cell(value: Cell) -> str:
    if value is None or (isinstance(value, float) and not np.isfinite(value)):
        return "–"
    return f"{value:.3g}" if isinstance(value, float) else escape(str(value))


def _times(value: float | None, scale: float) -> float | None:
    return None if value is None else scale * value
