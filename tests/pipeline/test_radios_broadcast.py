"""VSSS robots behind an ESP32, robots in FIRASim: units, stale commands, no watchdog."""

import time
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from control.command import Command
from control.unicycle import Twist, WheelSpeeds
from pipeline.accounts import link_reports
from pipeline.radios.firasim import firasim_packet
from pipeline.radios.open import RadioSettings
from pipeline.radios.vsss import BYTES_PER_SECOND, VsssFormat, vsss_channel, vsss_message
from pipeline.radios.wheels import Wheels
from tests.hardware.firasim import FiraSim
from tests.hardware.ptys import Ptys
from tests.hardware.vsss_base import VsssBase
from tests.pipeline.radios import CLOCK, DEFAULTS, command, opened, until

STANDING = (0.0, 0.0)
speeds = st.floats(-2.0, 2.0)


@given(left=speeds, right=speeds, unit=st.sampled_from(["rad/s", "m/s", "mm/s", "scaled"]))
def test_what_the_esp32_reads_are_the_speeds_in_its_unit(
    left: float, right: float, unit: str
) -> None:
    form = VsssFormat(unit, 3, 500.0)  # type: ignore[arg-type]
    per_mps = {"rad/s": 1 / 0.026, "m/s": 1.0, "mm/s": 1000.0, "scaled": 500.0}[unit]
    channel = vsss_channel("", (1, 23), Wheels(), form)
    message = channel.encode({1: WheelSpeeds(left, right), 23: WheelSpeeds(right, -left)})
    assert len(message) <= channel.longest
    base = VsssBase()
    base.receive(message, 0.0)
    assert base.errors == 0
    assert base.robots[1] == pytest.approx((left * per_mps, right * per_mps), abs=0.00051)
    assert base.robots[23] == pytest.approx((right * per_mps, -left * per_mps), abs=0.00051)


def test_vsss_text_as_the_description_writes_it() -> None:
    told = {1: WheelSpeeds(0.5, -0.25), 2: WheelSpeeds(-0.0001, 0.0)}
    assert vsss_message(told, 1000.0, 0) == b"<1,500,-250,2,0,0>"
    told[2] = WheelSpeeds(-0.00001, 0.0)
    assert vsss_message(told, 1.0 / 0.02, 2) == b"<1,25.00,-12.50,2,0.00,0.00>"


@given(left=speeds, right=speeds, yellow=st.booleans(), robot=st.integers(0, 4))
def test_firasim_reads_rad_per_s_of_the_right_robot_and_team(
    left: float, right: float, yellow: bool, robot: int
) -> None:
    reader = FiraSim.__new__(FiraSim)
    reader.told, reader.packets, reader.errors, reader.strangers = [], 0, 0, 0
    reader.received(firasim_packet({robot: WheelSpeeds(left, right)}, 0.02, yellow))
    assert reader.errors == 0
    assert reader.wheels(robot, yellow) == pytest.approx((left / 0.02, right / 0.02), rel=1e-12)
    assert reader.wheels(robot, not yellow) is None


@pytest.mark.realtime
def test_all_robots_are_in_one_message_on_the_wire_and_stop_comes_three_times() -> None:
    base = VsssBase()
    with Ptys([base], CLOCK.now) as ptys, opened(f"vsss:{ptys.paths[0]}", 1, 2) as radio:
        assert radio.min_period == pytest.approx(33 / BYTES_PER_SECOND)  # <1,-76.92,-76.92,2,...>
        radio.send((command(1, 0.26), command(2, 0.0, 1.0)), CLOCK.now())
        assert until(lambda: len(base.messages) == 2)
        assert base.messages[0][1] == {1: STANDING, 2: STANDING}  # stand first, at every connect
        assert base.messages[1][1] == {1: (10.0, 10.0), 2: (-1.31, 1.31)}
        radio.stop(CLOCK.now())
        assert until(lambda: len(base.messages) == 5)
        assert [told for _, told in base.messages[2:]] == [{1: STANDING, 2: STANDING}] * 3
        assert base.errors == 0


@pytest.mark.realtime
def test_a_flood_keeps_the_wires_budget_and_the_newest_wins() -> None:
    base = VsssBase()
    with Ptys([base], CLOCK.now) as ptys, opened(f"vsss:{ptys.paths[0]}", 1, 2, 3) as radio:
        start = CLOCK.now()
        for n in range(2000):
            radio.send(tuple(command(robot, n * 0.0005) for robot in (1, 2, 3)), CLOCK.now())
        newest = round(1999 * 0.0005 / 0.026, 2)
        assert until(lambda: base.robots.get(3) == (newest, newest))
        assert base.received <= BYTES_PER_SECOND * (CLOCK.now() - start) + 200
        seen = [told[1][0] for _, told in base.messages]
        assert seen == sorted(seen)
        counts = link_reports(radio)[0].counts
        assert counts.sent + counts.replaced == 2000
        assert counts.sent == len(base.messages) - 1


@pytest.mark.realtime
def test_who_has_a_stale_command_is_told_to_stand_with_the_others_newest() -> None:
    with FiraSim() as simulator, opened(f"firasim:{simulator.place}", 1, 2, 3) as radio:
        now = CLOCK.now()
        radio.send((Command(1, Twist(0.1, 0.0), now, now + 0.05), command(2, 0.1)), now)
        assert until(lambda: simulator.wheels(1) == pytest.approx((0.1 / 0.026,) * 2))
        assert len([told for told in simulator.told if told.robot == 3]) == 1  # the greeting
        time.sleep(0.06)
        radio.send((command(2, 0.2),), CLOCK.now())
        assert until(lambda: simulator.wheels(2) == pytest.approx((0.2 / 0.026,) * 2))
        assert simulator.wheels(1) == STANDING
        now = CLOCK.now()
        radio.send((Command(2, Twist(0.3, 0.0), now, now - 0.001),), now)
        radio.send((Command(2, Twist(float("nan"), 0.0), now, now + 1.0),), now)
        assert radio.send((command(9),), CLOCK.now()) == (9,)
        time.sleep(0.05)
        assert simulator.wheels(2) == pytest.approx((0.2 / 0.026,) * 2)
        assert (simulator.errors, simulator.strangers) == (0, 0)


@pytest.mark.realtime
def test_robots_without_a_watchdog_are_stopped_when_commands_cease() -> None:
    quick = replace(DEFAULTS, miabot=replace(DEFAULTS.miabot, timeout_ms=100))
    with (
        FiraSim() as simulator,
        opened(f"firasim:{simulator.place}", 1, 2, settings=quick) as radio,
    ):
        radio.send((command(1), command(2)), CLOCK.now())
        assert until(lambda: simulator.wheels(1) not in (None, STANDING))
        packets = simulator.packets
        assert until(lambda: simulator.wheels(1) == STANDING, 1.0)
        assert until(lambda: simulator.packets == packets + 3, 1.0)
        assert simulator.wheels(2) == STANDING
        time.sleep(0.3)
        assert simulator.packets == packets + 3  # once, not for ever
        assert [report.counts.silences for report in link_reports(radio)] == [1, 1]
        radio.send((command(1, 0.2),), CLOCK.now())
        assert until(lambda: simulator.wheels(1) == pytest.approx((0.2 / 0.026,) * 2))


@pytest.mark.realtime
def test_stop_and_close_leave_everyone_standing_in_the_right_team() -> None:
    yellow = replace(RadioSettings(), yellow=True, wheels=Wheels(radius=0.02))
    with FiraSim() as simulator:
        with opened(f"firasim:{simulator.place}", 0, 1, settings=yellow) as radio:
            radio.send((command(0, 0.3), command(1, 0.3)), CLOCK.now())
            assert until(lambda: simulator.wheels(1, True) == pytest.approx((15.0, 15.0)))
            before = simulator.packets
            radio.stop(CLOCK.now())
            assert until(lambda: simulator.packets >= before + 3)
        assert simulator.wheels(0, True) == simulator.wheels(1, True) == STANDING
        assert {told.yellow for told in simulator.told} == {True}


@pytest.mark.realtime
def test_a_simulator_that_ends_is_lost_and_found_again() -> None:
    first = FiraSim()
    with opened(f"firasim:{first.place}", 1, 2) as radio:
        first.close()
        assert until(lambda: radio.send((command(1), command(2)), CLOCK.now()) == (1, 2))
        assert "nobody listens there" in str(link_reports(radio)[0].error)
        with FiraSim(first.port) as again:
            assert until(lambda: radio.send((command(1),), CLOCK.now()) == ())
            assert until(lambda: again.wheels(1) not in (None, STANDING))
            assert again.told[0].left == 0.0  # a zero speed comes first
            again.say(b"nothing of this is expected")
            assert until(lambda: link_reports(radio)[0].garbage == 27)


@pytest.mark.realtime
def test_a_stop_ends_commands_that_are_still_valid_and_zero_speeds_are_no_stop() -> None:
    with FiraSim() as simulator, opened(f"firasim:{simulator.place}", 1, 2) as radio:
        radio.send((command(1, 0.0), command(2, 0.0)), CLOCK.now())  # the very bytes of a stop
        assert until(lambda: link_reports(radio)[0].counts.sent == 1)
        now = CLOCK.now()
        radio.send((Command(1, Twist(0.1, 0.0), now, now + 9.0),), now)
        assert until(lambda: simulator.wheels(1) not in (None, STANDING))
        radio.stop(CLOCK.now())
        told = len(simulator.told)
        radio.send((command(2, 0.2),), CLOCK.now())
        assert until(lambda: simulator.wheels(2) == pytest.approx((0.2 / 0.026,) * 2))
        assert simulator.wheels(1) == STANDING
        assert {after.robot for after in simulator.told[told:]} >= {2}
