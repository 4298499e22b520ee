"""The Miabot's language: what is written is whole and in range, what is read survives anything."""

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from control.unicycle import Twist, WheelSpeeds, twist_from_wheels
from pipeline.radios.miabot_text import (
    LONGEST_COMMAND,
    LONGEST_REPLY,
    Drive,
    EncoderCounts,
    ReplyParser,
    encoder_counts,
    encoder_stream_command,
    speed_command,
    timeout_command,
    wheel_units,
)

DRIVE = Drive(speed_scale=800.0, track_width=0.068)
speeds = st.floats(-3.0, 3.0)
turns = st.floats(-40.0, 40.0)


@given(v=speeds, omega=turns)
def test_wheel_units_are_the_twist_up_to_half_a_unit_and_full_scale(v: float, omega: float) -> None:
    left, right = wheel_units(Twist(v, omega), DRIVE)
    back = twist_from_wheels(WheelSpeeds(left / 800.0, right / 800.0), 0.068)
    fastest = (abs(v) + 0.034 * abs(omega)) * 800.0
    share = min(1.0, 1000.0 / fastest) if fastest > 0.0 else 1.0
    assert abs(back.v - share * v) <= 0.5 / 800.0 + 1e-12  # m/s
    assert abs(back.omega - share * omega) <= 1.0 / 800.0 / 0.068 + 1e-9  # rad/s
    assert max(abs(left), abs(right)) <= 1000
    assert len(speed_command(left, right)) <= LONGEST_COMMAND


def test_commands_as_the_description_writes_them() -> None:
    assert speed_command(-500, 1000) == b"[=-500,1000]"
    assert timeout_command(300) == b"[.vTO=300]"
    assert encoder_stream_command(20) == b"[:=20]"


def test_turning_left_drives_the_right_wheel() -> None:
    left, right = wheel_units(Twist(0.0, 1.0), Drive(1000.0, 0.068))
    assert (left, right) == (-34, 34)


def test_encoder_reply() -> None:
    assert encoder_counts(": +0000025000:-0000000012") == EncoderCounts(25_000, -12)
    for other in ("test#01", ": 12:13", ": +1:", ": +1:+2 and more", ": +99999999999:+1"):
        assert encoder_counts(other) is None


@given(
    noise=st.lists(st.binary(max_size=80).map(lambda b: b.translate(None, b"<>")), max_size=6),
    cuts=st.lists(st.integers(0, 500), max_size=8),
)
def test_replies_are_found_however_they_are_cut_and_whatever_stands_between(
    noise: list[bytes], cuts: list[int]
) -> None:
    stream = b"".join(rubbish + b"<r%d>" % n for n, rubbish in enumerate(noise)) + b"<last>"
    parser = ReplyParser()
    found: list[str] = []
    edges = sorted({0, len(stream), *(min(cut, len(stream)) for cut in cuts)})
    for start, end in pairwise(edges):
        found += parser.feed(stream[start:end])
    assert found == [*(f"r{n}" for n in range(len(noise))), "last"]
    assert parser.garbage == sum(map(len, noise))


def test_half_a_reply_waits_and_a_lost_end_costs_only_itself() -> None:
    parser = ReplyParser()
    assert parser.feed(b"<test") == ()
    assert parser.feed(b"#01>") == ("test#01",)
    assert parser.feed(b"<: +000<test#02>") == ("test#02",)
    assert parser.garbage == len(b"<: +000")


@pytest.mark.parametrize("byte", [b"x", b"<", b">", b"\x00", b"\xff"])
def test_ten_megabytes_without_a_reply_take_no_memory_and_are_counted(byte: bytes) -> None:
    parser = ReplyParser()
    for _ in range(2560):
        assert [reply for reply in parser.feed(byte * 4096) if reply] == []
        assert len(parser._partial) <= LONGEST_REPLY + 1
    assert parser.feed(b"<test#01>") == ("test#01",)
    assert parser.garbage + LONGEST_REPLY >= 2560 * 4096


def test_an_endless_line_that_began_as_a_reply_is_given_up() -> None:
    parser = ReplyParser()
    parser.feed(b"<" + b"y" * 10_000_000)
    assert parser.garbage == 10_000_001
    assert parser.feed(b"yyy><test#01>") == ("test#01",)
