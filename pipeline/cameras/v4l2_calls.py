"""The calls of V4L2 that are needed here: numbers and layouts of linux/videodev2.h.

The layouts hold on every Linux; the numbers, made of direction, size and a running number, where
ioctl.h is the generic one, as on x86 and ARM.
"""

import errno
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from struct import Struct
from typing import Any

_READ, _WRITE = 2, 1
_MOST = 256  # of anything that is listed: a driver that never ends is cut off

Ioctl = Callable[[int, int, bytearray], object]
"""As fcntl.ioctl: file descriptor, request, bytes that the kernel reads and writes."""


@dataclass(frozen=True, slots=True)
class Call:
    """One call.

    Attributes:
        request: its number for ioctl.
        layout: of the structure that goes in and comes out.
    """

    request: int
    layout: Struct

    def __call__(self, ioctl: Ioctl, fd: int, *values: int) -> tuple[Any, ...]:
        """Make the call.

        Args:
            ioctl: fcntl's, or one like it.
            fd: open device.
            values: the first fields, each of four bytes; the others are zero.

        Returns:
            All fields afterwards.

        Raises:
            OSError: if the driver refuses.
        """
        words = (int(v & 0xFFFFFFFF).to_bytes(4, sys.byteorder) for v in values)
        data = bytearray(b"".join(words).ljust(self.layout.size, b"\0"))
        ioctl(fd, self.request, data)
        return self.layout.unpack(data)


def _call(direction: int, number: int, layout: str) -> Call:
    """_IOC of linux/ioctl.h."""
    packed = Struct(layout)
    return Call(direction << 30 | packed.size << 16 | ord("V") << 8 | number, packed)


QUERY_CAPABILITIES = _call(_READ, 0, "=16s32s32sIII12x")
"""driver, card, bus, version, capabilities of the whole, capabilities of this node."""
ENUMERATE_FORMATS = _call(_READ | _WRITE, 2, "=III32sI16x")
"""index, buffer type, flags, description, code."""
GET_CONTROL = _call(_READ | _WRITE, 27, "=Ii")
SET_CONTROL = _call(_READ | _WRITE, 28, "=Ii")
"""id, value."""
QUERY_CONTROL = _call(_READ | _WRITE, 36, "=II32siiiiI8x")
"""id, type, name, minimum, maximum, step, default, flags."""
QUERY_MENU = _call(_READ | _WRITE, 37, "=II32s4x")
"""id, index, name (or a number of eight bytes)."""
ENUMERATE_SIZES = _call(_READ | _WRITE, 74, "=III6I8x")
"""index, code, kind, then width, height, or smallest, largest, step of width and of height."""
ENUMERATE_INTERVALS = _call(_READ | _WRITE, 75, "=IIIII6I8x")
"""index, code, width, height, kind, then one fraction, or smallest, largest, step [s]."""


def text_of(field: bytes) -> str:
    """Read a text of fixed length.

    Args:
        field: filled up with zeros.

    Returns:
        The text.
    """
    return field.split(b"\0")[0].decode("utf-8", "replace").strip()


def listed(
    call: Call, ioctl: Ioctl, fd: int, after: tuple[int, ...] = ()
) -> Iterator[tuple[Any, ...]]:
    """List until the driver says that there is no more.

    Args:
        call: whose first field is an index.
        ioctl: fcntl's, or one like it.
        fd: open device.
        after: the fields behind the index.

    Yields:
        Fields of each entry.

    Raises:
        OSError: if the driver fails otherwise than by the end.
    """
    for index in range(_MOST):
        try:
            fields = call(ioctl, fd, index, *after)
        except OSError as error:
            if error.errno in (errno.EINVAL, errno.ENOTTY):
                return
            raise
        yield fields
