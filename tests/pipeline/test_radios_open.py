"""SPECs of radios: what cannot be used is one clear line that names the SPEC and the remedy."""

import pytest

from pipeline.clock import MonotonicClock
from pipeline.errors import ConfigError, RadioError
from pipeline.radios.open import RadioSettings, open_radio

CLOCK = MonotonicClock()
ANY = "need simulated, none, miabot:ID=PORT,..., miabot-tcp:ID=HOST:PORT,..., miabot-tcp-listen:"
ADDRESS = "need HOST:PORT with a port from 1 to 65535"


@pytest.mark.parametrize(
    ("spec", "words"),
    [
        ("", ANY),
        ("none:1", ANY),
        ("zigbee:1", ANY),
        ("miabot", "need ID=PORT, got ''"),
        ("miabot:1", "need ID=PORT, got '1'"),
        ("miabot:1=/dev/x,=y", "need ID=PORT, got '=y'"),
        ("miabot:1=/dev/x,1=/dev/y", "one robot comes twice"),
        ("miabot:1=/dev/x,2=/dev/x", "one port comes twice"),
        ("miabot:1=/dev/x", "robot 2 of the scenario has no port"),
        ("miabot:1=/dev/x,2=/dev/y,3=/dev/z", "robot 3 is not in the scenario"),
        ("miabot-tcp:1=10.0.0.1:80", "robot 2 of the scenario has no port"),
        ("miabot-tcp:1=10.0.0.1,2=10.0.0.2:80", ADDRESS),
        ("miabot-tcp:1=10.0.0.1:0,2=10.0.0.2:80", ADDRESS),
        ("miabot-tcp:1=fe80::1:80,2=10.0.0.2:80", ADDRESS),
        ("miabot-tcp-listen", ADDRESS),
        ("miabot-tcp-listen:9000", ADDRESS),
        ("miabot-tcp-listen:0.0.0.0:99999", ADDRESS),
        ("vsss", "need vsss:PORT"),
        ("firasim:20011", ADDRESS),
        ("firasim:127.0.0.1:x", ADDRESS),
        ("firasim:127.0.0.1:٢٠", ADDRESS),
    ],
)
def test_specs_that_cannot_be_used_are_one_clear_line(spec: str, words: str) -> None:
    with pytest.raises(ConfigError) as caught:
        open_radio(spec, CLOCK, RadioSettings(), robots=(1, 2))
    assert words in str(caught.value)
    assert spec.partition(":")[2] in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("spec", ["miabot-tcp-listen:127.0.0.1:9", "vsss:/x", "firasim:a:1"])
def test_robots_that_have_names_or_are_not_there_cannot_be_numbered(spec: str) -> None:
    with pytest.raises(ConfigError, match="so robot 'red' needs a whole one"):
        open_radio(spec, CLOCK, RadioSettings(), robots=(1, "red"))
    with pytest.raises(ConfigError, match="no robots are to be reached"):
        open_radio(spec, CLOCK, RadioSettings())


@pytest.mark.parametrize(
    ("spec", "words"),
    [
        ("miabot:1=/dev/rfcomm77", "radio /dev/rfcomm77: cannot open: No such file or directory"),
        ("vsss:/dev/ttyUSB77", "radio /dev/ttyUSB77: cannot open: No such file or directory"),
        ("miabot-tcp:1=127.0.0.1:9", "radio 127.0.0.1:9: cannot connect: Connection refused"),
        ("miabot-tcp:1=a..b:9", "radio a..b:9: cannot connect: no such host"),
        ("firasim:127.0.0.1:9", "radio 127.0.0.1:9: cannot send: nobody listens there"),
        ("miabot-tcp-listen:192.0.2.1:9000", "radio 192.0.2.1:9000: cannot listen: Cannot assign"),
    ],
)
def test_what_cannot_be_reached_is_named(spec: str, words: str) -> None:
    with pytest.raises(RadioError) as caught:
        open_radio(spec, CLOCK, RadioSettings(), robots=(1,))
    assert str(caught.value).startswith(words)
