"""The Miabot PRO's language: commands in square brackets, replies in angle brackets."""

import re
from dataclasses import dataclass

from control.unicycle import Twist
from pipeline.radios.wheels import limited_wheels

STOP = b"[s]"
WHO_ARE_YOU = b"[t]"
FULL_SCALE = 1000  # units of a wheel at full speed
TICKS_PER_METRE = 25_000  # of the encoders
LONGEST_COMMAND = len(b"[=-1000,-1000]")
LONGEST_REPLY = 64  # what does not end within this many bytes is no reply [B]

_NAME = re.compile(r"test#(\d{1,4})\Z")
_ENCODERS = re.compile(r": ?([+-]\d{1,10}):([+-]\d{1,10})\Z")


@dataclass(frozen=True, slots=True)
class Drive:
    """How a Miabot turns units into motion.

    Attributes:
        speed_scale: wheel units per m/s; 500 to 1000 by the sources, measured by calibration.
        track_width: between the wheels [m].
    """

    speed_scale: float = 1000.0
    track_width: float = 0.068


@dataclass(frozen=True, slots=True)
class EncoderCounts:
    """Distance each wheel has rolled.

    Attributes:
        left: since the counters were zeroed [1/25000 m].
        right: since the counters were zeroed [1/25000 m].
    """

    left: int
    right: int


def wheel_units(twist: Twist, drive: Drive) -> tuple[int, int]:
    """Turn a twist into what the wheels are told.

    Args:
        twist: wanted velocities, finite [m/s, rad/s].
        drive: scale and track width.

    Returns:
        Left and right, whole units in [-1000, 1000].
    """
    scale = drive.speed_scale
    wheels = limited_wheels(twist, drive.track_width, FULL_SCALE / scale)
    return round(wheels.left * scale), round(wheels.right * scale)


def speed_command(left: int, right: int) -> bytes:
    """Write the wheel command.

    Args:
        left: units in [-1000, 1000].
        right: units in [-1000, 1000].

    Returns:
        The message.
    """
    return b"[=%d,%d]" % (left, right)


def timeout_command(milliseconds: int) -> bytes:
    """Write the command that sets the robot's own deadman.

    Args:
        milliseconds: without a command for this long it stops itself [ms].

    Returns:
        The message.
    """
    return b"[.vTO=%d]" % milliseconds


def encoder_stream_command(milliseconds: int) -> bytes:
    """Write the command that makes the robot report its encoders.

    Args:
        milliseconds: period of the reports [ms].

    Returns:
        The message.
    """
    return b"[:=%d]" % milliseconds


def encoder_counts(reply: str) -> EncoderCounts | None:
    """Read an encoder reply.

    Args:
        reply: what stood between the angle brackets.

    Returns:
        The counts, None if it is another reply.
    """
    match = _ENCODERS.match(reply)
    return EncoderCounts(int(match[1]), int(match[2])) if match else None


def robot_number(reply: str) -> int | None:
    """Read the answer to "who are you".

    Args:
        reply: what stood between the angle brackets.

    Returns:
        The robot's number, None if it is another reply.
    """
    match = _NAME.match(reply)
    return int(match[1]) if match else None


class ReplyParser:
    """Finds replies in whatever arrives: noise, halves and endless lines; its memory is bounded.

    Attributes:
        garbage: bytes that belonged to no reply.
    """

    def __init__(self) -> None:
        """Start between replies."""
        self.garbage = 0
        self._partial = b""  # a reply that has begun, with its bracket

    def feed(self, data: bytes) -> tuple[str, ...]:
        """Take what has arrived.

        Args:
            data: any bytes.

        Returns:
            The replies completed by it, without their brackets, oldest first.
        """
        data = self._partial + data
        if b"<" not in data:
            self.garbage += len(data)
            return ()
        *closed, rest = data.split(b">")
        replies = [reply for piece in closed if (reply := self._reply(piece)) is not None]
        start = rest.rfind(b"<")
        kept = rest[start:] if start >= 0 else b""
        self._partial = kept if len(kept) <= LONGEST_REPLY else b""
        self.garbage += len(rest) - len(self._partial)
        return tuple(replies)

    def _reply(self, piece: bytes) -> str | None:
        """What stands after the last opening bracket of a piece that was closed."""
        before, bracket, body = piece.rpartition(b"<")
        if not bracket or len(body) > LONGEST_REPLY or not body.isascii():
            self.garbage += len(piece) + 1
            return None
        self.garbage += len(before)
        return body.decode("ascii")
