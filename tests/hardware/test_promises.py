"""Promises of docs/safety.md, each by the event itself: a streamed camera, Miabots on ptys."""

import signal
from pathlib import Path
from time import sleep

import pytest

from tests.hardware.driven import Driven, driven, moves

pytestmark = pytest.mark.realtime

PERIOD = 0.015  # between commands, of a Miabot's link [s]
ON_ITS_WAY = 0.05  # a signal, two processes and a pty on a machine that does other things [s]
OWN_TIMEOUT = 0.3  # of the robots [s]


def test_an_emergency_stop_stops_all_and_lasts_until_it_is_armed(tmp_path: Path) -> None:
    at = list[float]()

    def _course(run: Driven) -> None:
        at.append(run.send(signal.SIGUSR1))
        sleep(1.0)
        at.append(run.send(signal.SIGUSR2))
        sleep(1.0)
        said = run.end(signal.SIGINT)
        assert run.process.returncode == 130
        assert "running -> stopped" in said
        assert "stopped -> running" in said

    truth = driven(tmp_path, _course)
    halt, arm = (t - truth["origin_monotonic_s"] for t in at)
    for robot in truth["robots"]:
        moved = moves(robot)
        assert not [t for t in moved if halt + PERIOD + ON_ITS_WAY < t < arm]
        assert [t for t in robot["stops"] if halt < t < halt + PERIOD + ON_ITS_WAY]
        assert [t for t in moved if t < halt]
        assert [t for t in moved if arm < t < arm + 1.0]
        assert robot["timeouts"] == 0  # zeros were sent: no robot had to stop by itself


def test_a_host_that_stalls_sends_nothing_stale_and_looks_first(tmp_path: Path) -> None:
    at = list[float]()

    def _course(run: Driven) -> None:
        at.append(run.send(signal.SIGSTOP))
        sleep(1.0)
        at.append(run.send(signal.SIGCONT))
        sleep(2.5)
        run.end(signal.SIGINT)

    truth = driven(tmp_path, _course)
    stalled, awake = (t - truth["origin_monotonic_s"] for t in at)
    for robot in truth["robots"]:
        assert robot["timeouts"] == 1  # it stopped by itself
        moved = moves(robot)
        assert not [t for t in moved if stalled + ON_ITS_WAY < t < awake + 0.9]
        assert [t for t in moved if t > awake + 0.9]  # after 1 s of good frames it goes on


def test_a_host_that_dies_leaves_robots_that_stop_by_themselves(tmp_path: Path) -> None:
    def _course(run: Driven) -> None:
        run.send(signal.SIGKILL)
        sleep(OWN_TIMEOUT + 0.3)

    truth = driven(tmp_path, _course)
    for robot in truth["robots"]:
        assert robot["timeout_s"] == OWN_TIMEOUT
        assert (robot["timeouts"], robot["wheels"]) == (1, [0, 0])
    last = max(t for robot in truth["robots"] for t in moves(robot))
    late = [f for f in truth["frames"] if f["t"] > last + OWN_TIMEOUT + 0.25]
    assert late
    assert all(abs(robot["v_mps"]) < 0.02 for frame in late for robot in frame["robots"])


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_a_terminated_host_stops_its_robots_three_times(number: int, tmp_path: Path) -> None:
    def _course(run: Driven) -> None:
        run.end(number)
        assert run.process.returncode == 130

    truth = driven(tmp_path, _course)
    for robot in truth["robots"]:
        last = max(t for t, *_ in robot["commands"])
        assert len([t for t in robot["stops"] if t > last]) >= 3
        assert (robot["timeouts"], robot["wheels"]) == (0, [0, 0])
