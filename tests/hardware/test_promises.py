"""Promises of docs/safety.md, each by the event itself: a streamed camera, Miabots on ptys."""

import json
import os
import signal
import subprocess
from collections.abc import Callable
from pathlib import Path
from time import monotonic, sleep
from typing import Any

import pytest

from tests.hardware.ring import ROOT, Ring, ring
from tests.pipeline.commands import ECHELON

pytestmark = pytest.mark.realtime

UNDER_WAY = 1.2  # from the first command to the event [s]
PERIOD = 0.015  # between commands, of a Miabot's link [s]
ON_ITS_WAY = 0.05  # a signal, two processes and a pty on a machine that does other things [s]
OWN_TIMEOUT = 0.3  # of the robots [s]

Truth = dict[str, Any]


class Driven:
    """A run under way, and what its robots were told."""

    def __init__(self, outside: Ring, *options: object) -> None:
        self.outside = outside
        command = (*ECHELON, "live", "paper", "--camera", outside.url, "--radio", outside.radio)
        self.process = subprocess.Popen(
            (*command, *map(str, options), "--duration", "60", "--json",
             "--set", "leader.speed_mps=0.3", "--set", "duration_s=60"),
            cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
            env={**os.environ, "PYTHONUNBUFFERED": "1"},
        )  # fmt: skip

    def truth(self) -> Truth:
        """What has happened so far."""
        before = self._written()
        self.outside.process.send_signal(signal.SIGUSR1)
        end = monotonic() + 10.0
        while (text := self._written()) == before or not text:
            assert monotonic() < end
            sleep(0.02)
        truth: Truth = json.loads(text)
        return truth

    def under_way(self) -> None:
        """Wait until the robots drive."""
        end = monotonic() + 60.0
        while not any(nonzero(robot) for robot in self.truth()["robots"]):
            assert self.process.poll() is None, self.process.communicate()[1]
            assert monotonic() < end
            sleep(0.1)
        sleep(UNDER_WAY)

    def send(self, number: int) -> float:
        """Send a signal; when, on the machine's clock [s]."""
        t = monotonic()
        self.process.send_signal(number)
        return t

    def end(self, number: int) -> str:
        """End it by a signal; what it said."""
        self.process.send_signal(number)
        return self.process.communicate(timeout=30.0)[1]

    def _written(self) -> str:
        """The whole truth file; empty while it is being written."""
        text = self.outside.truth_file.read_text() if self.outside.truth_file.exists() else ""
        return text if text.endswith("}") and text.count("{") == text.count("}") else ""


def nonzero(robot: Truth) -> list[float]:
    """When a robot was told to move."""
    return [t for t, left, right in robot["commands"] if (left, right) != (0, 0)]


def driven(folder: Path, course: Callable[[Driven], None], *options: object) -> Truth:
    """Let a run drive, let something happen to it, and say what was true at the end."""
    with ring(folder) as outside:
        run = Driven(outside, *options)
        try:
            run.under_way()
            course(run)
        finally:
            run.process.kill()
            run.process.wait(10.0)
        return outside.finish()


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
        moves = nonzero(robot)
        assert not [t for t in moves if halt + PERIOD + ON_ITS_WAY < t < arm]
        assert [t for t in robot["stops"] if halt < t < halt + PERIOD + ON_ITS_WAY]
        assert [t for t in moves if t < halt]
        assert [t for t in moves if arm < t < arm + 1.0]
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
        moves = nonzero(robot)
        assert not [t for t in moves if stalled + ON_ITS_WAY < t < awake + 0.9]
        assert [t for t in moves if t > awake + 0.9]  # after 1 s of good frames it goes on


def test_a_host_that_dies_leaves_robots_that_stop_by_themselves(tmp_path: Path) -> None:
    def _course(run: Driven) -> None:
        run.send(signal.SIGKILL)
        sleep(OWN_TIMEOUT + 0.3)

    truth = driven(tmp_path, _course)
    for robot in truth["robots"]:
        assert robot["timeout_s"] == OWN_TIMEOUT
        assert (robot["timeouts"], robot["wheels"]) == (1, [0, 0])
    last = max(t for robot in truth["robots"] for t in nonzero(robot))
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
