"""Bodies kept apart in whole runs: true bodies, through pixels."""

from typing import Any

import numpy as np
import pytest

from control.command import Command
from datasets.bodies import Floats, pair_gaps
from datasets.cycle import Moment
from pipeline import restraint
from pipeline.clearing import clear_commands
from tests.pipeline.runs import run_scenario

SIDE = 0.075
ALONE = "formation.pairs=[{leader=1, follower=2, distance_m=0.25, bearing_deg=135.0}]"


def commands(moments: list[Moment]) -> list[tuple[Command, ...]]:
    """What was sent in every cycle."""
    return [moment.cycle.commands for moment in moments]


def poses(moments: list[Moment]) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """True poses, shape (T, R, 3) [m, m, rad]."""
    return np.array([[(r.state.x, r.state.y, r.state.theta) for r in m.truth] for m in moments])


def test_idle_where_nothing_is_close() -> None:
    _, result, kept = run_scenario("diamond", 1, duration=4.0)
    _, _, free = run_scenario("diamond", 1, ("safety.clearance_m=0",), duration=4.0)
    assert commands(kept) == commands(free)
    assert not result.safety_events


def test_without_the_filter_the_paper_s_robots_nearly_touch() -> None:
    _, result, _ = run_scenario("paper", 1, ("safety.clearance_m=0",), duration=1.5)
    assert result.min_clearance_m is not None
    assert result.min_clearance_m < 0.01


def test_nobody_leaves_the_arena() -> None:
    arena = "safety.arena_m=[-0.6, -0.5, 0.9, 0.8]"  # the plan goes on to x = 1.45 m
    _, result, moments = run_scenario("paper", 1, (arena,), duration=5.0)
    x, _, theta = np.moveaxis(poses(moments), -1, 0)
    reach = x + 0.5 * SIDE * (np.abs(np.cos(theta)) + np.abs(np.sin(theta)))
    assert 0.8 < reach.max() < 0.9 - 0.018
    kinds = {(event.kind, event.robot_id) for event in result.safety_events}
    assert ("kept-apart", 1) in kinds


def test_robots_nobody_drives_are_not_run_into() -> None:
    there = "robots.3.start={x_m=0.7, y_m=0.02}"
    _, result, moments = run_scenario("diamond", 1, (ALONE, there), duration=4.0)
    gaps = pair_gaps(poses(moments), np.full(4, SIDE))
    assert 0.018 < gaps.min() < 0.03
    event = next(e for e in result.safety_events if e.robot_id == 1)
    assert event.kind == "kept-apart"
    assert "nearest is robot 3" in event.detail


def test_a_carried_leader_counts_as_one_that_gives_no_way(monkeypatch: pytest.MonkeyPatch) -> None:
    tables = list[Floats]()

    def _noted(table: Floats, *rest: Any) -> Floats:
        tables.append(table)
        return clear_commands(table, *rest)

    monkeypatch.setattr(restraint, "clear_commands", _noted)
    run_scenario("hand-led", 1, duration=1.0)
    rows = np.array(tables)
    assert np.isnan(rows[:, 0, 5:7]).all()  # nobody drives it
    assert (rows[:, 0, 9] == 0.0).all()
    assert (rows[:, 1:, 9] == restraint.FOLLOWER_FREEDOM).all()
