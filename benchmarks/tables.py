"""Rows as a table to read and as plain data to keep."""

from collections.abc import Sequence
from dataclasses import asdict, is_dataclass
from itertools import groupby
from math import isfinite
from typing import Any

from benchmarks.loop import LoopTimes
from benchmarks.simulation import LoadTimes, SimulationSpeed
from benchmarks.vision import Row


def print_rows(rows: Sequence[Row]) -> None:
    """Print what was measured at every size.

    Args:
        rows: of the vision.
    """
    for (size, robots), same in groupby(rows, lambda row: (row.size, row.robots)):
        print(f"{size}, {robots} robots")
        print(
            f"  {'':36} {'first':>8} {'min':>8} {'median':>8} {'p90':>8} {'max us':>8} "
            f"{'cpu us':>8} {'x floor':>8} {'recall':>8} {'false/1000':>10} {'rms mm':>7} "
            f"{'rms deg':>8} {'pictures':>8}"
        )
        for row in same:
            print(f"  {row.name:36} {_times(row)}{_errors(row)}")
        print()


def print_loops(loops: Sequence[LoopTimes], help_s: float) -> None:
    """Print what was measured of the whole loop.

    Args:
        loops: one per scenario.
        help_s: time of `echelon --help` [s].
    """
    print(f"{'loop, as fast as it goes':40} {'x real time':>12} {'p50 ms':>8} {'p99 ms':>8}")
    for run in loops:
        factor = f"{run.real_time_factor:.1f}"
        print(f"{run.scenario:40} {factor:>12} {run.p50_ms:8.2f} {run.p99_ms:8.2f}")
    print("(p50, p99: from a frame's hand-over until its commands are with the radio)")
    print(f"\nechelon --help: {help_s:.2f} s")


def print_simulation(speeds: Sequence[SimulationSpeed], times: LoadTimes) -> None:
    """Print what was measured of simulation without a camera.

    Args:
        speeds: one per formation.
        times: of the first call [s].
    """
    print(
        f"{'simulation without a camera, steps/s':40} {'robots':>8} {'alone':>10} {'batch':>10} "
        f"{'plain loop':>10} {'alone x':>8} {'batch x':>8}"
    )
    for s in speeds:
        print(
            f"{s.name:40} {s.robots:8} {s.alone:10,.0f} {s.batch:10,.0f} {s.plain:10,.0f} "
            f"{s.alone / s.plain:8.1f} {s.batch / s.plain:8.1f}"
        )
    print("(alone: one run at a time, one core; batch: 3000 robots' runs, all cores)")
    print(f"first call: {times.compile_s:.1f} s to compile, {times.load_s:.2f} s once compiled\n")


def flat(row: Row) -> dict[str, Any]:
    """A row of the vision for build/bench.json.

    Args:
        row: what was measured.

    Returns:
        Its figures side by side; null where there are none.
    """
    time, found = row.time, row.accuracy
    figures: dict[str, Any] = plain(
        {
            "name": row.name,
            "size": row.size,
            "robots": row.robots,
            "first_us": time and time.first_us,
            "min_us": time and time.min_us,
            "median_us": time and time.median_us,
            "p90_us": time and time.p90_us,
            "max_us": time and time.max_us,
            "cpu_us": time and time.cpu_us,
            "n_calls": time and time.rounds,
            "floor_ratio": row.floor_ratio,
            "recall": found and found.recall,
            "false_per_1000": found and found.false_per_1000,
            "position_rms_mm": found and found.position_rms_mm,
            "heading_rms_deg": found and found.heading_rms_deg,
            "n_frames": found and found.frames,
        }
    )
    return figures


def plain(value: Any) -> Any:
    """Data that JSON knows: dataclasses become objects, numbers that are not finite null.

    Args:
        value: a dataclass, list, mapping, number or text.

    Returns:
        The same as plain data.
    """
    if is_dataclass(value) and not isinstance(value, type):
        value = asdict(value)
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return None if isinstance(value, float) and not isfinite(value) else value


def _times(row: Row) -> str:
    t = row.time
    if t is None:
        return "skipped: not installed (pip install pupil-apriltags)"
    ratio = f"{row.floor_ratio:.2f}"
    figures = (t.first_us, t.min_us, t.median_us, t.p90_us, t.max_us, t.cpu_us)
    return " ".join(f"{us:8.0f}" for us in figures) + f" {ratio:>8}"


def _errors(row: Row) -> str:
    a = row.accuracy
    if a is None:
        return ""
    errors = (
        f"{a.position_rms_mm:7.3f} {a.heading_rms_deg:8.3f}" if a.recall else f"{'-':>7} {'-':>8}"
    )
    return f" {a.recall:8.2%} {a.false_per_1000:10.0f} {errors} {a.frames:8}"
