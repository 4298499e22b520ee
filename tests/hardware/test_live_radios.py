"""`echelon live` with real radios beside the simulated one: what is told at the end of a run."""

import threading

import pytest

from pipeline.accounts import link_reports
from pipeline.interruption import interruption
from pipeline.links import link_rows
from pipeline.live import run
from pipeline.readiness import ready_to_drive
from pipeline.rigs import connect
from pipeline.scenario import load_scenario
from pipeline.setup import make_setup
from tests.hardware.firasim import FiraSim
from tests.hardware.miabot_robot import Miabot
from tests.hardware.miabot_tcp import TcpMiabot, free_port
from tests.pipeline.commands import echelon_process

pytestmark = pytest.mark.realtime


def test_robots_that_call_the_host_are_driven_stopped_and_accounted_for() -> None:
    at = f"127.0.0.1:{free_port()}"
    robots = [Miabot(number) for number in (3, 1, 2)]
    ends = [TcpMiabot(robot, at) for robot in robots]
    try:
        done = echelon_process(
            "live", "paper", "--radio", f"miabot-tcp-listen:{at}", "--duration", 2
        )
    finally:
        for end in ends:
            end.close()
    assert done.returncode == 0, done.stderr
    lines = [line.split() for line in done.stdout.splitlines()]
    rows = lines[lines.index(["Links"]) + 2 :][:3]
    assert [row[0] for row in rows] == ["1", "2", "3"]
    for robot in robots:
        asked, carried, *counts, trip, most, unanswered = map(float, rows[robot.number - 1][2:])
        assert counts[2:] == [0.0, 0.0, 0.0]
        assert 0.0 < trip <= most
        assert unanswered == 0.0
        assert 0.9 * asked < carried <= asked
        assert len(robot.commands()) == pytest.approx(2.0 * carried, rel=0.15)
        assert robot.received[0][1] == ".vTO=300"
        assert (robot.errors, robot.wheels) == (0, (0, 0))
        assert [text for _, text in robot.received].count("s") >= 3


def test_robots_in_firasim_stand_at_the_end() -> None:
    scenario = load_scenario("paper", ("radio.team=yellow", "radio.wheel_radius_m=0.02"))
    setup = make_setup(scenario, ready_to_drive(scenario))
    with FiraSim() as simulator, interruption() as interrupted:
        rig = connect(scenario, "rendered", f"firasim:{simulator.place}", 0, False, interrupted)
        run(setup, rig, setup.period, 1.5, interrupted)
        rows = link_rows(link_reports(rig.sink), {}, 0.0)
        told = [told for told in simulator.told if told.left != 0.0]
        assert len(told) > 100
        assert {t.yellow for t in simulator.told} == {True}
        assert max(abs(t.left) for t in told) <= 2.0 / 0.02
        for number in (1, 2, 3):
            assert simulator.wheels(number, yellow=True) == (0.0, 0.0)
        assert simulator.errors == simulator.strangers == 0
    assert [(row.robot_id, row.place) for row in rows] == [(n, simulator.place) for n in (1, 2, 3)]
    assert all(thread.name != simulator.place for thread in threading.enumerate())
