"""The emulated ends do what the protocols say: bytes worked out by hand, no sender asked."""

import struct

import pytest

from tests.hardware.firasim import FiraSim
from tests.hardware.ssl_client import SslClient
from tests.hardware.vsss_base import VsssBase
from tests.hardware.wire import NotProtobuf, fields


def test_the_wire_format_by_the_examples_of_its_guide() -> None:
    assert list(fields(b"\x08\x96\x01")) == [(1, 150)]
    assert list(fields(b"\x12\x07testing")) == [(2, b"testing")]
    assert list(fields(b"\x1a\x03\x08\x96\x01")) == [(3, b"\x08\x96\x01")]
    assert list(fields(b"\x31" + struct.pack("<d", -2.5))) == [(6, -2.5)]
    assert list(fields(b"\x1d" + struct.pack("<f", 0.5))) == [(3, 0.5)]


@pytest.mark.parametrize("junk", [b"\x08", b"\x12\x09short", b"\x0b", b"\x00\x00", b"\xff" * 12])
def test_what_is_no_message_says_so(junk: bytes) -> None:
    with pytest.raises(NotProtobuf):
        list(fields(junk))


def test_firasim_obeys_a_packet_and_drives_on() -> None:
    wheels = b"\x31" + struct.pack("<d", 10.0) + b"\x39" + struct.pack("<d", -4.0)
    command = b"\x08\x02\x10\x01" + wheels
    inner = b"\x0a" + bytes([len(command)]) + command
    with FiraSim() as simulator:
        simulator.received(b"\x0a" + bytes([len(inner)]) + inner)
        assert simulator.wheels(2, yellow=True) == (10.0, -4.0)
        assert simulator.wheels(2) is None
        simulator.received(b"\x0a\x02\x0a\x00")  # robot 0, blue, standing: all of it is default
        assert simulator.wheels(0) == (0.0, 0.0)
        simulator.received(b"\x0a\x04\x0a\x02\x08\x07")
        assert (simulator.packets, simulator.strangers, simulator.errors) == (3, 1, 0)
        for junk in (b"\x08", b"\x0a\x02\x0a\x05", b"\x0a\x04\x0a\x02\x30\x01"):
            simulator.received(junk)
        assert simulator.errors == 3
        assert simulator.wheels(2, yellow=True) == (10.0, -4.0)


def test_the_ssl_client_wants_every_required_field() -> None:
    head = b"\x08\x05\x11" + struct.pack("<d", 1.5) + b"\x19" + struct.pack("<d", 1.6)
    with SslClient() as client:
        client.received(b"\x0a" + bytes([len(head)]) + head)
        assert client.errors == 1  # camera_id is missing
        head += b"\x20\x00"
        client.received(b"\x0a" + bytes([len(head)]) + head)
        (frame,) = client.frames
        assert frame.head == {"frame_number": 5, "t_capture": 1.5, "t_sent": 1.6, "camera_id": 0}


def test_the_esp32_takes_whole_messages_only() -> None:
    base = VsssBase()
    base.receive(b"<1,-0.50,2", 0.0)
    assert base.robots == {}
    base.receive(b".00,2,7,-8>", 0.1)
    assert base.robots == {1: (-0.5, 2.0), 2: (7.0, -8.0)}
    for junk in (b"<1,2>", b"<1,nan,0>", b"<1,2,3<", b">", b"<" + b"1" * 300, b"<1,+2,3>"):
        base.receive(junk, 0.2)
    assert base.robots == {1: (-0.5, 2.0), 2: (7.0, -8.0)}
    assert base.errors == 6
