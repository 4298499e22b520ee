"""Cameras as their drivers describe them to V4L2, at the level of the ioctl calls.

The structures are those of linux/videodev2.h, written down as C lays them out and apart from the
program's own; what the cameras offer is in the listings of `v4l2-ctl` that users publish of them.
"""

import ctypes
import errno
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

U32, S32, U8 = ctypes.c_uint32, ctypes.c_int32, ctypes.c_uint8


class _Words(ctypes.Structure):
    _fields_ = (("words", U32 * 6),)


class Capability(ctypes.Structure):
    _fields_ = (
        ("driver", U8 * 16), ("card", U8 * 32), ("bus_info", U8 * 32), ("version", U32),
        ("capabilities", U32), ("device_caps", U32), ("reserved", U32 * 3),
    )  # fmt: skip


class FormatDescription(ctypes.Structure):
    _fields_ = (
        ("index", U32), ("type", U32), ("flags", U32), ("description", U8 * 32),
        ("pixelformat", U32), ("mbus_code", U32), ("reserved", U32 * 3),
    )  # fmt: skip


class SizeEntry(ctypes.Structure):
    _fields_ = (
        ("index", U32), ("pixel_format", U32), ("type", U32), ("u", _Words), ("reserved", U32 * 2),
    )  # fmt: skip


class IntervalEntry(ctypes.Structure):
    _fields_ = (
        ("index", U32), ("pixel_format", U32), ("width", U32), ("height", U32), ("type", U32),
        ("u", _Words), ("reserved", U32 * 2),
    )  # fmt: skip


class QueryControl(ctypes.Structure):
    _fields_ = (
        ("id", U32), ("type", U32), ("name", U8 * 32), ("minimum", S32), ("maximum", S32),
        ("step", S32), ("default_value", S32), ("flags", U32), ("reserved", U32 * 2),
    )  # fmt: skip


class QueryMenu(ctypes.Structure):
    _pack_ = 1
    _fields_ = (("id", U32), ("index", U32), ("name", U8 * 32), ("reserved", U32))


class ControlValue(ctypes.Structure):
    _fields_ = (("id", U32), ("value", S32))


REQUESTS: Mapping[int, type[ctypes.Structure]] = {  # as strace and the kernel's header give them
    0x80685600: Capability,
    0xC0405602: FormatDescription,
    0xC02C564A: SizeEntry,
    0xC034564B: IntervalEntry,
    0xC0445624: QueryControl,
    0xC02C5625: QueryMenu,
    0xC008561B: ControlValue,
    0xC008561C: ControlValue,
}
SET = 0xC008561C
INTEGER, BOOLEAN, MENU, CLASS = 1, 2, 3, 6
Sizes = tuple[tuple[int, int, tuple[float, ...]], ...]
Steps = tuple[tuple[int, int, int, int, int, int], tuple[int, int, int, int]]


@dataclass
class Knob:
    """One control: kind, name, range, step, default, menu, and the control that locks it."""

    kind: int
    name: str
    low: int
    high: int
    step: int
    default: int
    menu: Mapping[int, str] = field(default_factory=dict)
    locked_by: tuple[int, int] | None = None  # control and its value that leaves this one free


@dataclass
class Camera:
    """A camera behind ioctl calls; values start at their defaults.

    Attributes:
        sizes: per code; either listed or one range of sizes and of intervals.
        stubborn: controls that keep their value and report success.
    """

    card: str
    driver: str
    knobs: Mapping[int, Knob]
    sizes: Mapping[str, Sizes | Steps]
    capture: bool = True
    stubborn: frozenset[int] = frozenset()

    def __post_init__(self) -> None:
        self.values = {number: knob.default for number, knob in self.knobs.items()}
        self.written: list[tuple[int, int]] = []

    def ioctl(self, fd: int, request: int, data: bytearray) -> int:
        """As the kernel answers."""
        os.fstat(fd)  # a closed one is an error there, too
        entry = REQUESTS[request].from_buffer(data)
        answer: Mapping[type[ctypes.Structure], Callable[[Any], None]] = {
            Capability: self._describe,
            FormatDescription: self._format,
            SizeEntry: self._size,
            IntervalEntry: self._interval,
            QueryControl: self._query,
            QueryMenu: self._menu,
            ControlValue: self._set if request == SET else self._get,
        }
        answer[type(entry)](entry)
        return 0

    def _describe(self, entry: Capability) -> None:
        put(entry.driver, self.driver)
        put(entry.card, self.card)
        put(entry.bus_info, "usb-0000:00:14.0-1")
        entry.capabilities = 0x84A00001  # of the whole device: it has a node that captures
        entry.device_caps = 0x04200001 if self.capture else 0x04A00000

    def _format(self, entry: FormatDescription) -> None:
        need(entry.type == 1 and entry.index < len(self.sizes))
        code = list(self.sizes)[entry.index]
        put(entry.description, {"MJPG": "Motion-JPEG", "YUYV": "YUYV 4:2:2"}.get(code, code))
        entry.pixelformat = number(code)

    def _listed(self, code: int) -> Sizes | Steps:
        found = [sizes for name, sizes in self.sizes.items() if number(name) == code]
        need(bool(found))
        return found[0]

    def _size(self, entry: SizeEntry) -> None:
        sizes = self._listed(entry.pixel_format)
        if is_range(sizes):
            need(entry.index == 0)
            entry.type, entry.u.words[:] = 3, sizes[0]
            return
        need(entry.index < len(sizes))
        entry.type, entry.u.words[:2] = 1, sizes[entry.index][:2]

    def _interval(self, entry: IntervalEntry) -> None:
        sizes = self._listed(entry.pixel_format)
        if is_range(sizes):
            need(entry.index == 0)
            entry.type, entry.u.words[:4] = 3, sizes[1]
            return
        rates = [r for w, h, r in sizes if (w, h) == (entry.width, entry.height)]
        need(bool(rates) and entry.index < len(rates[0]))
        entry.type, entry.u.words[:2] = 1, (10, round(10 * rates[0][entry.index]))

    def _query(self, entry: QueryControl) -> None:
        if entry.id & 0x80000000:
            later = [n for n in self.knobs if n > entry.id & 0x7FFFFFFF]
            need(bool(later))
            entry.id = min(later)
        need(entry.id in self.knobs)
        knob = self.knobs[entry.id]
        put(entry.name, knob.name)
        entry.type, entry.minimum, entry.maximum = knob.kind, knob.low, knob.high
        entry.step, entry.default_value = knob.step, knob.default
        entry.flags = 0x10 if self._locked(knob) else 0

    def _menu(self, entry: QueryMenu) -> None:
        menu = self.knobs[entry.id].menu
        need(entry.index in menu)
        put(entry.name, menu[entry.index])

    def _get(self, entry: ControlValue) -> None:
        need(entry.id in self.knobs and self.knobs[entry.id].kind != CLASS)
        entry.value = self.values[entry.id]

    def _set(self, entry: ControlValue) -> None:
        need(entry.id in self.knobs)
        knob = self.knobs[entry.id]
        need(not self._locked(knob), errno.EACCES)
        need(not knob.menu or entry.value in knob.menu)
        self.written.append((entry.id, entry.value))
        if entry.id not in self.stubborn:  # as the driver of USB cameras: clamped, in whole steps
            steps = round((entry.value - knob.low) / knob.step)
            self.values[entry.id] = min(knob.high, max(knob.low, knob.low + steps * knob.step))

    def _locked(self, knob: Knob) -> bool:
        return knob.locked_by is not None and self.values[knob.locked_by[0]] != knob.locked_by[1]


def need(holds: bool, code: int = errno.EINVAL) -> None:
    """Refuse as a driver does."""
    if not holds:
        raise OSError(code, os.strerror(code))


def put(place: ctypes.Array[ctypes.c_uint8], text: str) -> None:
    """Write a text into a field of fixed length."""
    place[: len(text)] = list(text.encode())


def number(code: str) -> int:
    return int.from_bytes(code.ljust(4).encode(), "little")


def is_range(sizes: Sizes | Steps) -> bool:
    return isinstance(sizes[0], tuple) and len(sizes[0]) == 6


EXPOSURE_MODES = {1: "Manual Mode", 3: "Aperture Priority Mode"}
EXPOSURE_AUTO, EXPOSURE, GAIN, FOCUS = 0x009A0901, 0x009A0902, 0x00980913, 0x009A090A
WHITE_BALANCE, WHITE_BALANCE_AUTO, POWER_LINE = 0x0098091A, 0x0098090C, 0x00980918


def c920(stubborn: frozenset[int] = frozenset()) -> Camera:
    """Logitech HD Pro Webcam C920."""
    return Camera(
        "HD Pro Webcam C920",
        "uvcvideo",
        {
            0x00980001: Knob(CLASS, "User Controls", 0, 0, 0, 0),
            0x00980900: Knob(INTEGER, "Brightness", 0, 255, 1, 128),
            WHITE_BALANCE_AUTO: Knob(BOOLEAN, "White Balance, Automatic", 0, 1, 1, 1),
            GAIN: Knob(INTEGER, "Gain", 0, 255, 1, 0),
            POWER_LINE: Knob(
                MENU, "Power Line Frequency", 0, 2, 1, 2, {0: "Disabled", 1: "50 Hz", 2: "60 Hz"}
            ),
            WHITE_BALANCE: Knob(
                INTEGER, "White Balance Temperature", 2000, 6500, 1, 4000,
                locked_by=(WHITE_BALANCE_AUTO, 0),
            ),
            EXPOSURE_AUTO: Knob(MENU, "Auto Exposure", 0, 3, 1, 3, EXPOSURE_MODES),
            EXPOSURE: Knob(
                INTEGER, "Exposure Time, Absolute", 3, 2047, 1, 250, locked_by=(EXPOSURE_AUTO, 1)
            ),
            0x009A0903: Knob(BOOLEAN, "Exposure, Dynamic Framerate", 0, 1, 1, 0),
            FOCUS: Knob(INTEGER, "Focus, Absolute", 0, 250, 5, 0, locked_by=(0x009A090C, 0)),
            0x009A090C: Knob(BOOLEAN, "Focus, Automatic Continuous", 0, 1, 1, 1),
        },
        {
            "YUYV": (
                (640, 480, (30.0, 24.0, 20.0, 15.0, 10.0, 7.5, 5.0)),
                (1920, 1080, (5.0,)),
            ),
            "MJPG": ((1280, 720, (30.0, 15.0)), (1920, 1080, (30.0, 24.0))),
        },
        stubborn=stubborn,
    )  # fmt: skip


def pi_camera() -> Camera:
    """Raspberry Pi camera module, driver bm2835 mmal: any size, any rate, no gain."""
    return Camera(
        "mmal service 16.1",
        "bm2835 mmal",
        {
            POWER_LINE: Knob(
                MENU, "Power Line Frequency", 0, 3, 1, 1,
                {0: "Disabled", 1: "50 Hz", 2: "60 Hz", 3: "Auto"},
            ),
            EXPOSURE_AUTO: Knob(
                MENU, "Auto Exposure", 0, 3, 1, 0, {0: "Auto Mode", 1: "Manual Mode"}
            ),
            EXPOSURE: Knob(INTEGER, "Exposure Time, Absolute", 1, 10000, 1, 1000),
        },
        {"MJPG": ((32, 2592, 2, 32, 1944, 2), (1, 90, 1, 1))},
    )  # fmt: skip


def facecam() -> Camera:
    """Elgato Facecam: by hand is called shutter priority."""
    modes = {0: "Auto Mode", 2: "Shutter Priority Mode"}
    return Camera(
        "Elgato Facecam",
        "uvcvideo",
        {
            EXPOSURE_AUTO: Knob(MENU, "Auto Exposure", 0, 3, 1, 0, modes),
            EXPOSURE: Knob(
                INTEGER, "Exposure Time, Absolute", 1, 2500, 1, 156, locked_by=(EXPOSURE_AUTO, 2)
            ),
        },
        {"UYVY": ((1920, 1080, (60.0, 30.0)),)},
    )
