"""What a camera at this machine can do: formats with sizes and rates, and controls."""

from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True, slots=True)
class FrameSize:
    """A size, or a range of sizes, of one pixel format.

    Attributes:
        low_px: smallest width and height [px].
        high_px: largest; the same where there is only one [px].
        step_px: between sizes of a range [px].
        fps: frames per second offered at the largest size, fastest first [1/s].
        any_fps: whether every rate between the first and the last is offered, too.
    """

    low_px: tuple[int, int]
    high_px: tuple[int, int]
    step_px: tuple[int, int] = (0, 0)
    fps: tuple[float, ...] = ()
    any_fps: bool = False


@dataclass(frozen=True, slots=True)
class PixelFormat:
    """One way in which the camera sends pixels.

    Attributes:
        code: four characters, as `camera.device.pixel_format` takes them.
        name: in the driver's words.
        sizes: as the driver lists them.
    """

    code: str
    name: str
    sizes: tuple[FrameSize, ...]


@dataclass(frozen=True, slots=True)
class Control:
    """Something that can be set at a camera.

    Attributes:
        id: V4L2's number of it.
        name: in the driver's words.
        minimum: least value.
        maximum: greatest value.
        step: between values.
        default: the driver's.
        value: at present, None if it cannot be read.
        locked_out: whether something automatic, or another program, has it at present.
        choices: number and name of each choice of a menu; empty for numbers.
    """

    id: int
    name: str
    minimum: int
    maximum: int
    step: int = 1
    default: int = 0
    value: int | None = None
    locked_out: bool = False
    choices: tuple[tuple[int, str], ...] = ()


@dataclass(frozen=True, slots=True)
class CameraDescription:
    """A camera at this machine.

    Attributes:
        path: of its device.
        spec: what `live --camera` takes; a lasting name where the system gives one.
        card: its name.
        driver: that runs it.
        bus: where it is plugged in.
        formats: what it sends.
        controls: what can be set.
        problem: why it could not be asked, empty if it could.
    """

    path: str
    spec: str
    card: str = ""
    driver: str = ""
    bus: str = ""
    formats: tuple[PixelFormat, ...] = ()
    controls: tuple[Control, ...] = ()
    problem: str = ""


class ControlAccess(Protocol):
    """A camera whose controls can be read and set."""

    def controls(self) -> tuple[Control, ...]:
        """List what can be set.

        Returns:
            All controls with their present values.

        Raises:
            OSError: if the device does not answer.
        """
        ...

    def value(self, control: int) -> int:
        """Read a control.

        Args:
            control: its number.

        Returns:
            The present value.

        Raises:
            OSError: if it cannot be read.
        """
        ...

    def set(self, control: int, value: int) -> None:
        """Set a control; the camera may keep another value without saying so.

        Args:
            control: its number.
            value: wanted.

        Raises:
            OSError: if it is refused.
        """
        ...
