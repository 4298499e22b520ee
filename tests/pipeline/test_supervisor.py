"""The state machine of a run, by what must hold after any course of events."""

from collections.abc import Iterable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from control.command import RobotId
from control.estimation import Estimate
from datasets.cycle import Orders as Wish
from datasets.cycle import SafetyEvent, Tick
from pipeline.memory import Mission, Track
from pipeline.scenario import load_scenario
from pipeline.setup import Setup, make_setup
from pipeline.supervisor import ENDS, Shares, supervise

DT = 0.01
BEFORE = Mission()
GO, HALT, ARM = Wish(), Wish(halt=True), Wish(arm=True)
Entry = tuple[Mission, Shares, tuple[SafetyEvent, ...]]


@cache
def setup_of(hold: bool = False) -> Setup:
    return make_setup(load_scenario("paper", (f"safety.hold={str(hold).lower()}",)))


def course(
    inputs: Iterable[tuple[Wish, bool]], hold: bool = False, start: Mission = BEFORE
) -> list[Entry]:
    """Missions under orders, while all robots are seen (True) or the leader is not (False)."""
    setup, mission, entries = setup_of(hold), start, list[Entry]()
    for n, (orders, seen) in enumerate(inputs):
        t = n * DT
        shares = dict.fromkeys(setup.formation.robots, float(seen))
        tracks = {robot: track(robot, t if seen else -1.0) for robot in setup.formation.robots}
        mission, shares_, events = supervise(
            setup, mission, tracks, shares, Tick(t, orders=orders), DT
        )
        entries.append((mission, shares_, events))
        if mission.phase in ENDS:
            break
    return entries


@cache
def track(robot: RobotId, t: float) -> Track:
    del robot
    estimate = Estimate(t, np.zeros(7), np.zeros((7, 7)))
    return Track(estimate, estimate.state, t)


def phases(entries: list[Entry]) -> list[str]:
    return [mission.phase for mission, _, _ in entries]


@given(
    st.lists(st.tuples(st.sampled_from((GO, GO, HALT, ARM)), st.booleans()), max_size=60),
    st.booleans(),
)
@settings(max_examples=200)
def test_whatever_happens_only_running_robots_move(
    inputs: list[tuple[Wish, bool]], hold: bool
) -> None:
    entries = course(inputs, hold)
    stopped = False
    for (orders, seen), (mission, shares, _) in zip(inputs, entries, strict=False):
        stopped = orders.halt or (stopped and not orders.arm)
        assert (mission.phase == "stopped") == stopped  # latched, and only by an order
        assert any(shares.values()) == (mission.phase == "running")
        assert seen or mission.phase != "running"
    before = BEFORE
    for (orders, _), (mission, _, _) in zip(inputs, entries, strict=False):
        began = mission.phase == "running" and before.phase != "running"
        assert not (hold and began and not orders.arm)  # nothing moves that nobody has armed
        before = mission


def test_the_clock_of_the_mission_stands_with_the_robots() -> None:
    inputs = [*[(GO, True)] * 10, (HALT, True), *[(GO, True)] * 19, (ARM, True), (GO, True)]
    entries = course(inputs)
    assert phases(entries) == ["running"] * 10 + ["stopped"] * 20 + ["running"] * 2
    assert entries[9][0].t_start == 0.0
    assert entries[-1][0].t_start == pytest.approx(20 * DT)
    kinds = [event.kind for _, _, events in entries for event in events]
    assert kinds == ["emergency-stop", "armed"]


def test_a_latched_stop_outlasts_the_patience_for_a_lost_robot() -> None:
    long = round(setup_of().rules.give_up / DT) + 5
    assert phases(course([(GO, True), *[(GO, False)] * long]))[-1] == "given-up"
    assert phases(course([(GO, True), (HALT, True), *[(GO, False)] * long]))[-1] == "stopped"


def test_a_host_that_was_stopped_for_a_minute_has_not_lost_its_patience() -> None:
    setup, mission = setup_of(), course([(GO, True), (GO, False)])[-1][0]
    assert mission.phase == "holding"
    shares = dict.fromkeys(setup.formation.robots, 0.0)
    after, _, _ = supervise(setup, mission, {}, shares, Tick(60.0), 60.0)
    assert after.phase == "holding"
    assert after.held < 1.0  # s


def test_on_hold_the_start_and_every_return_wait_for_a_person() -> None:
    seen, away = (GO, True), (GO, False)
    entries = course([seen, seen, (ARM, True), seen, away, seen, seen, (ARM, True)], hold=True)
    assert phases(entries) == [
        "armed", "armed", "running", "running", "holding", "holding", "holding", "running",
    ]  # fmt: skip
    assert phases(course([(ARM, False), seen], hold=True)) == ["idle", "armed"]


def test_a_stop_before_the_start_is_a_stop() -> None:
    entries = course([(HALT, True), (GO, True), (ARM, True), (GO, True)])
    assert phases(entries)[:2] == ["stopped"] * 2
    assert phases(entries)[-1] == "running"
    ended = replace(entries[-1][0], t_start=-setup_of().duration)
    assert phases(course([(GO, True)], start=ended)) == ["finished"]
