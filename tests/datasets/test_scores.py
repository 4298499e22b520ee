"""Scores of runs whose errors are known beforehand."""

import json
from math import cos, hypot, pi, sin

import numpy as np
import pytest

from control.command import Command
from control.formation import Formation, Pair, Shape
from control.geometry import Pose2D
from control.plan import PathSegment, PlannedPath
from control.profile import TanhStep
from control.unicycle import Twist, UnicycleState
from datasets.cycle import Cycle, Moment, RobotState, SafetyEvent, Tick, Timing
from datasets.scores import Motions, follower_errors, follower_score, settled_at
from datasets.sightings import Sightings
from datasets.truth import RunResult, Scores
from vision.camera import overhead_camera
from vision.frame import as_frame
from vision.scene import Detection, PixelPose, Rejection, Scene

CAMERA = overhead_camera((320, 240), 2.4, (0.5, 0.4), 2.5, 0.075)
PATH = PlannedPath(Pose2D(0.0, 0.0, 0.0), (PathSegment(5.0),), 0.5, 0.5)
SHAPE = Shape(TanhStep(0.2, 0.3, 3.0, 10.0), TanhStep.constant(pi))
FORMATION = Formation((Pair(1, 2, SHAPE),))
D = 0.05  # camera offset [m]
START = 0.5  # of the mission [s]


def states(t: float, off: float, side: float) -> tuple[RobotState, ...]:
    """Leader on the plan but 3 mm left; follower behind it, too far by off and turned by side."""
    mission = max(t - START, 0.0)
    wanted = SHAPE.at(mission)
    leader = UnicycleState(0.5 * mission, 0.003, 0.0, 0.5, 0.0)
    distance, angle = wanted.distance + off, pi + side
    point = leader.x + distance * cos(angle), leader.y + distance * sin(angle)
    follower = UnicycleState(point[0] - D, point[1], 0.0, 0.55, -0.7)
    return RobotState(1, leader), RobotState(2, follower)


def seen(states: tuple[RobotState, ...], t: float, shift: float) -> Scene:
    """What vision says, each robot displaced by shift and turned by 0.01 rad."""
    found = tuple(
        Detection(
            s.robot_id,
            Pose2D(s.state.x + shift, s.state.y, s.state.theta + 0.01),
            PixelPose(0.0, 0.0, 0.0),
            np.eye(3),
            0.0,
            1.0,
        )
        for s in states
    )
    return Scene(t, found, (Rejection(1.0, 2.0, "too small"),))


def run(
    with_truth: bool = True, shift: float = 0.0004, start: float | None = START, ticks: int = 500
) -> RunResult:
    """Five seconds: 50 mm too far at first, 1 mm and 0.02 rad off after 2 s of the mission."""
    scores = Scores(FORMATION, D, CAMERA, 0.075)
    for k in range(ticks):
        t = 0.01 * k
        true = states(t, 0.001 if t > START + 2.0 else 0.05, 0.02)
        scene = seen(true, t - 0.04, shift) if k % 4 == 0 and k >= 4 else None
        if scene is not None:
            at_capture = states(t - 0.04, 0.001 if t - 0.04 > START + 2.0 else 0.05, 0.02)
            scene = seen(at_capture, t - 0.04, shift)
        events = (SafetyEvent(t, "robot-lost", 2, "for 0.3 s"),) if k == 100 else ()
        commands = (Command(2, Twist(0.0, 0.0), t, t + 0.1),)
        t_start = start if start is not None and t >= start else None
        planned = None if t_start is None else PATH.at(t - t_start)
        cycle = Cycle(t, t, "running", t_start, scene, true, (), planned, commands, events)
        scores.observe(
            Moment(Tick(t), cycle, true if with_truth else (), Timing(0.0002, 0.0005, 0.0006))
        )
    scores.close()
    return scores.result("test", 1.5)


@pytest.mark.parametrize("with_truth", [True, False])
def test_followers_and_leader(with_truth: bool) -> None:
    result = run(with_truth)
    assert result.truth is with_truth
    (score,) = result.followers
    assert (score.follower, score.leader) == (2, 1)
    assert score.distance_rms_m == pytest.approx(0.001, abs=1e-9)
    assert score.distance_max_m == pytest.approx(0.001, abs=1e-9)
    assert score.bearing_rms_rad == pytest.approx(0.02, abs=1e-9)
    assert score.bearing_max_rad == pytest.approx(0.02, abs=1e-9)
    assert score.settled_at_s == pytest.approx(2.01, abs=0.011)
    assert score.v_max_mps == 0.55
    assert score.omega_max_radps == 0.7
    assert result.leader is not None
    assert result.leader.position_rms_m == pytest.approx(0.003, abs=1e-9)
    # bodies are closest before the shape grows, when settled: 0.201 + 0.05 - 0.075 behind
    assert result.min_clearance_m == pytest.approx(0.201 * cos(0.02) + D - 0.075, abs=2e-4)


def test_vision_against_truth_at_capture() -> None:
    vision = run().vision
    assert vision is not None
    assert vision.recall == 1.0
    assert vision.false_ids == 0
    assert vision.position_rms_m == pytest.approx(0.0004, rel=0.1)  # the step at 2 s costs a little
    assert vision.heading_rms_rad == pytest.approx(0.01, rel=1e-6)


def test_detections_half_a_side_away_are_false() -> None:
    vision = run(shift=0.04).vision
    assert vision is not None
    assert vision.recall == 0.0
    assert vision.false_ids == 2 * 124
    assert vision.position_rms_m is None


def test_a_stranger_in_a_robots_place_is_false_and_finds_nobody() -> None:
    there = (0.0, 0.0, 0.0, 0.0, 0.0), (0.5, 0.4, 0.0, 0.0, 0.0)
    for stranger, recall in ((9, 0.0), (2, 0.5)):
        sightings = Sightings((1, 2), CAMERA, 0.075)
        state = UnicycleState(*there[1])
        sightings.take(0.5, there, seen((RobotState(stranger, state),), 0.5, 0.0))
        score = sightings.score()
        assert score is not None
        assert (score.recall, score.false_ids) == (recall, int(stranger == 9))
        assert [s.frames for s in sightings.sighted()] == [0, int(stranger == 2)]


def test_counts_times_and_events() -> None:
    result = run()
    assert result.frames == 124
    assert result.commands_sent == 500
    assert result.duration_s == pytest.approx(4.99)
    assert [event.kind for event in result.safety_events] == ["robot-lost"]
    assert result.latency_ms is not None
    assert result.latency_ms.vision_p50 == pytest.approx(0.2)
    assert result.latency_ms.step_p99 == pytest.approx(0.5)
    assert result.latency_ms.frame_to_command_p50 == pytest.approx(0.6)


def test_how_old_frames_were_on_arrival_is_told_where_it_is_known() -> None:
    assert run().arrival is None
    scores, image = Scores(FORMATION, D, CAMERA, 0.075), np.zeros((4, 6, 3), np.uint8)
    scene = seen((), 0.0, 0.0)
    for n in range(100):
        t = 0.1 * n
        frame = as_frame(image, t, n, t_arrival=t + (0.09 if n == 7 else 0.03) if n > 1 else None)
        cycle = Cycle(t, t, "running", None, scene, (), (), None, (), ())
        scores.observe(Moment(Tick(t, frame), cycle, (), Timing(0.0, 0.0, 0.0)))
    arrival = scores.result("test", 1.0).arrival
    assert arrival is not None
    assert arrival.p50 == pytest.approx(30.0)
    assert 30.0 < arrival.p99 < 90.0
    assert "arrival" not in scores.result("test", 1.0).to_json()


def test_json_has_the_keys_of_the_contract() -> None:
    table = json.loads(json.dumps(run().to_json(), allow_nan=False))
    assert set(table) == {
        "scenario", "frames", "duration_s", "wall_s", "truth", "followers", "leader",
        "min_clearance_m", "vision", "latency_ms", "commands_sent", "safety_events", "notes",
        "seen",
    }  # fmt: skip
    assert set(table["followers"]["2"]) == {
        "leader", "distance_rms_m", "distance_max_m", "bearing_rms_rad", "bearing_max_rad",
        "settled_at_s", "v_max_mps", "omega_max_radps",
    }  # fmt: skip
    assert set(table["vision"]) == {"recall", "false_ids", "position_rms_m", "heading_rms_rad"}
    assert table["safety_events"][0]["robot_id"] == 2


def test_runs_without_mission_truth_or_cycles() -> None:
    waiting = run(start=None)
    assert waiting.leader is None
    assert waiting.followers[0].distance_rms_m is None
    assert waiting.followers[0].settled_at_s is None
    assert run(with_truth=False).vision is None
    empty = run(ticks=0)
    assert (empty.frames, empty.followers, empty.vision, empty.latency_ms) == (0, (), None, None)
    assert empty.min_clearance_m is None
    json.dumps(empty.to_json(), allow_nan=False)


def test_settling_is_judged_until_the_next_change() -> None:
    mission = np.arange(-5, 60) / 10.0
    shares = np.zeros((len(mission), 2))
    shares[mission < 1.95, 0] = 1.5
    shares[(mission > 4.0) & (mission < 4.5), 1] = 2.0
    assert settled_at(mission, shares, (4.0,)) == pytest.approx(2.0)
    assert settled_at(mission, shares, ()) == pytest.approx(4.5)
    assert settled_at(mission, shares, (1.5, 4.0)) is None
    shares[10] = np.nan
    assert settled_at(mission, shares, (0.7,)) is None


def test_of_two_distances_the_worse_counts() -> None:
    """The camera point of robot 3 stands 3 mm too near to robot 1 and 7 mm too far from robot 2."""
    count, times = 50, 0.1 * np.arange(50)
    poses = np.array([(0.0, 0.0, 0.0), (0.4, 0.0, 0.0), (0.2 - D, 0.1, 0.0)])
    motions = Motions((1, 2, 3), times, times, np.zeros((count, 3, 5)))
    motions.states[:, :, :3] = poses
    real = hypot(0.2, 0.1)
    pairs = [
        Pair(leader, 3, Shape(TanhStep.constant(real + off), None))
        for leader, off in ((1, 0.003), (2, -0.007))
    ]
    errors = np.stack([follower_errors(motions, pair, D) for pair in pairs])
    score = follower_score(motions, pairs, errors)
    assert score.leaders == (1, 2)
    assert score.distance_rms_m == pytest.approx(0.007)
    assert score.distance_max_m == pytest.approx(0.007)
    assert score.bearing_rms_rad is None
    assert score.settled_at_s == 0.0
