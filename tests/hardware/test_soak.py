"""The soak tool's table and its look at memory; the soak itself is run by hand."""

import os
from math import cos, sin
from typing import Any

import pytest

from pipeline.scenario import load_scenario
from tests.hardware.formed import WANTED, errors
from tests.hardware.memory import Memory
from tests.hardware.soak import Soaked, circle, rows


def frame(t: float, too_far: float = 0.0) -> dict[str, Any]:
    """Everybody in place, facing along x, but the second robot."""
    robots = [{"id": 1, "x_m": 1.0, "y_m": 2.0, "theta_rad": 0.0}]
    for robot, (distance, bearing) in WANTED.items():
        d = distance + (too_far if robot == 2 else 0.0)
        x, y = 1.0 + d * cos(bearing) - 0.05, 2.0 + d * sin(bearing)
        robots.append({"id": robot, "x_m": x, "y_m": y, "theta_rad": 0.0})
    return {"t": t, "published_t": t + 0.004, "clearance_m": 0.1, "robots": robots}


def test_errors_are_those_of_the_paper_s_formation() -> None:
    assert errors([frame(0.0)], 3)[0] == pytest.approx((0.0, 0.0), abs=1e-12)
    assert errors([frame(0.0, 0.01)], 2)[0] == pytest.approx((0.01, 0.0), abs=1e-12)


def test_the_table_tells_what_a_soak_is_for() -> None:
    frames = [frame(t / 30.0, 0.002 if t == 500 else 0.0) for t in range(900)]
    robots = [{"commands": [(1.0, 9, 9), (28.0, 9, 9)], "timeouts": n} for n in (0, 0, 1)]
    row = {"what": "loop later than its beat", "median_ms": 0.1, "p99_ms": 2.0, "most_ms": 7.0}
    result = {
        "duration_s": 27.0, "frames": 810, "commands_sent": 6000, "cadence": [row], "links": [],
        "latency_ms": {"frame_to_command_p50": 1.5, "frame_to_command_p99": 3.0},
        "safety_events": [{"kind": "kept-apart"}, {"kind": "camera-silent"}],
    }  # fmt: skip
    memory = Memory(os.getpid())
    memory.look()
    soaked = Soaked(result, {"frames": frames, "robots": robots}, memory.growth, None, 0, 1.0)
    table = dict(rows(soaked))
    assert table["loop later than its beat: median, 99 %, most ms"] == "0.10, 2.00, 7.00"
    assert table["kept apart, times; other safety events"] == "1; camera-silent"
    assert table["stops by the robots' own timeouts, by robot"] == "0, 0, 1"
    two = table["robot 2, true errors once settled: rms, worst mm; rms, worst deg"]
    assert two == "0.09, 2.00; 0.00, 0.00"


def test_memory_that_is_held_is_seen() -> None:
    memory = Memory(os.getpid())
    memory.look()
    held = b"x" * 50_000_000
    memory.look()
    assert 40.0 < memory.growth.last - memory.growth.warm < 80.0
    assert held
    assert Memory.of_child(os.getpid()).growth.last == 0.0  # nobody has looked


def test_the_circle_outlasts_the_minutes_inside_the_picture() -> None:
    scenario = load_scenario("paper", circle(10.0))
    assert scenario.duration_s == 600.0
    assert scenario.leader is not None
    assert scenario.leader.segments is not None
