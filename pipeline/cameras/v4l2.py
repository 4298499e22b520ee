"""A camera of Linux asked through V4L2: what it is, what it sends, what can be set."""

import errno
import os
import sys
from collections.abc import Iterator
from types import TracebackType
from typing import Any, Self

from pipeline.cameras.capabilities import Control, FrameSize, PixelFormat
from pipeline.cameras.v4l2_calls import (
    ENUMERATE_FORMATS,
    ENUMERATE_INTERVALS,
    ENUMERATE_SIZES,
    GET_CONTROL,
    QUERY_CAPABILITIES,
    QUERY_CONTROL,
    QUERY_MENU,
    SET_CONTROL,
    Ioctl,
    listed,
    text_of,
)

_CAPTURE, _CAPTURE_PLANES, _HAS_NODE_FLAGS = 0x1, 0x1000, 0x80000000
_NEXT = 0x80000000  # with an id: the next control after it
_INTEGER, _BOOLEAN, _MENU, _INTEGER_MENU = 1, 2, 3, 9  # kinds of controls that are one number
_DISABLED, _GRABBED, _READ_ONLY, _INACTIVE, _WRITE_ONLY = 0x01, 0x02, 0x04, 0x10, 0x40
_DISCRETE = 1  # sizes or intervals that are listed one by one


class V4l2Device:
    """An open device; close it, or use it in a `with` statement."""

    def __init__(self, path: str, ioctl: Ioctl | None = None) -> None:
        """Open a device; others may have it open, too.

        Args:
            path: /dev/videoN.
            ioctl: None for the kernel's.

        Raises:
            OSError: if it cannot be opened or is no V4L2 device.
        """
        if ioctl is None:
            import fcntl  # not everywhere

            ioctl = fcntl.ioctl
        self._ioctl = ioctl
        self._fd = os.open(path, os.O_RDWR | os.O_NONBLOCK)
        try:
            driver, card, bus, _, whole, node = QUERY_CAPABILITIES(ioctl, self._fd)
        except OSError:
            os.close(self._fd)
            raise
        self.driver, self.card, self.bus = text_of(driver), text_of(card), text_of(bus)
        self._flags = node if whole & _HAS_NODE_FLAGS else whole

    def __enter__(self) -> Self:
        """Use the device.

        Returns:
            Itself.
        """
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        """Close the device.

        Args:
            kind: of what was raised.
            error: what was raised.
            at: where.
        """
        os.close(self._fd)

    @property
    def captures(self) -> bool:
        """Whether pictures come from it; cameras have nodes for other things, too."""
        return bool(self._flags & (_CAPTURE | _CAPTURE_PLANES))

    def formats(self) -> tuple[PixelFormat, ...]:
        """List what it sends.

        Returns:
            Pixel formats in the driver's order.

        Raises:
            OSError: if the device does not answer.
        """
        kind = 1 if self._flags & _CAPTURE else 9
        found = [
            (int(code), text_of(name))
            for _, _, _, name, code in listed(ENUMERATE_FORMATS, self._ioctl, self._fd, (kind,))
        ]
        return tuple(PixelFormat(_code(c), name, tuple(self._sizes(c))) for c, name in found)

    def controls(self) -> tuple[Control, ...]:
        """List what can be set.

        Returns:
            All controls that are one number, with their present values.

        Raises:
            OSError: if the device does not answer.
        """
        return tuple(self._controls())

    def value(self, control: int) -> int:
        """Read a control.

        Args:
            control: its number.

        Returns:
            The present value.

        Raises:
            OSError: if it cannot be read.
        """
        return int(GET_CONTROL(self._ioctl, self._fd, control)[1])

    def set(self, control: int, value: int) -> None:
        """Set a control.

        Args:
            control: its number.
            value: wanted.

        Raises:
            OSError: if it is refused.
        """
        SET_CONTROL(self._ioctl, self._fd, control, value)

    def _sizes(self, code: int) -> Iterator[FrameSize]:
        for _, _, kind, *n in listed(ENUMERATE_SIZES, self._ioctl, self._fd, (code,)):
            if kind == _DISCRETE:
                yield FrameSize((n[0], n[1]), (n[0], n[1]), (0, 0), *self._rates(code, n[0], n[1]))
                continue
            rates = self._rates(code, n[1], n[4])
            yield FrameSize((n[0], n[3]), (n[1], n[4]), (n[2], n[5]), *rates)
            return

    def _rates(self, code: int, width: int, height: int) -> tuple[tuple[float, ...], bool]:
        """Frames per second, fastest first, and whether all between are offered."""
        rates: set[float] = set()
        size = code, width, height
        for _, _, _, _, kind, *n in listed(ENUMERATE_INTERVALS, self._ioctl, self._fd, size):
            ends = [(n[0], n[1])] if kind == _DISCRETE else [(n[0], n[1]), (n[2], n[3])]
            rates |= {below / above for above, below in ends if above}
            if kind != _DISCRETE:
                return tuple(sorted(rates, reverse=True)), True
        return tuple(sorted(rates, reverse=True)), False

    def _controls(self) -> Iterator[Control]:
        last = 0
        while True:
            try:
                fields = QUERY_CONTROL(self._ioctl, self._fd, last | _NEXT)
            except OSError as error:
                if error.errno in (errno.EINVAL, errno.ENOTTY):
                    return
                raise
            if fields[0] <= last:  # a driver that goes in circles
                return
            last, kind, flags = fields[0], fields[1], fields[7]
            usable = not flags & (_DISABLED | _READ_ONLY | _WRITE_ONLY)
            if usable and kind in (_INTEGER, _BOOLEAN, _MENU, _INTEGER_MENU):
                yield self._control(fields)

    def _control(self, fields: tuple[Any, ...]) -> Control:
        number, kind, name, low, high, step, default, flags = fields
        try:
            value = self.value(number)
        except OSError:
            value = None
        choices = tuple(self._choices(number, kind, low, high))
        locked = bool(flags & (_INACTIVE | _GRABBED))
        return Control(number, text_of(name), low, high, step, default, value, locked, choices)

    def _choices(self, number: int, kind: int, low: int, high: int) -> Iterator[tuple[int, str]]:
        """Menus have holes: what the driver does not name is not offered."""
        if kind not in (_MENU, _INTEGER_MENU):
            return
        for index in range(max(0, low), min(high, 255) + 1):
            try:
                _, _, name = QUERY_MENU(self._ioctl, self._fd, number, index)
            except OSError:
                continue
            number_text = str(int.from_bytes(name[:8], sys.byteorder, signed=True))
            yield index, text_of(name) if kind == _MENU else number_text


def _code(number: int) -> str:
    """Four characters; drivers fill up with blanks."""
    return number.to_bytes(4, "little").decode("ascii", "replace").strip()
