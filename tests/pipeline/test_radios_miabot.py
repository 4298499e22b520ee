"""Miabots on real ptys: what the robot understood, what happens when the line breaks or blocks."""

import os
import time
import tty
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from control.command import Command
from control.unicycle import Twist
from pipeline.errors import RadioError
from pipeline.radios.miabot import MiabotRadio
from pipeline.radios.miabot_line import MiabotPort, MiabotSettings
from tests.hardware.miabot_robot import Miabot
from tests.hardware.ptys import Ptys
from tests.pipeline.radios import CLOCK, command, until

pytestmark = pytest.mark.realtime

DEFAULTS = MiabotSettings()


@contextmanager
def connected(paths: list[str], settings: MiabotSettings = DEFAULTS) -> Iterator[MiabotRadio]:
    ports = tuple(MiabotPort(number, path) for number, path in enumerate(paths, 1))
    radio = MiabotRadio(ports, settings, CLOCK)
    try:
        yield radio
    finally:
        radio.close()


@contextmanager
def deaf_port() -> Iterator[tuple[int, str]]:
    """A pty whose far end never reads."""
    master, slave = os.openpty()
    tty.setraw(slave)
    try:
        yield master, os.ttyname(slave)
    finally:
        os.close(master)
        os.close(slave)


def test_the_robots_own_timeout_is_set_before_anything_else_and_stops_come_three_times() -> None:
    robots = [Miabot(1), Miabot(2)]
    with Ptys(robots, CLOCK.now) as ptys:
        with connected(ptys.paths) as radio:
            assert radio.send((command(1, 0.1, 1.0), command(2, -0.2)), CLOCK.now()) == ()
            assert until(lambda: all(robot.commands() for robot in robots))
            radio.stop(CLOCK.now())
            assert until(lambda: [text for _, text in robots[0].received].count("s") == 3)
        for robot in robots:
            assert robot.received[0][1] == ".vTO=300"
            assert robot.timeout == 0.3
            assert robot.wheels == (0, 0)
            assert robot.errors == 0
    assert robots[0].commands()[0][1:] == (66, 134)
    assert robots[1].commands()[0][1:] == (-200, -200)


def test_a_flood_of_commands_keeps_the_budget_and_the_newest_wins() -> None:
    robot = Miabot()
    with Ptys([robot], CLOCK.now) as ptys, connected(ptys.paths) as radio:
        start = CLOCK.now()
        for n in range(500):
            radio.send((command(v=n / 1000.0),), CLOCK.now())
            time.sleep(0.001)
        assert until(lambda: robot.commands() and robot.commands()[-1][1:] == (499, 499))
        heard = robot.commands()
        spent = sum(len(f"[={left},{right}]") for _, left, right in heard[:-1])
        assert spent <= 1150 * (CLOCK.now() - start)
        assert len(heard) > 20  # 11 bytes at 1150 B/s: at most one in 10 ms, and never idle
        order = [left for _, left, _ in heard]
        assert order == sorted(order)
        assert radio.reports[0].counts.sent == len(heard)
        assert radio.reports[0].counts.sent + radio.reports[0].counts.replaced == 500
        assert radio.min_period == pytest.approx(14 / 1150)


def test_what_is_stale_or_not_finite_never_reaches_the_robot() -> None:
    robot = Miabot()
    with Ptys([robot], CLOCK.now) as ptys, connected(ptys.paths) as radio:
        now = CLOCK.now()
        for twist, valid in ((Twist(float("nan"), 0.0), 1.0), (Twist(0.0, float("inf")), 1.0)):
            radio.send((Command(1, twist, now, now + valid),), now)
        radio.send((Command(1, Twist(0.1, 0.0), now, now - 0.001),), now)
        radio.send((Command(1, Twist(0.1, 0.0), now, float("nan")),), now)
        assert (radio.screen.refused, radio.screen.stale) == (2, 2)
        radio.send((Command(1, Twist(0.2, 0.0), now, now + 0.1),), now)
        assert until(robot.commands)
        # Behind a message of 11 bytes the line is busy for 9 ms: this one goes stale waiting.
        now = CLOCK.now()
        radio.send((Command(1, Twist(0.3, 0.0), now, now + 0.1),), now)
        radio.send((Command(1, Twist(0.4, 0.0), now, now + 0.001),), now)
        time.sleep(0.05)
    assert {left for _, left, _ in robot.commands()} <= {200, 300}
    counts = radio.reports[0].counts
    assert counts.stale + counts.replaced + radio.screen.stale - 2 >= 1


def test_a_robot_without_port_is_lost() -> None:
    with Ptys([Miabot()]) as ptys, connected(ptys.paths) as radio:
        assert radio.send((command(1), command(7)), CLOCK.now()) == (7,)
        assert radio.unknown == 1


def test_who_are_you_and_encoders() -> None:
    robot = Miabot(5)
    settings = MiabotSettings(ask_who=True, encoder_period_ms=10)
    with Ptys([robot], CLOCK.now) as ptys, connected(ptys.paths, settings) as radio:
        assert [text for _, text in robot.received] == [".vTO=300", "t", ":=10"] or until(
            lambda: len(robot.received) == 3
        )
        assert until(lambda: radio.send((command(v=0.5),), CLOCK.now()) == () and far(radio, 1000))
        encoders = radio.reports[0].encoders
        assert encoders is not None
        assert encoders.left == encoders.right
        assert radio.reports[0].garbage == 0


def far(radio: MiabotRadio, ticks: int) -> bool:
    encoders = radio.reports[0].encoders
    return encoders is not None and encoders.left > ticks


def test_nobody_answers_who_are_you() -> None:
    with deaf_port() as (_, path), pytest.raises(RadioError, match=f"{path}: no Miabot answers"):
        MiabotRadio((MiabotPort(1, path),), MiabotSettings(ask_who=True), CLOCK)


def test_a_missing_port_is_one_clear_line_and_the_others_are_released() -> None:
    robot = Miabot()
    with Ptys([robot]) as ptys:
        ports = (MiabotPort(1, ptys.paths[0]), MiabotPort(2, "/dev/rfcomm77"))
        with pytest.raises(RadioError) as caught:
            MiabotRadio(ports, MiabotSettings(), CLOCK)
        assert str(caught.value) == ("radio /dev/rfcomm77: cannot open: No such file or directory")
        with connected(ptys.paths):  # not locked any more
            pass


def test_a_port_in_use_says_so() -> None:
    busy = pytest.raises(RadioError, match="another program uses it")
    with Ptys([Miabot()]) as ptys, connected(ptys.paths), busy:
        MiabotRadio((MiabotPort(1, ptys.paths[0]),), MiabotSettings(), CLOCK)


def test_ten_megabytes_of_garbage_do_not_hold_up_commands() -> None:
    with deaf_port() as (master, path), connected([path]) as radio:
        os.set_blocking(master, False)
        left, heard, slowest = 10_000_000, b"", 0.0
        while left:
            try:
                left -= os.write(master, b"z" * min(left, 4096))
            except BlockingIOError:
                time.sleep(0.0005)
            before = CLOCK.now()
            assert radio.send((command(),), before) == ()
            slowest = max(slowest, CLOCK.now() - before)
            try:
                heard += os.read(master, 4096)
            except BlockingIOError:
                continue
        os.write(master, b"<: +0000000001:+0000000002>")
        assert until(lambda: radio.reports[0].encoders)
        assert radio.reports[0].garbage == 10_000_000
        assert heard.count(b"[=100,100]") > 5
        assert radio.reports[0].up


def test_half_a_line_of_the_robots_is_finished_later() -> None:
    with deaf_port() as (master, path), connected([path]) as radio:
        os.write(master, b"<: +00000")
        time.sleep(0.05)
        assert radio.reports[0].encoders is None
        os.write(master, b"00001:+0000000002>")
        assert until(lambda: radio.reports[0].encoders)


def test_a_port_that_closes_loses_that_robot_only_and_comes_back(
    tmp_path: os.PathLike[str],
) -> None:
    link = os.path.join(tmp_path, "robot1")
    with Ptys([Miabot(2)]) as other:
        first = Ptys([Miabot()])
        os.symlink(first.paths[0], link)
        with connected([link, other.paths[0]]) as radio:
            first.close()
            assert until(lambda: radio.send((command(1), command(2)), CLOCK.now()) == (1,))
            assert "robot1" in str(radio.reports[0].error)
            os.unlink(link)
            robot = Miabot()
            with Ptys([robot], CLOCK.now) as again:
                os.symlink(again.paths[0], link)
                assert until(lambda: radio.send((command(1),), CLOCK.now()) == ())
                assert until(robot.commands)
                assert robot.received[0][1] == ".vTO=300"
                assert radio.reports[0].counts.connects == 2
                assert radio.reports[1].counts.failures == 0


def test_a_blocked_port_is_lost_and_neither_stop_nor_close_hangs() -> None:
    robot = Miabot()
    settings = MiabotSettings(bytes_per_second=1e9)
    with deaf_port() as (_, blocked), Ptys([robot], CLOCK.now) as ptys:
        slave = os.open(blocked, os.O_RDWR | os.O_NONBLOCK | os.O_NOCTTY)
        with connected([ptys.paths[0], blocked], settings) as radio:
            fill(slave)
            assert until(lambda: radio.send((command(1), command(2)), CLOCK.now()) == (2,), 10.0)
            fill(slave)
            start = CLOCK.now()
            radio.stop(start)
            stopped = CLOCK.now()
            radio.close()
            closed = CLOCK.now()
        os.close(slave)
    assert stopped - start < 0.9  # promised: about a second at most, whatever the ports do
    assert closed - stopped < 1.5
    assert [text for _, text in robot.received].count("s") >= 3


def test_a_robot_that_answers_no_longer_is_lost_and_told_to_stand() -> None:
    robot = Miabot()

    def _sent() -> tuple[int | str, ...]:
        return radio.send((command(v=0.2),), CLOCK.now())

    with Ptys([robot], CLOCK.now) as ptys, connected(ptys.paths) as radio:
        assert until(lambda: _sent() == () and radio.reports[0].round_trip.p50)
        ptys.deafen(0, full=False)
        deaf = CLOCK.now()
        assert until(_sent)
        assert CLOCK.now() - deaf < 1.8  # two questions of 0.5 s, the first within 0.5 s
        assert "the robot answers no longer" in str(radio.reports[0].error)
        assert not until(lambda: radio.reports[0].up, 2.5)  # it must answer first
        ptys.listen(0)
        assert until(lambda: radio.reports[0].up)
        assert robot.wheels == (0, 0)
        heard = len(robot.commands())
        assert until(lambda: _sent() == () and len(robot.commands()) > heard)


def fill(slave: int) -> int:
    """Write until nothing more fits, also after the kernel has moved what it can."""
    written, stuck = 0, 0
    while stuck < 10:
        try:
            written += os.write(slave, b"[=1,1]" * 100)
            stuck = 0
        except BlockingIOError:
            stuck += 1
            time.sleep(0.005)
    return written


def drain(master: int) -> bytes:
    os.set_blocking(master, False)
    data = b""
    try:
        while True:
            data += os.read(master, 4096)
    except BlockingIOError:
        return data


def test_stop_reaches_a_robot_behind_a_line_full_of_stale_commands() -> None:
    """The port takes nothing more: what waits in it is thrown away, and the stop goes through."""
    with deaf_port() as (master, path), connected([path]) as radio:
        slave = os.open(path, os.O_RDWR | os.O_NONBLOCK | os.O_NOCTTY)
        full = fill(slave)
        radio.stop(CLOCK.now())
        os.close(slave)
        waiting = drain(master)
        assert b"[s]" in waiting
        # The far end of a pty has already taken 4 kB in; a radio's buffer would be empty.
        assert len(waiting) < min(full, 4200)


def test_the_robot_stops_itself_when_commands_cease() -> None:
    robot = Miabot()
    settings = MiabotSettings(timeout_ms=100)
    with Ptys([robot], CLOCK.now) as ptys, connected(ptys.paths, settings) as radio:
        radio.send((command(),), CLOCK.now())
        assert until(lambda: robot.commands())
        assert until(lambda: robot.timeouts == 1)
        assert robot.wheels == (0, 0)
