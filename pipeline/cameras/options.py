"""What a camera is asked to hold still: exposure, gain, focus, white balance, lamps' frequency."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

from pipeline.cameras.capabilities import Control, ControlAccess

Auto = Literal["auto"]


@dataclass(frozen=True, slots=True)
class DeviceOptions:
    """What is asked of a device; None leaves it as it is.

    Attributes:
        exposure_ms: how long light is collected [ms], or "auto".
        gain: in the camera's own steps, or "auto".
        focus: in the camera's own steps, or "auto".
        white_balance_k: colour temperature of the light [K], or "auto".
        power_line_hz: frequency of the mains that lamps flicker with; 0 for none [Hz], or "auto".
        constant_rate: whether automatic exposure must keep the frame rate.
    """

    exposure_ms: float | Auto | None = None
    gain: int | Auto | None = None
    focus: int | Auto | None = None
    white_balance_k: int | Auto | None = None
    power_line_hz: int | Auto | None = None
    constant_rate: bool | None = None


AS_IT_IS = DeviceOptions()


@dataclass(frozen=True, slots=True)
class _Knob:
    """How an option is set: V4L2's control, the one that makes it automatic, steps per unit."""

    name: str
    control: int
    automatic: int | None = None
    manuals: tuple[int, ...] = (0,)  # values of `automatic` that leave it to us, best first
    autos: tuple[int, ...] = (1,)  # values that do not
    steps: float = 1.0
    unit: str = ""
    words: tuple[str, ...] = ()  # for values that are choices


# Numbers of linux/v4l2-controls.h. Exposure is counted in steps of 0.1 ms; by hand is manual (1) or
# shutter priority (2), automatic is aperture priority (3), as most on USB offer it, or plain (0).
_EXPOSURE = _Knob("exposure", 0x009A0902, 0x009A0901, (1, 2), (3, 0), 10.0, " ms")
_KNOBS: Mapping[str, _Knob] = {
    "exposure_ms": _EXPOSURE,
    "gain": _Knob("gain", 0x00980913, 0x00980912),
    "focus": _Knob("focus", 0x009A090A, 0x009A090C),
    "white_balance_k": _Knob("white balance", 0x0098091A, 0x0098090C, unit=" K"),
}
_POWER_LINE = _Knob("power line", 0x00980918, words=("no flicker", "50 Hz", "60 Hz", "auto"))
_POWER_LINE_CHOICES: Mapping[int | str, int] = {0: 0, 50: 1, 60: 2, "auto": 3}
_RATE_MAY_FALL = _Knob("exposure may slow the rate", 0x009A0903)


def apply(options: DeviceOptions, device: ControlAccess, fps: float | None) -> Iterator[str]:
    """Set what is asked for, read it back, and say where the camera does otherwise.

    Args:
        options: what is asked for.
        device: open.
        fps: the frame rate asked for, None if none is [1/s].

    Yields:
        One line for each thing that is not as asked.

    Raises:
        OSError: if the device does not list its controls.
    """
    if options == AS_IT_IS:
        return
    known = {control.id: control for control in device.controls()}
    for name, knob in _KNOBS.items():
        wanted = getattr(options, name)
        if wanted is not None:
            yield from _turned(device, known, knob, wanted)
    if options.power_line_hz is not None:
        choice = _POWER_LINE_CHOICES[options.power_line_hz]
        yield from _written(device, known, _POWER_LINE, choice)
    if options.constant_rate is not None:
        yield from _written(device, known, _RATE_MAY_FALL, int(not options.constant_rate))
    if isinstance(options.exposure_ms, float) and fps and options.exposure_ms > 1e3 / fps:
        yield (
            f"an exposure of {options.exposure_ms:g} ms is longer than a frame at {fps:g}/s "
            f"({1e3 / fps:.1f} ms): fewer frames will come"
        )


def _turned(
    device: ControlAccess, known: Mapping[int, Control], knob: _Knob, wanted: float | str
) -> Iterator[str]:
    """Automatic, or by hand and then the value."""
    switch = known.get(knob.automatic or 0)
    if wanted == "auto":
        if switch is None:
            yield f"{knob.name}: the camera has no automatic"
        else:
            yield from _switched(device, switch, knob, knob.autos)
        return
    if switch is not None:
        yield from _switched(device, switch, knob, knob.manuals)
    yield from _written(device, known, knob, round(float(wanted) * knob.steps))


def _switched(
    device: ControlAccess, switch: Control, knob: _Knob, values: tuple[int, ...]
) -> Iterator[str]:
    """The first of several values that the camera offers."""
    offered = [v for v in values if not switch.choices or v in dict(switch.choices)]
    by_name = _Knob(f"automatic {knob.name}", switch.id)
    yield from _written(device, {switch.id: switch}, by_name, (offered or values)[0])


def _written(
    device: ControlAccess, known: Mapping[int, Control], knob: _Knob, value: int
) -> Iterator[str]:
    """Set one control and read it back."""
    control = known.get(knob.control)
    if control is None:
        yield f"{knob.name}: the camera cannot set it"
        return
    try:
        device.set(knob.control, value)
        problem = ""
    except OSError as error:
        problem = f" ({error.strerror})"
    kept = _read(device, knob.control)
    if problem or kept is None or abs(kept - value) >= max(1, control.step):
        yield (
            f"{knob.name}: {_shown(knob, value)} was asked for, the camera keeps "
            f"{'an unknown value' if kept is None else _shown(knob, kept)}{problem}; "
            f"it offers {_offered(knob, control)}"
        )


def _offered(knob: _Knob, control: Control) -> str:
    if control.choices:
        return ", ".join(name for _, name in control.choices)
    return f"{_shown(knob, control.minimum)} to {_shown(knob, control.maximum)}"


def _read(device: ControlAccess, control: int) -> int | None:
    try:
        return device.value(control)
    except OSError:
        return None


def _shown(knob: _Knob, value: int) -> str:
    if value < len(knob.words):
        return knob.words[value]
    return f"{value / knob.steps:g}{knob.unit}"
