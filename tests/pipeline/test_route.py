"""What comes into the leader's way: seen by the camera, evaded by another plan, or waited for."""

from dataclasses import replace
from functools import cache
from itertools import pairwise
from math import cos, hypot, sin
from pathlib import Path

import numpy as np
import pytest

from control.estimation import initial_estimate
from control.obstacles import Obstacle
from control.replanning import Answer, answered
from control.spline_plan import SplinePlan
from control.unicycle import UnicycleState
from datasets.cycle import Moment, Tick
from datasets.recorded import SessionHeader, SessionWriter, read_session, software_versions
from datasets.truth import RunResult
from pipeline.errors import ConfigError
from pipeline.memory import Mission, Route, Track
from pipeline.replay import replay
from pipeline.route import AHEAD, BRAKING, PAUSE, TOLERANCE, renew, wanted_motion
from pipeline.scenario import load_scenario
from pipeline.setup import Setup, make_setup
from pipeline.simulation.experiment import make_experiment
from tests.pipeline.runs import run_scenario
from vision.frame import as_frame

PICTURE = as_frame(np.zeros((4, 4, 3), np.uint8), 0.0, 0)
NOW = 1.0  # on the mission's clock, which began at 0 [s]
UNDER_WAY = Mission("running", 0.0)
SHARES = {1: 1.0, 2: 1.0, 3: 1.0}
FIRST = Route()


@cache
def setup() -> Setup:
    return make_setup(load_scenario("crossing"))


@cache
def crossing() -> tuple[Setup, RunResult, list[Moment]]:
    return run_scenario("crossing", 3)


def track(state: UnicycleState) -> Track:
    estimate = initial_estimate(state.pose, np.eye(3), NOW, setup().free_motion)
    return Track(estimate, state, NOW)


def looked(
    obstacle: UnicycleState,
    route: Route = FIRST,
    leader: UnicycleState | None = None,
    t: float = NOW,
    answer: Answer | None = None,
) -> tuple[Route, float, list[str], tuple[str, ...]]:
    """What a look at robot 4 changes: route, the leader's share, kinds of events, notes."""
    here = leader or wanted(route, NOW)
    tracks = {1: track(here), 4: track(obstacle)}
    tick = Tick(t, PICTURE, answer=answer)
    mission = replace(UNDER_WAY, t_start=t - NOW)
    after, shares, events, notes = renew(setup(), route, mission, tracks, SHARES, tick)
    return after, shares[1], [event.kind for event in events], notes


def wanted(route: Route, t: float) -> UnicycleState:
    motion = wanted_motion(setup(), route, t)
    assert motion
    return motion.state


def at(x: float, y: float, v: float = 0.0, theta: float = 0.0) -> UnicycleState:
    return UnicycleState(x, y, theta, v, 0.0)


def on_the_way(later: float, aside: float = 0.0) -> UnicycleState:
    """Where the leader will be, or beside it."""
    s = wanted(FIRST, NOW + later)
    return at(s.x - aside * sin(s.theta), s.y + aside * cos(s.theta))


def room() -> float:
    errand = setup().errand
    assert errand
    return errand.clearance + setup().worn[4]


def test_the_formation_evades_what_is_carried_into_its_way() -> None:
    run, result, moments = crossing()
    body = run.tags.tags[0].side / 2.0**0.5  # half a diagonal [m]
    for moment in moments:
        places = {robot.robot_id: robot.state for robot in moment.truth}
        o = places.pop(4)
        gaps = [hypot(s.x - o.x, s.y - o.y) - run.worn[4] - body for s in places.values()]
        assert min(gaps) > 0.0
    leader = next(r.state for r in moments[-1].truth if r.robot_id == 1)
    assert hypot(leader.x - 1.5, leader.y) <= 0.01  # m: at its goal
    assert max(next(r.state.y for r in m.truth if r.robot_id == 1) for m in moments) > 0.3
    assert any(note.startswith("another way from") for note in result.notes)
    assert {event.kind for event in result.safety_events} <= {"way-blocked", "way-free"}
    assert result.vision
    assert result.vision.false_ids == 0
    assert {sighted.robot_id for sighted in result.seen} == {1, 2, 3, 4}


def test_the_plan_has_no_jump_where_it_changes_on_the_way() -> None:
    _, _, moments = crossing()
    rows = [m.cycle for m in moments if m.cycle.phase == "running" and m.cycle.planned]
    steps = 0
    for one, two in pairwise(rows):
        a, b = one.planned, two.planned
        assert a
        assert b
        if two.t - one.t < 0.006 and a.state.v > 0.05:
            dt = two.t_effective - one.t_effective
            assert hypot(b.state.x - a.state.x, b.state.y - a.state.y) < 2.0 * dt * 0.5
            assert abs(b.state.v - a.state.v) < 0.02
            steps += 1
    assert steps > 1000


def test_a_recorded_run_with_other_ways_replays_bit_for_bit(tmp_path: Path) -> None:
    run, _, moments = crossing()
    header = SessionHeader("crossing", "", 3, software_versions())
    writer = SessionWriter(tmp_path / "s.mcap", header, lossless=True)
    for moment in moments:
        writer.observe(moment)
    writer.close()
    again = list(read_session(tmp_path / "s.mcap"))
    answers = [m.tick.answer for m in again if m.tick.answer]
    assert [a.t_start for a in answers] == [m.tick.answer.t_start for m in moments if m.tick.answer]
    assert any(a.plan for a in answers)
    assert replay(run, again, ()) == ()
    forgotten = (replace(m, tick=replace(m.tick, answer=None)) for m in again)
    assert replay(run, forgotten, ()) != ()


def test_the_first_plan_minds_tags_whose_starts_are_known() -> None:
    scenario = load_scenario("crossing", ("robots.4.start={x_m=0.75,y_m=0.03}",))
    path = make_setup(scenario).path
    assert isinstance(path, SplinePlan)
    assert path.clearance(0.0, (Obstacle(0.75, 0.03, 0.1),)) > room() - 0.1 - 1e-3


def test_what_is_far_from_the_way_asks_nothing() -> None:
    after, share, kinds, notes = looked(on_the_way(1.0, aside=room() + 0.05))
    assert (after.question, after.blocked, share, kinds, notes) == (None, False, 1.0, [], ())


def test_what_stands_in_the_way_asks_for_one_that_goes_on_from_this() -> None:
    after, share, kinds, _ = looked(on_the_way(2.0))
    assert after.question
    assert (after.question.old, share, kinds) == (setup().path, 1.0, [])
    request = after.question.request
    assert request.t_start == pytest.approx(NOW + AHEAD)
    assert [o.radius for o in request.obstacles] == [setup().worn[4]]
    assert after.asked == NOW
    soon, *_ = looked(on_the_way(2.0), replace(after, asked=NOW - 0.5 * PAUSE))
    assert soon.question is None  # one at a time
    again, *_ = looked(on_the_way(2.0), replace(after, asked=NOW - 1.1 * PAUSE))
    assert again.question


def test_what_moves_towards_the_way_is_looked_for_on_its_own_way() -> None:
    beside = on_the_way(2.0, aside=room() + 0.2)
    towards = replace(beside, v=0.3, theta=beside.theta - np.pi / 2.0)
    assert looked(beside)[0].question is None
    after = looked(towards)[0]
    assert after.question
    assert len(after.question.request.obstacles) == 3


@pytest.mark.parametrize("later", [0.0, 0.5 * BRAKING])
def test_where_there_is_no_time_all_stand_and_a_way_from_there_is_asked_for(later: float) -> None:
    aside = room() - 2.0 * TOLERANCE
    after, share, kinds, _ = looked(on_the_way(later, aside))
    assert (after.blocked, share, kinds) == (True, 0.0, ["way-blocked"])
    assert after.question is None  # it still drives
    here = wanted(FIRST, NOW)
    stands = at(here.x, here.y, 0.0, here.theta)
    still, share, kinds, _ = looked(on_the_way(later, aside), after, stands, NOW + PAUSE)
    assert (still.blocked, share, kinds) == (True, 0.0, [])
    assert still.question
    assert still.question.old is None
    request = still.question.request
    assert (request.start, request.t_start) == (stands, NOW)
    errand = setup().errand
    assert errand
    assert errand.clearance - 0.021 <= request.clearance < errand.clearance  # as there is room


def test_a_way_is_free_when_nothing_is_in_it() -> None:
    blocked = Route(blocked=True)
    beside = on_the_way(1.0, aside=room() + 0.05)
    after, share, kinds, _ = looked(beside, blocked)
    assert (after.blocked, share, kinds) == (False, 1.0, ["way-free"])
    later = looked(on_the_way(2.0), blocked)[0]
    assert later.blocked  # not before the whole rest is


def found(later: float) -> Answer:
    question = looked(on_the_way(later))[0].question
    assert question
    return answered(question)


def test_another_way_begins_where_the_old_one_is_then() -> None:
    answer = found(2.0)
    after, _, _, notes = looked(at(0.0, -0.8), answer=answer)
    assert (after.plan, after.before) == (answer.plan, setup().path)
    assert notes == (f"another way from 1.30 s on: at the goal at {answer.plan.t_end:.2f} s",)  # type: ignore[union-attr]
    assert wanted(after, NOW) == wanted(FIRST, NOW)
    one, two = wanted(after, answer.t_start), wanted(FIRST, answer.t_start)
    assert (one.x, one.y, one.v) == pytest.approx((two.x, two.y, two.v))
    assert wanted(after, answer.t_start + 1.5) != wanted(FIRST, answer.t_start + 1.5)


def test_a_way_that_comes_too_late_is_not_taken() -> None:
    answer = replace(found(2.0), t_start=NOW - 0.01)
    assert isinstance(answer.plan, SplinePlan)
    late = replace(answer, plan=replace(answer.plan, t_start=NOW - 0.01))
    after, _, _, notes = looked(at(0.0, -0.8), answer=late)
    assert after.plan is None
    assert notes == ("another way came too late and was not taken",)


def test_that_there_is_no_way_is_told_once() -> None:
    nothing = Answer(NOW + AHEAD, 0.3, None, "no plan in 3 s")
    after, _, _, notes = looked(on_the_way(2.0), answer=nothing)
    assert notes == ("no other way: no plan in 3 s",)
    assert looked(on_the_way(2.0), after, answer=nothing)[3] == ()


def test_nothing_is_judged_before_the_start_at_the_goal_or_without_a_picture() -> None:
    here, there = wanted(FIRST, NOW), wanted(FIRST, 60.0)
    for mission, tick, where in (
        (Mission("armed"), Tick(NOW, PICTURE), here),
        (UNDER_WAY, Tick(NOW), here),
        (UNDER_WAY, Tick(60.0, PICTURE), there),
    ):
        tracks = {1: track(where), 4: track(where)}
        after, shares, events, _ = renew(setup(), Route(), mission, tracks, SHARES, tick)
        assert (after.question, after.blocked, shares, events) == (None, False, SHARES, ())


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ("obstacles=[{radius_m=0.1}]", "give either robot, or x_m and y_m"),
        ("obstacles=[{robot=4,x_m=0.0,y_m=0.0,radius_m=0.1}]", "give either robot, or x_m"),
        ("obstacles=[{robot=4,vx_mps=0.1,radius_m=0.1}]", "give either robot, or x_m and y_m"),
        ("obstacles=[{robot=2,radius_m=0.1}]", "obstacle 2 must be a robot outside the formation"),
        ("obstacles=[{robot=9,radius_m=0.1}]", "obstacle 9 must be a robot outside the formation"),
    ],
)
def test_obstacles_that_are_none_are_refused(change: str, expected: str) -> None:
    with pytest.raises(ConfigError, match=expected):
        load_scenario("crossing", (change,))


def test_nobody_drives_an_obstacle_and_no_batch_plans_anew() -> None:
    assert load_scenario("crossing").commanded == (1, 2, 3)
    scenario = load_scenario("crossing")
    free = tuple(robot.model_copy(update={"carried": None}) for robot in scenario.robots)
    with pytest.raises(ConfigError, match="plans anew where obstacles move"):
        make_experiment(scenario.model_copy(update={"robots": free}))


def test_an_obstacle_that_is_not_seen_yet_is_none() -> None:
    tracks = {1: track(wanted(FIRST, NOW))}
    after, *_ = renew(setup(), Route(), UNDER_WAY, tracks, SHARES, Tick(NOW, PICTURE))
    assert (after.question, after.blocked) == (None, False)
