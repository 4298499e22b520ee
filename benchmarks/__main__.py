"""`make bench`: everything in one run, as tables and as build/bench.json."""

import argparse
import json
import subprocess
import sys
from pathlib import Path
from statistics import median
from time import perf_counter

import cv2

from benchmarks import bound_table, loop, simulation, tables, vision
from benchmarks.machine import describe

OUT = Path("build")
PARTS = ("vision", "peers", "loop", "simulation", "bound")


def main() -> None:
    """Measure, print, write."""
    options = _options()
    cv2.setNumThreads(1)
    parts = options.only or PARTS
    machine, start = describe(), perf_counter()
    print(f"{machine.sentence()}\n")
    result: dict[str, object] = {"machine": tables.plain(machine)}
    if "vision" in parts or "peers" in parts:
        rows = [row for s in vision.SETTINGS for row in vision.measure(s, "peers" in parts)]
        tables.print_rows(rows)
        result["vision"] = [tables.flat(row) for row in rows]
    if "loop" in parts:
        loops = [loop.measure(name) for name in ("paper", "moving-start", "cascade")]
        help_s = _help_time()
        tables.print_loops(loops, help_s)
        result |= {"loop": tables.plain(loops), "help_s": help_s}
    if "simulation" in parts:
        speeds, times = simulation.measure()
        tables.print_simulation(speeds, times)
        result["simulation"] = tables.plain({"speeds": speeds, "first_call": times})
    if "bound" in parts:
        quick = options.quick or parts != ["bound"]
        result["bound"] = tables.plain(bound_table.measure(quick))
    OUT.mkdir(exist_ok=True)
    out = OUT / ("-".join(["bench", *options.only]) + ".json")
    out.write_text(json.dumps(result, indent=1) + "\n")
    print(f"\nwritten: {out}, after {perf_counter() - start:.0f} s")


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("part", nargs="?", choices=PARTS, help="measure this part only")
    parser.add_argument("--only", action="append", choices=PARTS, help="the same, repeatable")
    parser.add_argument("--quick", action="store_true", help="fewer cases of the bound")
    options = parser.parse_args()
    options.only = [*(options.only or []), *([options.part] if options.part else [])]
    return options


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
