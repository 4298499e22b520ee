"""The emulated Miabot does what the robot's description says; our sender is not asked."""

import pytest

from tests.hardware.miabot_robot import Miabot


def test_replies() -> None:
    robot = Miabot(number=1)
    assert robot.receive(b"[t]", 0.0) == b"<test#01>"
    assert robot.receive(b"[Q]", 0.0).startswith(b"<")
    assert robot.receive(b"[=100,-100][s]", 0.0) == b""


def test_encoders_count_ticks_of_the_way_rolled() -> None:
    robot = Miabot(speed_scale=500.0)
    robot.receive(b"[;0,0][:=100][=250,-125]", 0.0)
    assert robot.wake(0.0) == b"<: +0000000000:+0000000000>"
    assert robot.wake(0.05) == b""
    assert robot.wake(2.0) == b"<: +0000025000:-0000012500>"  # 1 m and -0.5 m
    robot.receive(b"[;0,0][s]", 2.0)
    assert robot.wake(3.0) == b"<: +0000000000:+0000000000>"


def test_its_own_timeout_is_off_by_default() -> None:
    robot = Miabot()
    robot.receive(b"[=100,100]", 0.0)
    robot.wake(1000.0)
    assert robot.wheels == (100, 100)
    robot.receive(b"[.vTO=300][=100,100]", 1000.0)
    robot.wake(1000.29)
    assert robot.wheels == (100, 100)
    robot.wake(1000.31)
    assert (robot.wheels, robot.timeouts) == ((0, 0), 1)


def test_wheels_take_whole_units_up_to_full_scale_and_turn_as_told() -> None:
    told: list[tuple[float, float, float]] = []
    robot = Miabot(speed_scale=800.0, drive=lambda *change: told.append(change))
    robot.receive(b"[=400,-80][=2000,-2000][s]", 1.0)
    assert told == [(0.5, -0.1, 1.0), (1.25, -1.25, 1.0), (0.0, 0.0, 1.0)]


@pytest.mark.parametrize(
    "junk", [b"[=1.5,2]", b"[=1]", b"[x]", b"[=10[s]", b"[" + b"9" * 99, b"]]"]
)
def test_what_it_does_not_understand_changes_nothing(junk: bytes) -> None:
    robot = Miabot()
    robot.receive(junk, 0.0)
    assert robot.wheels == (0, 0)
    assert robot.errors == (junk != b"]]")
    robot.receive(b"[=7,8]", 0.0)
    assert robot.wheels == (7, 8)
