"""Robots that do not do what they are told stand, and so do their followers. Times in s."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from control.command import Command, RobotId
from control.estimation import Estimate
from control.geometry import Pose2D
from control.unicycle import Twist, UnicycleState, advance_pose
from datasets.cycle import Moment, Tick
from datasets.truth import RunResult
from pipeline.live import run
from pipeline.memory import Obedience, Track
from pipeline.obedience import disobedient, watch_obedience
from pipeline.rigs import connect
from pipeline.scenario import load_scenario
from pipeline.setup import Setup, make_scores, make_setup
from pipeline.tracking import remember
from tests.pipeline.runs import Keeper
from vision.frame import as_frame
from vision.light import PALETTE_LIGHT
from vision.scene import Detection, PixelPose, Scene

CIRCLE = (
    "camera.center_m=[0.0, 0.5]", "leader.segments=[{ radius_m = 0.5, turn_deg = 3600 }]",
    "leader.speed_mps=0.25", "duration_s=12",
)  # fmt: skip
FRAME, CALM = 1 / 30, Twist(0.0, 0.0)
ORIGIN, IMAGE = Pose2D(0.0, 0.0, 0.0), np.zeros((4, 4, 3), np.uint8)


@cache
def setup_of(*overrides: str) -> Setup:
    return make_setup(load_scenario("paper", overrides))


def told(
    twists: Sequence[Twist], poses: Sequence[Pose2D], setup: Setup | None = None
) -> list[tuple[float, Obedience]]:
    """What is known of robot 1 after each frame, told so since each and seen there 40 ms later."""
    setup = setup or setup_of()
    estimate = Estimate(0.0, np.zeros(7), np.zeros((7, 7)))
    tracks: dict[RobotId, Track] = {1: Track(estimate, estimate.state, 0.0)}
    memory: dict[RobotId, Obedience] = {}
    known = []
    for n, (twist, pose) in enumerate(zip(twists, poses, strict=True)):
        t = n * FRAME
        tracks = remember(tracks, (Command(1, twist, t, t + 0.1),))
        seen = Detection(1, pose, PixelPose(0.0, 0.0, 0.0), np.eye(3), 0.0, 1.0)
        scene = Scene(t, (seen,), (), PALETTE_LIGHT)
        tick = Tick(t + 0.04, as_frame(IMAGE, t, n))
        memory = dict(watch_obedience(setup, memory, tracks, scene, tick))
        known.append((tick.t, memory[1]))
    return known


def stands(known: Sequence[tuple[float, Obedience]], setup: Setup | None = None) -> list[bool]:
    """Whether it has to stand after each frame."""
    setup = setup or setup_of()
    return [bool(dict(disobedient(setup.rules, {1: one}, t))) for t, one in known]


@pytest.mark.parametrize("twist", [Twist(0.5, 0.0), Twist(-0.3, 0.0), Twist(0.0, 8.0)])
def test_a_robot_that_stands_all_the_same_has_to_stand_and_gets_another_chance(
    twist: Twist,
) -> None:
    """The commands go on as if nothing were noticed: each chance is wasted."""
    setup = setup_of()
    standing = stands(told([twist] * 300, [ORIGIN] * 300))
    rolled = abs(twist.v) + 0.034 * abs(twist.omega)
    first = standing.index(True) * FRAME
    assert first == pytest.approx(0.1 / rolled + setup.follower.actuation.lag, abs=2 * FRAME)
    edges = [n * FRAME for n, (a, b) in enumerate(pairwise(standing)) if a != b]
    pauses = [b - a for a, b in zip(edges[::2], edges[1::2], strict=False)]
    assert pauses == pytest.approx([1.0, 2.0, 4.0][: len(pauses)], abs=2 * FRAME)
    assert len(pauses) >= 2


@given(
    st.lists(st.tuples(st.floats(-1.5, 1.5), st.floats(-15.0, 15.0)), min_size=1, max_size=12),
    st.sampled_from((0.03, 0.05, 0.1)),
    st.floats(0.7, 1.3),
)
def test_a_robot_that_obeys_is_left_alone(
    wanted: list[tuple[float, float]], lag: float, gain: float
) -> None:
    """Whatever it is told, 0.2 s each: its motors lag and answer by 70 to 130 %."""
    twists = [Twist(v, omega) for v, omega in wanted for _ in range(6)]
    state, poses = UnicycleState(0.0, 0.0, 0.0, 0.0, 0.0), list[Pose2D]()
    for twist in twists:
        poses.append(state.pose)
        for _ in range(10):
            dt = FRAME / 10
            v = state.v + (gain * twist.v - state.v) * dt / lag
            omega = state.omega + (gain * twist.omega - state.omega) * dt / lag
            pose = advance_pose(state.pose, Twist(v, omega), dt)
            state = UnicycleState(pose.x, pose.y, pose.theta, v, omega)
    setup = setup_of(f"estimation.lag_s={lag}")
    assert not any(stands(told(twists, poses, setup), setup))


@given(st.floats(-0.09, 0.09), st.floats(-1.0, 1.0))
def test_what_nobody_could_see_within_a_second_is_not_judged(v: float, omega: float) -> None:
    slow = Twist(v, omega * (0.09 - abs(v)) / 0.034)
    assert not any(stands(told([slow] * 200, [ORIGIN] * 200)))


def test_a_robot_that_moves_again_has_its_first_pause_again() -> None:
    away = Pose2D(0.02, 0.0, 0.0)
    twists = [Twist(0.5, 0.0)] * 60 + [CALM] * 90
    known = told(twists, [ORIGIN] * 149 + [away])
    assert known[-2][1].pause > 1.0
    assert known[-1][1].pause == 1.0


def test_old_frames_and_a_switched_off_rule_change_nothing() -> None:
    twists, poses = [Twist(0.5, 0.0)] * 30, [ORIGIN] * 30
    assert any(stands(told(twists, poses)))
    off = setup_of("safety.unmoved_m=0")
    with pytest.raises(KeyError):  # nothing is known of the robot
        told(twists, poses, off)
    estimate = Estimate(0.0, np.zeros(7), np.zeros((7, 7)))
    tracks: dict[RobotId, Track] = {1: Track(estimate, estimate.state, 0.0)}
    seen = Detection(1, ORIGIN, PixelPose(0.0, 0.0, 0.0), np.eye(3), 0.0, 1.0)
    there = UnicycleState(1.0, 0.0, 0.0, 0.0, 0.0)
    held = Obedience(0.95, 0.95, ORIGIN, there, until=2.0, pause=2.0)  # it has just been stopped
    tick, scene = Tick(1.0, as_frame(IMAGE, 0.9, 0)), Scene(0.9, (seen,), (), PALETTE_LIGHT)
    for before in ({1: held}, {1: Obedience(0.95, 0.95, there.pose, there)}):
        assert watch_obedience(setup_of(), before, tracks, scene, tick) == before
    assert watch_obedience(setup_of(), before, tracks, None, Tick(1.0)) is before


class Dead:
    """A radio whose robot does not obey from a moment on until another."""

    min_period = 0.0

    def __init__(self, sink: Any, robot: RobotId, since: float, until: float) -> None:
        self._sink, self._robot, self._span = sink, robot, (since, until)

    def send(self, commands: tuple[Command, ...], now: float) -> tuple[RobotId, ...]:
        since, until = self._span
        dead = since <= now < until
        heard = (c for c in commands if not (dead and c.robot_id == self._robot))
        lost: tuple[RobotId, ...] = self._sink.send(tuple(heard), now)
        return lost

    def stop(self, now: float) -> None:
        self._sink.stop(now)

    def close(self) -> None:
        self._sink.close()


def run_with_dead(
    robot: RobotId, since: float, until: float, duration: float | None = None
) -> tuple[RunResult, list[Moment]]:
    scenario = load_scenario("paper", CIRCLE)
    setup, keeper = make_setup(scenario), Keeper()
    scores = make_scores(setup)
    rig = connect(scenario, "rendered", None, 0, True)
    dead = Dead(rig.sink, robot, since, until)
    rig = replace(rig, sink=dead, observers=(scores, keeper))
    run(setup, rig, setup.period, duration)
    return scores.result("paper", 0.0), keeper.moments


def speeds(moment: Moment) -> dict[RobotId, float]:
    return {r.robot_id: abs(r.state.v) for r in moment.truth}


def test_followers_of_a_leader_that_stops_obeying_stand_and_go_on_with_it() -> None:
    result, moments = run_with_dead(1, 2.0, 4.5)
    events = [e for e in result.safety_events if e.kind == "robot-stopped" and e.robot_id == 1]
    assert 2.3 < events[0].t < 3.2  # its own timeout is 0.3 s; then 0.1 m at 0.25 m/s, and latency
    assert "it stands" in events[0].detail
    standing = [m for m in moments if events[0].t + 0.4 < m.tick.t < events[0].t + 0.95]
    assert max(max(speeds(m).values()) for m in standing) < 0.02
    assert moments[-1].cycle.phase == "finished"
    assert all(abs(error) < 0.02 for pair in moments[-1].cycle.pairs for error in pair.error[:1])


def test_a_leader_that_never_moves_again_ends_the_run() -> None:
    _, moments = run_with_dead(1, 2.0, 1e9, 60.0)
    assert moments[-1].cycle.phase == "given-up"
    assert all(abs(pair.error[0]) < 0.2 for pair in moments[-1].cycle.pairs)  # not led astray


def test_others_go_on_without_a_follower_that_does_not_obey() -> None:
    result, moments = run_with_dead(2, 2.0, 1e9)
    assert {e.robot_id for e in result.safety_events if e.kind == "robot-stopped"} == {2}
    assert moments[-1].cycle.phase == "finished"
