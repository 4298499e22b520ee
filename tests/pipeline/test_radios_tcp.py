"""Miabots that listen on TCP: greeting, stop, broken, deaf and wrong robots, round trips."""

import socket
import time

import pytest

from pipeline.accounts import link_reports
from pipeline.errors import RadioError
from pipeline.ports import CommandSink
from pipeline.radios.open import RadioSettings, open_radio
from pipeline.radios.tcp import TcpLink
from tests.hardware.miabot_robot import Miabot
from tests.hardware.miabot_tcp import TcpMiabot
from tests.pipeline.radios import CLOCK, command, kept_sending, opened, until

pytestmark = pytest.mark.realtime


def spec_of(*robots: TcpMiabot) -> str:
    return "miabot-tcp:" + ",".join(f"{r.robot.number}={r.place}" for r in robots)


def asked(radio: CommandSink) -> int:
    trip = link_reports(radio)[0].round_trip
    return trip.asked if trip else 0


def test_the_robots_own_timeout_comes_first_commands_arrive_and_stops_come_three_times() -> None:
    one, two = Miabot(1), Miabot(2)
    with TcpMiabot(one, clock=CLOCK.now) as first, TcpMiabot(two, clock=CLOCK.now) as second:
        with opened(spec_of(first, second), 1, 2) as radio:
            assert radio.send((command(1, 0.1, 1.0), command(2, -0.2)), CLOCK.now()) == ()
            assert until(lambda: one.commands() and two.commands())
            assert (one.commands()[0][1:], two.commands()[0][1:]) == ((66, 134), (-200, -200))
        for robot in (one, two):
            assert [text for _, text in robot.received[:2]] == [".vTO=300", "t"]
            assert until(lambda robot=robot: [t for _, t in robot.received].count("s") >= 3)
            assert (robot.wheels, robot.errors, robot.timeout) == ((0, 0), 0, 0.3)


def test_a_robot_that_is_cut_off_is_lost_alone_and_greeted_again() -> None:
    one, two = Miabot(1), Miabot(2)
    with TcpMiabot(one, clock=CLOCK.now) as first, TcpMiabot(two, clock=CLOCK.now) as second:
        with opened(spec_of(first, second), 1, 2) as radio:
            first.cut()
            assert until(lambda: radio.send((command(1), command(2)), CLOCK.now()) == (1,))
            assert until(lambda: radio.send((command(1), command(2)), CLOCK.now()) == ())
        greetings = [text for _, text in one.received if text.startswith(".vTO")]
        assert greetings == [".vTO=300"] * 2
        assert [text for _, text in two.received].count(".vTO=300") == 1


def test_a_port_that_opens_and_never_answers_is_told_within_a_bounded_time() -> None:
    with TcpMiabot(Miabot(1)) as robot:
        robot.deaf = True
        start = time.monotonic()
        with pytest.raises(RadioError, match=f"{robot.place}: no Miabot answers within 1 s"):
            open_radio(spec_of(robot), CLOCK, RadioSettings(), (1,))
        assert time.monotonic() - start < 3.0


def test_another_robot_at_the_address_is_refused() -> None:
    with TcpMiabot(Miabot(7)) as robot:
        with pytest.raises(RadioError, match="robot 7 answers, not robot 1"):
            open_radio(f"miabot-tcp:1={robot.place}", CLOCK, RadioSettings(), (1,))
        assert until(lambda: robot.robot.wheels == (0, 0))


def test_round_trips_are_measured_and_silence_is_counted() -> None:
    robot = Miabot(1)
    with TcpMiabot(robot, clock=CLOCK.now) as end, opened(spec_of(end), 1) as radio:
        assert kept_sending(radio, 1.5, 1) == set()
        (report,) = link_reports(radio)
        trip = report.round_trip
        assert trip is not None
        assert trip.p50 is not None
        assert trip.longest is not None
        assert 0.0 < trip.p50 <= trip.longest < 0.5  # s; loopback and 2 ms between two looks
        assert (trip.asked, trip.loss) == (3, 0.0)
        end.deaf = True
        kept_sending(radio, 2.5, 1)
        after = link_reports(radio)[0].round_trip
        assert after is not None
        assert after.unanswered >= 1
        assert after.loss == after.unanswered / after.asked
        end.deaf = False


def test_no_question_keeps_a_robot_alive_whose_commands_have_ceased() -> None:
    robot = Miabot(1)
    with TcpMiabot(robot, clock=CLOCK.now) as end, opened(spec_of(end), 1) as radio:
        radio.send((command(),), CLOCK.now())
        assert until(robot.commands)
        told = CLOCK.now()
        assert until(lambda: robot.timeouts == 1, 2.0)
        time.sleep(1.5)
        asked = [t for t, text in robot.received if text == "t" and t > told + 0.1]
        assert asked == []
        radio.stop(CLOCK.now())  # told to stand it may be asked again
        assert until(lambda: robot.received[-1][1] == "t", 2.0)


def test_replies_of_another_robot_and_garbage_are_counted() -> None:
    robot = Miabot(1)
    with TcpMiabot(robot, clock=CLOCK.now) as end, opened(spec_of(end), 1) as radio:
        assert until(lambda: asked(radio) == 1)  # so that no answer comes between the halves
        end.say(b"<test#42>rubbish<test#42><: +00")
        assert until(lambda: link_reports(radio)[0].foreign == 2)
        end.say(b"00000001:+0000000002>")
        assert until(lambda: link_reports(radio)[0].encoders)
        end.say(b"<what is this>")
        assert until(lambda: link_reports(radio)[0].garbage == len("rubbish<what is this>"))
        assert radio.send((command(),), CLOCK.now()) == ()


def test_a_robot_that_takes_nothing_more_is_given_up_before_what_waits_is_old() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        server.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2048)
        link = TcpLink(socket.create_connection(server.getsockname()), "there")
        end, start = server.accept()[0], time.monotonic()
        with pytest.raises(RadioError, match=r"there: confirms nothing for 0\.5 s"):  # noqa: PT012
            while time.monotonic() < start + 20.0:
                link.write(b"[=-500,-500]" * 100)
                time.sleep(0.02)
        before = time.monotonic()
        link.close()
        assert time.monotonic() - before < 0.5
        assert was_reset(end)  # what waited was dropped: it would have arrived late
        end.close()


def was_reset(end: socket.socket) -> bool:
    """Whether the other side broke off instead of ending."""
    try:
        while end.recv(65_536):
            pass
    except ConnectionResetError:
        return True
    return False
