"""Nonsense over real sockets breaks no link, stalls no command, and is counted.

The full numbers: python -m tests.hardware.noise
"""

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.radios import miabot_text as text
from tests.hardware import noise

pytestmark = pytest.mark.realtime


@pytest.mark.parametrize("seed", [0, 1])
def test_malformed_replies(seed: int) -> None:
    told = noise.replies(2000, seed)
    assert told.report.up
    assert told.report.counts.failures == 0
    assert 0.8 * told.size < told.report.garbage < told.size
    assert told.report.foreign > 0


def test_malformed_datagrams() -> None:
    told = noise.datagrams(2000, 0)
    assert told.report.up
    assert told.report.counts.failures == 0
    assert told.report.garbage == told.size


@given(st.lists(st.binary(max_size=200) | st.sampled_from(noise.SOUND + noise.TOKENS), max_size=30))
def test_whatever_a_robot_says_only_known_replies_are_understood(pieces: list[bytes]) -> None:
    parser = text.ReplyParser()
    for piece in pieces:
        for reply in parser.feed(piece):
            assert len(reply) <= text.LONGEST_REPLY
            number, counts = text.robot_number(reply), text.encoder_counts(reply)
            assert number is None or reply.startswith("test#")
            assert counts is None or reply.startswith(":")
    assert parser.garbage <= sum(map(len, pieces))


def test_what_is_mutated_is_the_same_for_the_same_seed() -> None:
    once, again = random.Random(5), random.Random(5)
    assert [noise.mutated(once) for _ in range(99)] == [noise.mutated(again) for _ in range(99)]
