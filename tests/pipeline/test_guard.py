"""The safety rules: who is slowed, who stands, when motion resumes. Times in s."""

from dataclasses import replace

import numpy as np
import pytest

from control.formation import Formation, Pair, Shape
from control.profile import TanhStep
from datasets.cycle import SafetyEvent, Tick
from pipeline.guard import GuardMemory, SafetyRules, watch_over
from vision.frame import as_frame

RULES = SafetyRules(slow_after=0.2, stop_after=0.3, camera_silent=0.2, good_frames=1.0)
SHAPE = Shape(TanhStep.constant(0.2), TanhStep.constant(2.4))
CHAIN = Formation((Pair(1, 2, SHAPE), Pair(2, 3, SHAPE), Pair(1, 4, SHAPE)))
FRAME = as_frame(np.zeros((4, 4, 3), np.uint8), 0.0, 0)


def after(ages: dict[int, float], lost: tuple[int, ...] = ()) -> dict[int, float]:
    """Shares when robots were last seen so long ago."""
    tick = Tick(10.0, FRAME, lost)
    seen = {robot: 10.0 - age for robot, age in ages.items()}
    _, shares, _ = watch_over(RULES, GuardMemory(t_frame=9.97), CHAIN, seen, tick)
    return dict(shares)


def test_all_free_while_seen() -> None:
    assert after({1: 0.07, 2: 0.07, 3: 0.1, 4: 0.19}) == {1: 1.0, 2: 1.0, 3: 1.0, 4: 1.0}


def test_an_unseen_robot_and_its_followers_slow_down_then_stand() -> None:
    slowing = after({1: 0.05, 2: 0.25, 3: 0.05, 4: 0.05})
    assert slowing[2] == pytest.approx(0.5)
    assert slowing[3] == pytest.approx(0.5)
    assert slowing[1] == slowing[4] == 1.0
    assert after({1: 0.05, 2: 0.3, 3: 0.05, 4: 0.05}) == {1: 1.0, 2: 0.0, 3: 0.0, 4: 1.0}
    assert set(after({1: 0.31, 2: 0.0, 3: 0.0, 4: 0.0}).values()) == {0.0}


def test_a_robot_never_seen_or_without_link_stands() -> None:
    assert after({1: 0.05, 2: 0.05, 3: 0.05}) == {1: 1.0, 2: 1.0, 3: 1.0, 4: 0.0}
    assert after({1: 0.05, 2: 0.05, 3: 0.05, 4: 0.05}, lost=(2,)) == {1: 1, 2: 0, 3: 0, 4: 1}


def test_together_nobody_goes_on_without_another() -> None:
    lost, up = Tick(10.0, FRAME, (3,)), Tick(10.0, FRAME)
    seen, before = {1: 9.95, 2: 9.95, 3: 9.95, 4: 9.75}, GuardMemory(t_frame=9.97)
    together = replace(RULES, together=True)
    for rules, tick, shares in (
        (RULES, lost, [1.0, 1.0, 0.0, 0.5]),
        (together, lost, [0.0] * 4),
        (together, up, [0.5] * 4),
    ):
        _, after, events = watch_over(rules, before, CHAIN, seen, tick)
        assert [after[robot] for robot in (1, 2, 3, 4)] == pytest.approx(shares)
        assert {e.robot_id for e in events} == {r for r, share in after.items() if share == 0.0}
        why = {e.robot_id: e.detail for e in events}
        if tick is lost:
            assert why[3] == "its radio link is down"
            assert why.get(1, "another robot stands") == "another robot stands"
            assert why.get(4, "last seen 0.25 s ago") == "last seen 0.25 s ago"


def story(frames: list[float], until: float) -> tuple[dict[float, bool], list[SafetyEvent]]:
    """Whether the leader may move at every 10 ms, when frames arrive at the given times."""
    memory, moving, events = GuardMemory(), {}, []
    for k in range(round(until / 0.01)):
        t = 0.01 * k
        frame = FRAME if any(abs(t - f) < 1e-6 for f in frames) else None
        seen = dict.fromkeys((1, 2, 3, 4), t)
        memory, shares, new = watch_over(RULES, memory, CHAIN, seen, Tick(t, frame))
        moving[round(t, 2)] = shares[1] > 0.0
        events += new
    return moving, events


def test_a_silent_camera_stops_all_until_frames_are_steady_again() -> None:
    frames = [0.03 * k for k in range(10)] + [1.0 + 0.03 * k for k in range(60)]
    moving, events = story(frames, 2.5)
    assert moving[0.46]  # last frame at 0.27
    assert not moving[0.49]
    assert not moving[1.9]  # frames are back since 1.0
    assert moving[2.05]
    assert [e.kind for e in events] == ["camera-silent", "robot-stopped", "robot-stopped",
        "robot-stopped", "robot-stopped", "camera-back", "robot-free", "robot-free", "robot-free",
        "robot-free"]  # fmt: skip


def test_another_gap_starts_the_wait_again() -> None:
    frames = [0.0, *(0.5 + 0.03 * k for k in range(20)), *(1.6 + 0.03 * k for k in range(60))]
    moving, _ = story(frames, 3.2)
    assert not any(moving[round(0.01 * k, 2)] for k in range(22, 255))
    assert moving[2.7]
