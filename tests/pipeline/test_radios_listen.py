"""Miabots that call the host: who is let in, who is refused, who replaces whom, who is missing."""

import socket
import threading
import time

import pytest

from pipeline.accounts import link_reports
from pipeline.errors import RadioError
from pipeline.radios.open import RadioSettings, open_radio
from tests.hardware.miabot_robot import Miabot
from tests.hardware.miabot_tcp import TcpMiabot, free_port
from tests.pipeline.radios import CLOCK, command, kept_sending, opened, until

pytestmark = pytest.mark.realtime


def place() -> str:
    return f"127.0.0.1:{free_port()}"


def count(robot: Miabot, text: str) -> int:
    return [told for _, told in robot.received].count(text)


def test_robots_are_matched_by_their_answer_in_whatever_order_they_call() -> None:
    at, one, two = place(), Miabot(1), Miabot(2)
    with TcpMiabot(two, at, CLOCK.now), TcpMiabot(one, at, CLOCK.now):
        with opened(f"miabot-tcp-listen:{at}", 1, 2) as radio:
            assert radio.send((command(1, 0.1), command(2, 0.3)), CLOCK.now()) == ()
            assert until(lambda: one.commands() and two.commands())
        assert one.commands()[0][1:] == (100, 100)
        assert two.commands()[0][1:] == (300, 300)
        for robot in (one, two):
            assert [told for _, told in robot.received[:2]] == [".vTO=300", "t"]
            assert (robot.timeout, robot.wheels) == (0.3, (0, 0))
            assert count(robot, "s") >= 3


def test_who_is_missing_is_said_within_the_stated_time_with_those_refused() -> None:
    at = place()
    with TcpMiabot(Miabot(2), at, CLOCK.now), TcpMiabot(Miabot(9), at, CLOCK.now, again=False):
        start = time.monotonic()
        with (
            pytest.raises(RadioError) as caught,
            opened(f"miabot-tcp-listen:{at}", 1, 2, 3, patience=1.0),
        ):
            pass
        assert time.monotonic() - start < 3.0
    said = str(caught.value)
    assert f"radio {at}: robots 1, 3 of 3 did not connect within 1 s" in said
    assert "refused 1 times: 127.0.0.1: robot 9 is not in the formation" in said
    with socket.create_server(("127.0.0.1", int(at.split(":")[1]))):
        pass  # the port is free again


def test_a_wait_can_be_interrupted() -> None:
    with pytest.raises(KeyboardInterrupt):
        open_radio(
            f"miabot-tcp-listen:{place()}", CLOCK, RadioSettings(), (1,), interrupted=lambda: True
        )


def test_a_port_in_use_is_told() -> None:
    with socket.create_server(("127.0.0.1", 0)) as busy:
        at = f"127.0.0.1:{busy.getsockname()[1]}"
        with pytest.raises(RadioError, match=f"{at}: cannot listen: Address already in use"):
            open_radio(f"miabot-tcp-listen:{at}", CLOCK, RadioSettings(), (1,))


def test_a_robot_that_calls_again_after_it_vanished_replaces_its_old_link() -> None:
    at, first, again = place(), Miabot(1), Miabot(1)
    with TcpMiabot(first, at, CLOCK.now) as gone, opened(f"miabot-tcp-listen:{at}", 1) as radio:
        kept_sending(radio, 0.2, 1)
        gone.deaf = True  # no FIN, no reset: as when its supply was interrupted
        with TcpMiabot(again, at, CLOCK.now):
            assert until(lambda: radio.send((command(1),), CLOCK.now()) == () and again.commands())
            assert again.received[0][1] == ".vTO=300"
            assert link_reports(radio)[0].counts.connects == 2
            before = len(first.commands())
            kept_sending(radio, 0.2, 1)
            assert len(first.commands()) == before
        assert radio.notes == ()  # type: ignore[attr-defined]


def test_a_second_robot_with_the_same_number_is_refused_while_the_first_one_answers() -> None:
    at, first, second = place(), Miabot(1), Miabot(1)
    with TcpMiabot(first, at, CLOCK.now), opened(f"miabot-tcp-listen:{at}", 1) as radio:
        with TcpMiabot(second, at, CLOCK.now, again=False) as intruder:
            lost = kept_sending(radio, 1.0, 1)
            assert until(lambda: count(second, "s") == 1)
            assert intruder.calls == 1
        assert lost == set()
        assert second.commands() == []
        assert first.wheels == (100, 100)
        (note,) = radio.notes  # type: ignore[attr-defined]
        assert note == "refused 1 times: 127.0.0.1: a second robot 1, the first one answers"


def test_callers_that_say_nothing_rubbish_or_a_foreign_number_are_refused_and_hold_up_nobody() -> (
    None
):
    at, robot = place(), Miabot(1)
    address = ("127.0.0.1", int(at.split(":")[1]))
    with TcpMiabot(robot, at, CLOCK.now), opened(f"miabot-tcp-listen:{at}", 1) as radio:
        callers = [socket.create_connection(address) for _ in range(12)]
        for n, caller in enumerate(callers):
            caller.sendall((b"", b"\xff<test#", b"<test#77>", b"GET / HTTP/1.1\r\n\r\n")[n % 4])
        assert kept_sending(radio, 1.5, 1) == set()
        notes = " ".join(radio.notes)  # type: ignore[attr-defined]
        assert "refused 3 times: 127.0.0.1: robot 77 is not in the formation" in notes
        assert "refused 9 times: 127.0.0.1: no Miabot answers within 1 s" in notes
        for caller in callers:
            caller.close()
        assert robot.timeouts == 0


def test_a_flood_of_callers_leaves_the_robots_alone_and_the_port_open() -> None:
    at, robot = place(), Miabot(1)
    address = ("127.0.0.1", int(at.split(":")[1]))
    with TcpMiabot(robot, at, CLOCK.now), opened(f"miabot-tcp-listen:{at}", 1) as radio:
        callers = []

        def flood() -> None:
            callers.extend(socket.create_connection(address) for _ in range(100))

        thread = threading.Thread(target=flood)
        thread.start()
        assert kept_sending(radio, 1.5, 1) == set()
        assert robot.timeouts == 0
        thread.join()
        for caller in callers:
            caller.close()
        assert any("too many callers at once" in note for note in radio.notes)  # type: ignore[attr-defined]
