"""VSSS robots behind an ESP32 on a serial port: `<id,wl,wr,id,wl,wr>`, one message for all."""

from dataclasses import dataclass
from functools import partial
from typing import Literal

from control.command import RobotId
from pipeline.radios.broadcast import Channel, Speeds
from pipeline.radios.link import SerialLink
from pipeline.radios.wheels import Wheels

BAUDRATE = 115_200  # [bit/s]
BYTES_PER_SECOND = BAUDRATE / 10  # a byte is ten bits on the wire [B/s]

Unit = Literal["rad/s", "m/s", "mm/s", "scaled"]


@dataclass(frozen=True, slots=True)
class VsssFormat:
    """How the firmware wants wheel speeds written; no standard says it.

    Attributes:
        unit: of a wheel speed; "scaled": `scale` units per m/s.
        decimals: digits behind the point, 0 for whole numbers.
        scale: units per m/s, for "scaled" only.
    """

    unit: Unit = "rad/s"
    decimals: int = 2
    scale: float = 1000.0

    def per_mps(self, radius: float) -> float:
        """How many units a wheel rim's 1 m/s is.

        Args:
            radius: of a wheel [m].

        Returns:
            Units per m/s.
        """
        return {"rad/s": 1.0 / radius, "m/s": 1.0, "mm/s": 1000.0, "scaled": self.scale}[self.unit]


def vsss_message(speeds: Speeds, per_mps: float, decimals: int) -> bytes:
    """Write one message.

    Args:
        speeds: of the wheels of every robot it is for [m/s].
        per_mps: units per m/s.
        decimals: digits behind the point.

    Returns:
        The message, ASCII.
    """
    parts = (
        f"{robot},{_number(wheels.left * per_mps, decimals)},"
        f"{_number(wheels.right * per_mps, decimals)}"
        for robot, wheels in speeds.items()
    )
    return f"<{','.join(parts)}>".encode("ascii")


def vsss_channel(
    port: str, robots: tuple[RobotId, ...], wheels: Wheels, form: VsssFormat
) -> Channel:
    """The link to the ESP32.

    Args:
        port: its serial device.
        robots: who is reached.
        wheels: of the robots.
        form: as the firmware wants it.

    Returns:
        For a BroadcastRadio.
    """
    per_mps = form.per_mps(wheels.radius)
    number = len(_number(-wheels.fastest * per_mps, form.decimals))
    longest = sum(len(f"{robot},,,") + 2 * number for robot in robots) + 1
    encode = partial(vsss_message, per_mps=per_mps, decimals=form.decimals)
    return Channel(port, partial(SerialLink, baudrate=BAUDRATE), encode, BYTES_PER_SECOND, longest)


def _number(value: float, decimals: int) -> str:
    return f"{round(value, decimals) + 0.0:.{decimals}f}"  # never -0
