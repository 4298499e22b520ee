"""Promises of docs/safety.md, each by the event itself: what befalls robots, links and cameras.

One run suffers several events, one after another. How fast the robots stood is printed (`-rP`).
"""

import signal
from collections.abc import Sequence
from itertools import pairwise
from math import isfinite
from pathlib import Path

import pytest

from tests.hardware.driven import Driven, Episode, Way, episodes, held, moves
from tests.hardware.ring import Truth
from tests.hardware.wall_clock import deluded

pytestmark = pytest.mark.realtime

CIRCLE = (  # about the middle of the picture, for as long as it takes
    "camera.center_m=[0.0, 0.5]", "leader.segments=[{ radius_m = 0.5, turn_deg = 3600 }]",
    "leader.speed_mps=0.15", "duration_s=60", "camera.latency_s=0.0035",
)  # fmt: skip
CHAIN = (  # 1 <- 3 <- 2
    *CIRCLE, "formation.pairs.2.leader=3", "formation.pairs.2.distance_m=0.2",
    "formation.pairs.3.distance_m=0.2",
)  # fmt: skip
STOP_AFTER, SILENT, GOOD = 0.3, 0.2, 1.0  # of [safety] [s]
WRITING = 0.1  # longest wait for a port that takes nothing [s]
OWN_TIMEOUT = 0.3  # of the robots [s]
BRAKING = 0.25  # motors that lag by 0.05 s, from 0.25 m/s to a standstill, and a frame [s]
SLACK = 0.15  # a frame, two processes and a pty on a machine that does other things [s]
NOTICED = 1.5  # that a robot answers no more: asked every 0.5 s, twice without an answer [s]
LASTS, RECOVERS = 0.9, 1.4  # an event, and the time until the next [s]
BURST = 0.02  # a robot that reads again has read all that had waited [s]
SET = 1.5  # how long a clock is wrong [s]


def told(truth: Truth) -> list[Episode]:
    """All episodes, which are also printed."""
    result = list(episodes(truth))
    print("\n" + "\n".join(map(str, result)))  # noqa: T201 (for the report of measured times)
    return result


def of(all_: Sequence[Episode], order: str) -> dict[int, Episode]:
    """One event, by robot."""
    return {e.robot: e for e in all_ if e.order == order}


def stood(one: Episode, promised: float) -> None:
    """It was told to stand, and stood, in time."""
    assert one.told < promised + SLACK, one
    assert one.stood < promised + BRAKING + SLACK, one


def drove(one: Episode) -> None:
    """It was told to move all the time."""
    assert one.told > one.end - one.begin - SLACK, one
    assert not isfinite(one.stood), one


def test_lost_robots_and_links_stop_whom_they_must_and_nobody_else(tmp_path: Path) -> None:
    events = ("cover 3", "uncover 3", "take 3", "put 3", "close 3", "open 3", "block 3",
              "unblock 3", "cover 1", "uncover 1")  # fmt: skip

    def _course(run: Driven) -> None:
        for order in events:
            run.suffer(order, RECOVERS if order.startswith(("un", "put", "open")) else LASTS)
        assert run.process.poll() is None
        run.end(signal.SIGINT)

    def _check(truth: Truth) -> None:
        all_ = told(truth)
        for order in ("cover 3", "take 3"):
            check_lost_robot(of(all_, order))
        greetings = truth["robots"][2]["greetings"]
        for order, notice in (("close 3", 0.0), ("block 3", WRITING)):
            check_lost_link(of(all_, order), notice, greetings)
        for one in of(all_, "cover 1").values():
            stood(one, STOP_AFTER)
            assert one.again < SLACK, one
        assert [robot["timeouts"] for robot in truth["robots"]] == [0, 0, 2]

    held(tmp_path, _course, _check, Way(CHAIN))


def check_lost_robot(by_robot: dict[int, Episode]) -> None:
    """Robot 3 was not seen."""
    drove(by_robot[1])
    for one in (by_robot[3], by_robot[2]):
        stood(one, STOP_AFTER)
        assert one.again < SLACK, one


def check_lost_link(by_robot: dict[int, Episode], notice: float, greetings: list[float]) -> None:
    """Robot 3 was not reached."""
    lost = by_robot[3]
    drove(by_robot[1])
    stood(by_robot[2], notice)
    assert lost.told < SLACK, lost
    assert lost.stood < OWN_TIMEOUT + BRAKING + SLACK, lost  # by itself
    assert lost.again < RECOVERS, lost
    greeted = min(t for t in greetings if t >= lost.end)
    assert lost.end + lost.again > greeted  # nothing that had waited in the port was said


def test_a_robot_that_reads_no_more_is_lost(tmp_path: Path) -> None:
    """Its port takes what it is sent all the same; behind what nobody can call back is a stop."""

    def _course(run: Driven) -> None:
        for order, seconds in (("deafen 3", NOTICED + LASTS), ("undeafen 3", 3.0)):
            run.suffer(order, seconds)
        assert "radio" in run.end(signal.SIGINT)

    def _check(truth: Truth) -> None:
        by_robot = of(told(truth), "deafen 3")
        drove(by_robot[1])
        stood(by_robot[2], NOTICED)
        lost = by_robot[3]
        assert lost.stood < OWN_TIMEOUT + BRAKING + SLACK, lost  # by itself
        assert lost.again < 3.0, lost
        stop = min(t for t in truth["robots"][2]["stops"] if t >= lost.end)
        assert stop < lost.end + BURST
        assert not [t for t in moves(truth["robots"][2]) if stop < t < stop + BURST]

    held(tmp_path, _course, _check, Way(CHAIN))


def test_a_camera_that_freezes_or_goes_stops_all_until_it_is_good_again(tmp_path: Path) -> None:
    lasts = {"freeze": LASTS, "thaw": 2.0, "unplug": LASTS, "plug": 3.5}
    said = list[str]()

    def _course(run: Driven) -> None:
        for order, seconds in lasts.items():
            run.suffer(order, seconds)
        said.append(run.end(signal.SIGINT))

    def _check(truth: Truth) -> None:
        assert said[-1].count("running -> holding (no frame for 0.2 s") == 2
        assert "it is opened again" in said[-1]
        for one in told(truth):
            stood(one, SILENT)
            assert one.again > GOOD - SLACK, one
            assert one.again < (GOOD + SLACK if one.order == "freeze" else 3.5), one
        assert [robot["timeouts"] for robot in truth["robots"]] == [0, 0, 0]  # zeros were sent

    held(tmp_path, _course, _check, Way(CIRCLE))


def test_clocks_that_are_set_change_nothing(tmp_path: Path) -> None:
    """Of the machine, every second by hours, and of the camera, which restarts."""
    way = Way((*CIRCLE, "camera.latency_s=0.036"), "udp", environment=deluded(tmp_path))

    def _course(run: Driven) -> None:
        for order in ("jump 60", "jump 0"):
            run.suffer(order, SET + 0.1)
        run.end(signal.SIGINT)

    def _check(truth: Truth) -> None:
        begin = told(truth)[0].begin
        for robot in truth["robots"]:
            moved = [t for t in moves(robot) if begin - SLACK < t < begin + 2 * SET]
            assert max(b - a for a, b in pairwise(moved)) < SLACK
            assert moved[-1] > begin + 2 * SET - SLACK

    held(tmp_path, _course, _check, way)
    if not way.environment:
        pytest.skip("without a C compiler the machine's clock was left alone")
