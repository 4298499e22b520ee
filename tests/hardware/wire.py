"""Protobuf's wire format read by hand: varints, lengths, fixed sizes, as its guide says.

No protobuf library takes part, so what a program sends is judged by the format alone.
"""

import struct
from collections.abc import Iterator

VARINT, EIGHT, LENGTH, FOUR = 0, 1, 2, 5


class NotProtobuf(ValueError):
    """The bytes are no message."""


def fields(data: bytes) -> Iterator[tuple[int, int | float | bytes]]:
    """Read one message.

    Args:
        data: the whole message.

    Yields:
        Field number and value: an int (varint), a float (four or eight bytes), or bytes.

    Raises:
        NotProtobuf: if it ends too early or has an unknown wire type.
    """
    at = 0
    while at < len(data):
        key, at = _varint(data, at)
        number, kind = key >> 3, key & 7
        if number == 0:
            raise NotProtobuf("field 0")
        if kind == VARINT:
            value, at = _varint(data, at)
            yield number, value
        elif kind in (EIGHT, FOUR):
            size, form = (8, "<d") if kind == EIGHT else (4, "<f")
            yield number, struct.unpack(form, _take(data, at, size))[0]
            at += size
        elif kind == LENGTH:
            size, at = _varint(data, at)
            yield number, _take(data, at, size)
            at += size
        else:
            raise NotProtobuf(f"wire type {kind}")


def _varint(data: bytes, at: int) -> tuple[int, int]:
    value = 0
    for place in range(10):
        byte = _take(data, at + place, 1)[0]
        value |= (byte & 0x7F) << (7 * place)
        if byte < 0x80:
            return value, at + place + 1
    raise NotProtobuf("endless number")


def _take(data: bytes, at: int, size: int) -> bytes:
    if at + size > len(data):
        raise NotProtobuf("too short")
    return data[at : at + size]
