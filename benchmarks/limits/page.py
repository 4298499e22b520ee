"""The measured limits as a page and as a table for other programs."""

import csv
from collections.abc import Sequence
from io import StringIO
from math import isnan

from benchmarks.limits.effects import Row
from benchmarks.limits.errors import Errors
from benchmarks.limits.grid import BLURS, FRAMES, NOISES, SIDE, SIZES, Cell

_FIELDS = ("kind", "name", "strength", "robot_px", "read_noise", "blur_px", "mode", "robots",
           "recall", "false_ids", "position_mm", "position_px", "heading_deg", "distance_mm",
           "bearing_deg", "safety_events", "end")  # fmt: skip

_HEAD = f"""# Limits

Written by `make limits` (`python -m benchmarks.limits`); the same numbers on every run of one
version. Rendered frames of the scenario `paper` (320x240, 4:2:0 chroma, light uneven by 30 %),
three robots; a detection counts if it is within half a tag ({500 * SIDE:g} mm) of its robot.
Errors are rms over the right detections.

"""

_GRID = f"""## Noise, blur, size

{FRAMES} frames a cell, robots at random places and headings; read noise of 255, blur and robot in
pixels. Each cell: recall in % / position in mm / in px / heading in deg; "+n" are n false ids.
"""

_EFFECTS = """## Effects

The paper's whole run (8 s, closed loop) for each row. "Searched": every fifth frame, found from
nothing, without what the loop has learned of the light. "Tracked", "position", "heading": what the
loop saw, against the truth at the time on the frame; they hold what wrong stamps, repeated pictures
and rolling shutters do. "Followers": the worst rms of true distance and bearing over the last 20 %
of runs that came to their end. "Events": of the safety rules, which slow and stop robots that are
not seen. "End": "finished", or "time" if the robots still stood 4 s after the planned end.

| effect | strength | searched %, false | tracked %, false | position mm | heading deg | \
followers mm, deg | events | end |
|---|---|---|---|---|---|---|---|---|
"""

_FAILS = """
## What fails

Runs that did not end, that a safety rule slowed down, or in which a robot was taken for another.

"""


def page(cells: Sequence[Cell], rows: Sequence[Row]) -> str:
    """Write the page.

    Args:
        cells: of the grid, in its order.
        rows: of the effects.

    Returns:
        Markdown.
    """
    effects = _EFFECTS + "".join(map(_line, rows))
    return _HEAD + _GRID + _grids(cells) + "\n" + effects + _FAILS + "".join(map(_failure, rows))


def table(cells: Sequence[Cell], rows: Sequence[Row]) -> str:
    """Write the table.

    Args:
        cells: of the grid.
        rows: of the effects.

    Returns:
        CSV with a header; fields that do not apply are empty.
    """
    text = StringIO()
    writer = csv.DictWriter(text, _FIELDS, restval="", lineterminator="\n")
    writer.writeheader()
    for cell in cells:
        where = {"kind": "grid", "robot_px": cell.size_px, "read_noise": cell.noise,
                 "blur_px": cell.blur_px}  # fmt: skip
        for mode, errors in (("searched", cell.searched), ("tracked", cell.tracked)):
            px = errors.position_mm * cell.size_px / (1e3 * SIDE)
            writer.writerow(where | {"mode": mode, "position_px": px} | _plain(errors))
    for row in rows:
        writer.writerow(_effect(row) | {"mode": "searched"} | _plain(row.searched))
        writer.writerow(_effect(row) | {"mode": "tracked"} | _loop(row))
    return text.getvalue()


def _plain(errors: Errors) -> dict[str, object]:
    return {"robots": errors.robots, "recall": errors.recall, "false_ids": errors.false_ids,
            "position_mm": errors.position_mm, "heading_deg": errors.heading_deg}  # fmt: skip


def _effect(row: Row) -> dict[str, object]:
    return {"kind": "effect", "name": row.effect, "strength": row.strength}


def _loop(row: Row) -> dict[str, object]:
    seen = row.seen
    return {"recall": seen.recall, "false_ids": seen.false_ids,
            "position_mm": _times(1e3, seen.position_rms_m),
            "heading_deg": _times(57.29578, seen.heading_rms_rad),
            "distance_mm": row.distance_mm, "bearing_deg": row.bearing_deg,
            "safety_events": row.events, "end": row.end}  # fmt: skip


def _grids(cells: Sequence[Cell]) -> str:
    found = {(c.size_px, c.noise, c.blur_px): c for c in cells}
    text = ""
    for title in ("searched", "tracked"):
        text += f"\n### {title.capitalize()}\n\n| robot px | noise |"
        text += "".join(f" blur {blur:g} |" for blur in BLURS) + "\n|---|---|"
        text += "---|" * len(BLURS) + "\n"
        for size in SIZES:
            for noise in NOISES:
                these = [getattr(found[size, noise, blur], title) for blur in BLURS]
                text += f"| {size} | {noise:g} | " + " | ".join(_cell(e, size) for e in these)
                text += " |\n"
    return text


def _cell(errors: Errors, size_px: int) -> str:
    mm = errors.position_mm
    false = f" +{errors.false_ids}" if errors.false_ids else ""
    if isnan(mm):
        return f"0{false}"
    px = mm * size_px / (1e3 * SIDE)
    return f"{100 * errors.recall:.1f} / {mm:.2f} / {px:.3f} / {errors.heading_deg:.2f}{false}"


def _line(row: Row) -> str:
    seen = row.seen
    recall = 0.0 if seen.recall is None else 100 * seen.recall
    parts = (
        row.effect,
        row.strength,
        f"{100 * row.searched.recall:.1f}, {row.searched.false_ids}",
        f"{recall:.1f}, {seen.false_ids}",
        _number(_times(1e3, seen.position_rms_m), 2),
        _number(_times(57.29578, seen.heading_rms_rad), 2),
        f"{_number(row.distance_mm, 1)}, {_number(row.bearing_deg, 1)}",
        str(row.events),
        row.end,
    )
    return "| " + " | ".join(parts) + " |\n"


def _failure(row: Row) -> str:
    """A line for runs that failed in some way, else nothing."""
    said = [] if row.end == "finished" else ["did not end in time"]
    said += [f"{row.events} safety events"] if row.events else []
    pairs = (("searched", row.searched.false_ids), ("tracked", row.seen.false_ids))
    said += [f"{count} false ids when {how}" for how, count in pairs if count]
    return f"- {row.effect}, {row.strength}: {', '.join(said)}\n" if said else ""


def _times(factor: float, value: float | None) -> float:
    return float("nan") if value is None else factor * value


def _number(value: float, digits: int) -> str:
    return "-" if isnan(value) else f"{value:.{digits}f}"
