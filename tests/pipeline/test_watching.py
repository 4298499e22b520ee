"""Robots that move at the start: watched, their rates and spread told, engaged without a bump."""

import re
from collections.abc import Callable
from math import degrees

import numpy as np
import pytest

import pipeline.step
from control.geometry import Pose2D
from control.initial_rate import MIN_SAMPLES
from control.relative import relative_rates, relative_state
from control.unicycle import Twist, advance_pose
from datasets.cycle import Cycle, Moment, Tick
from pipeline.memory import Memory
from pipeline.scenario import load_scenario
from pipeline.setup import Setup, make_setup
from pipeline.step import step
from tests.pipeline.runs import run_scenario
from tests.pipeline.test_closed_loop import truth_of
from vision.frame import Frame, as_frame
from vision.scene import Detection, PixelPose, Scene

FRAME, OFFSET = 1 / 30, 0.05  # s, m
TWISTS = {1: Twist(0.3, 0.0), 2: Twist(0.5, -0.2), 3: Twist(0.1, 0.3)}
STARTS = {1: Pose2D(0.0, 0.0, 0.0), 2: Pose2D(-0.5, 0.2, 0.0), 3: Pose2D(-0.4, -0.2, 0.0)}
FAST = ("robots.2.start.v_mps=0.5", "robots.3.start.v_mps=0.1")  # their leader drives 0.3 m/s
SAID = re.compile(r"rate (-?[\d.]+) \+- ([\d.]+)")
Seen = Callable[[int, int], bool]  # robot, frame


@pytest.fixture(scope="module")
def setup() -> Setup:
    return make_setup(load_scenario("moving-start"))


def pose_of(robot: int, t: float) -> Pose2D:
    """Where a robot is."""
    return advance_pose(STARTS[robot], TWISTS[robot], t)


def watch(setup: Setup, seen: Seen, frames: int) -> list[tuple[Memory, Cycle]]:
    """Robots on arcs, each seen exactly in some of the frames, until they are engaged."""

    def _locate(_: object, frame: Frame, *__: object) -> Scene:
        return Scene(frame.t_capture, tuple(
            Detection(r, pose_of(r, frame.t_capture), PixelPose(0.0, 0.0, 0.0),
                      np.diag([1e-8, 1e-8, 1e-6]), 0.1, 1.0)
            for r in STARTS if seen(r, frame.sequence)
        ))  # fmt: skip

    memory, course = Memory(), []
    for i in range(frames):
        image = np.full((240, 320, 3), i % 256, np.uint8)
        tick = Tick(FRAME * i + 0.04, as_frame(image, FRAME * i, i))
        memory, cycle = step(setup, memory, tick, _locate)
        course.append((memory, cycle))
        if cycle.commands:
            break
    return course


def true_rates(leader: int, follower: int, t: float) -> tuple[float, float]:
    """h' at a time [mm/s, deg/s]."""
    seen = relative_state(pose_of(leader, t), pose_of(follower, t), OFFSET)
    rates = relative_rates(seen, TWISTS[leader], TWISTS[follower], OFFSET)
    return 1e3 * rates.distance, degrees(rates.bearing)


@pytest.mark.parametrize("lost", [0.0, 0.15, 0.3])  # of the sightings of each robot
def test_the_rates_are_told_whatever_frames_miss(setup: Setup, lost: float) -> None:
    sees = np.random.default_rng(0).random((4, 200)) >= lost
    course = watch(setup, lambda robot, i: bool(sees[robot, i]), 200)
    engaged, last = course[-1][1], course[-2][0].mission.glimpses
    assert len(engaged.notes) == 2
    assert engaged.t - last[0].t >= 0.5
    assert len(last) >= MIN_SAMPLES
    assert not any(cycle.commands or cycle.notes for _, cycle in course[:-1])
    for follower, note in zip((2, 3), engaged.notes, strict=True):
        (rate, spread), (turn, turn_spread) = (map(float, found) for found in SAID.findall(note))
        true_rate, true_turn = true_rates(1, follower, last[-1].t)
        assert rate == pytest.approx(true_rate, abs=8.0)  # mm/s; they drive 200 mm/s apart
        assert turn == pytest.approx(true_turn, abs=3.0)  # deg/s
        assert 0.0 < spread < 60.0  # robots on arcs: the rate itself changes
        assert 0.0 < turn_spread < 25.0


def by_turns(robot: int, i: int) -> bool:
    """Robot 2 is seen in every other frame, robots 1 and 3 in the others."""
    return (i + robot) % 2 == 0


def test_nobody_is_engaged_who_was_not_seen_together(setup: Setup) -> None:
    course = watch(setup, by_turns, 90)
    assert {cycle.phase for _, cycle in course[2:]} == {"armed"}


def test_a_few_sightings_are_no_rate(setup: Setup) -> None:
    # together in every fifth frame: three times in half a second
    course = watch(setup, lambda robot, i: i % 5 == 0 or by_turns(robot, i), 90)
    assert course[-1][1].notes
    assert len(course[-2][0].mission.glimpses) + 1 == MIN_SAMPLES


def test_rates_are_fresh_when_they_are_used(setup: Setup) -> None:
    # together in 10 frames, then by turns: each is in sight, but what was seen is old
    course = watch(setup, lambda robot, i: not 10 <= i < 60 or by_turns(robot, i), 90)
    assert course[-1][1].notes
    assert course[-1][1].t >= 60 * FRAME
    assert len(course[-2][0].mission.glimpses) > MIN_SAMPLES


def largest_s(setup: Setup, moments: list[Moment]) -> float:
    """Largest |s| of a distance since the start [mm]: what the law takes for a bump."""
    memory, largest = Memory(), 0.0
    for moment in moments:
        memory, _ = step(setup, memory, moment.tick)
        for law in memory.laws.followers.values():
            largest = max(largest, 1e3 * abs(law.distance.sliding))
    return largest


def test_fast_robots_are_engaged_without_a_bump(monkeypatch: pytest.MonkeyPatch) -> None:
    setup, _, moments = run_scenario("moving-start", 1, FAST, 1.2)
    assert largest_s(setup, moments) < 6.0  # mm
    # ... which h'(0) = 0 does not do: the robots drive 0.2 m/s faster and slower than the leader
    monkeypatch.setattr(pipeline.step, "initial_rates", lambda *_: ({}, ("robots rest",)))
    setup, _, moments = run_scenario("moving-start", 1, FAST, 1.2)
    assert largest_s(setup, moments) > 7.0  # mm


@pytest.mark.parametrize("seed", [1, 2])
def test_rates_through_a_camera_that_loses_frames(seed: int) -> None:
    lossy = (*FAST, "camera.dropped_share=0.3")
    setup, _, moments = run_scenario("moving-start", seed, lossy, 0.8)
    engaged = next(moment for moment in moments if moment.cycle.notes)
    for pair, note in zip(setup.formation.pairs, engaged.cycle.notes, strict=True):
        leader, follower = (truth_of(engaged, robot) for robot in (pair.leader, pair.follower))
        seen = relative_state(leader.pose, follower.pose, OFFSET)
        true = relative_rates(seen, leader.twist, follower.twist, OFFSET)
        (rate, _), (turn, _) = (map(float, found) for found in SAID.findall(note))
        assert rate == pytest.approx(1e3 * true.distance, abs=20.0)  # mm/s
        assert turn == pytest.approx(degrees(true.bearing), abs=10.0)  # deg/s
