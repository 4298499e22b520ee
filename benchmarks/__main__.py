"""`make bench`: all timings in one run, as a table and as build/bench.json."""

import argparse
import json
import os
import subprocess
import sys
from dataclasses import asdict
from pathlib import Path
from statistics import median
from time import perf_counter

from benchmarks import bound_table, loop, vision
from benchmarks.timing import Timed

OUT = Path("build/bench.json")


def main() -> None:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("only", nargs="?", choices=("bound",), help="the fit beside its bound")
    parser.add_argument("--quick", action="store_true", help="fewer cases")
    asked = parser.parse_args()
    if asked.only == "bound":
        bound_table.measure(asked.quick)
        return
    print(f"load average {os.getloadavg()[0]:.2f} on {os.cpu_count()} cores\n")
    times = [row for name in ("paper", "cascade") for row in vision.measure(name)]
    floors = {row.name: row for row in times}
    print(f"{'vision':60} {'p50 us':>9} {'p99 us':>9} {'x floor':>8}")
    for row in times:
        print(f"{row.name:60} {row.p50_us:9.0f} {row.p99_us:9.0f} {_ratio(row, floors):>8}")
    loops = [loop.measure(name) for name in ("paper", "moving-start", "cascade")]
    print(f"\n{'loop, as fast as it goes':40} {'x real time':>12} {'p50 ms':>8} {'p99 ms':>8}")
    for run in loops:
        factor = f"{run.real_time_factor:.1f}"
        print(f"{run.scenario:40} {factor:>12} {run.p50_ms:8.2f} {run.p99_ms:8.2f}")
    print("(p50, p99: from a frame's hand-over until its commands are with the radio)")
    help_s = _help_time()
    print(f"\nechelon --help: {help_s:.2f} s")
    OUT.parent.mkdir(exist_ok=True)
    rows = {"vision": [asdict(r) for r in times], "loop": [asdict(r) for r in loops]}
    OUT.write_text(json.dumps({**rows, "help_s": help_s}, indent=1) + "\n")
    print(f"written: {OUT}")


def _ratio(row: Timed, floors: dict[str, Timed]) -> str:
    return f"{row.p50_us / floors[row.floor].p50_us:.1f}" if row.floor else ""


def _help_time() -> float:
    """Median time of `echelon --help` as a whole process [s]."""
    times = []
    for _ in range(5):
        start = perf_counter()
        subprocess.run(
            [sys.executable, "-m", "pipeline", "--help"], capture_output=True, check=True
        )
        times.append(perf_counter() - start)
    return median(times)


main()
