"""`echelon live` with real radios beside the simulated one: what is told at the end of a run."""

import re
import threading

import pytest

from pipeline.accounts import account
from pipeline.interruption import interruption
from pipeline.live import run
from pipeline.rigs import connect
from pipeline.scenario import load_scenario
from pipeline.setup import make_setup
from tests.hardware.firasim import FiraSim
from tests.hardware.miabot_robot import Miabot
from tests.hardware.miabot_tcp import TcpMiabot, free_port
from tests.pipeline.commands import echelon

pytestmark = pytest.mark.realtime

LINE = re.compile(
    r"robot (\d) on 127\.0\.0\.1:\d+: (\d+) messages sent, .* round trip (\d+\.\d) ms \(p50\), "
    r"(\d+\.\d) ms \(max\), 0\.0 % of \d+ questions unanswered"
)


def test_robots_that_call_the_host_are_driven_stopped_and_accounted_for() -> None:
    at = f"127.0.0.1:{free_port()}"
    robots = [Miabot(number) for number in (3, 1, 2)]
    ends = [TcpMiabot(robot, at) for robot in robots]
    try:
        done = echelon("live", "paper", "--radio", f"miabot-tcp-listen:{at}", "--duration", 2)
    finally:
        for end in ends:
            end.close()
    assert done.returncode == 0, done.stderr
    found = LINE.findall(done.stdout)
    assert [number for number, *_ in found] == ["1", "2", "3"]
    for robot in robots:
        sent = next(int(count) for number, count, *_ in found if int(number) == robot.number)
        assert len(robot.commands()) == sent > 50
        assert robot.received[0][1] == ".vTO=300"
        assert (robot.errors, robot.wheels) == (0, (0, 0))
        assert [text for _, text in robot.received].count("s") >= 3


def test_robots_in_firasim_stand_at_the_end() -> None:
    scenario = load_scenario("paper", ("radio.team=yellow", "radio.wheel_radius_m=0.02"))
    setup = make_setup(scenario)
    with FiraSim() as simulator, interruption() as interrupted:
        rig = connect(scenario, "rendered", f"firasim:{simulator.place}", 0, False, interrupted)
        run(setup, rig, setup.period, 1.5, interrupted)
        lines = account(rig)
        told = [told for told in simulator.told if told.left != 0.0]
        assert len(told) > 100
        assert {t.yellow for t in simulator.told} == {True}
        assert max(abs(t.left) for t in told) <= 2.0 / 0.02
        for number in (1, 2, 3):
            assert simulator.wheels(number, yellow=True) == (0.0, 0.0)
        assert simulator.errors == simulator.strangers == 0
    assert [line for line in lines if line.startswith("robot 1 on ")] == [
        line for line in lines if line.startswith(f"robot 1 on {simulator.place}: ")
    ]
    assert sum(line.startswith("robot ") for line in lines) == 3
    assert all(thread.name != simulator.place for thread in threading.enumerate())
