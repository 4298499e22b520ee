"""An emulated Miabot PRO at the far end of a pty, written from its protocol's description."""

from collections.abc import Callable
from dataclasses import dataclass, field

LONGEST = 32  # bytes a command may have between its brackets
FULL_SCALE = 1000  # wheel units
TICKS_PER_METRE = 25_000

Drive = Callable[[float, float, float], None]  # left m/s, right m/s, t s


def nowhere(left: float, right: float, t: float) -> None:
    """Wheels off the ground."""


@dataclass
class Miabot:
    """The robot's firmware: bytes in, replies out, wheels turning.

    Attributes:
        number: what it answers to "who are you".
        speed_scale: wheel units per m/s.
        drive: told of every change of the wheel speeds.
        wheels: present units, left and right.
        timeout: its own command timeout, 0: none [s].
        received: (t, command) of everything understood.
        errors: commands that were not understood.
        timeouts: times it stopped by itself.
    """

    number: int = 1
    speed_scale: float = 1000.0
    drive: Drive = nowhere
    wheels: tuple[int, int] = (0, 0)
    timeout: float = 0.0
    received: list[tuple[float, str]] = field(default_factory=list)
    errors: int = 0
    timeouts: int = 0
    _partial: str | None = None
    _last: float = 0.0
    _rolled: list[float] = field(default_factory=lambda: [0.0, 0.0])
    _rolled_at: float = 0.0
    _report_period: float = 0.0
    _report_at: float = 0.0

    def receive(self, data: bytes, t: float) -> bytes:
        """Take bytes from the radio.

        Args:
            data: any bytes.
            t: now [s].

        Returns:
            What it answers.
        """
        return b"".join(self._byte(chr(byte), t) for byte in data)

    def wake(self, t: float) -> bytes:
        """Do what is due by now: its own timeout, encoder reports.

        Args:
            t: now [s].

        Returns:
            What it says.
        """
        if self.timeout and self.wheels != (0, 0) and t - self._last >= self.timeout:
            self.timeouts += 1
            self._turn(0, 0, t)
        if not self._report_period or t < self._report_at:
            return b""
        self._report_at = max(self._report_at + self._report_period, t)
        self._roll(t)
        left, right = (round(way * TICKS_PER_METRE) for way in self._rolled)
        return b"<: %+011d:%+011d>" % (left, right)

    def due(self) -> float:
        """When it has to be woken next [s]."""
        timeout = self._last + self.timeout if self.timeout and self.wheels != (0, 0) else 1e9
        return min(timeout, self._report_at if self._report_period else 1e9)

    def commands(self) -> list[tuple[float, int, int]]:
        """Wheel commands it has had: t [s], left, right."""
        speeds = [(t, text[1:].split(",")) for t, text in self.received if text.startswith("=")]
        return [(t, int(left), int(right)) for t, (left, right) in speeds]

    def _byte(self, char: str, t: float) -> bytes:
        if char == "[":
            self.errors += self._partial is not None
            self._partial = ""
        elif self._partial is None:
            return b""
        elif char == "]":
            text, self._partial = self._partial, None
            return self._obey(text, t)
        elif len(self._partial) < LONGEST:
            self._partial += char
        else:
            self.errors, self._partial = self.errors + 1, None
        return b""

    def _obey(self, text: str, t: float) -> bytes:
        try:
            answer = self._act(text, t)
        except ValueError:
            self.errors += 1
            return b""
        self.received.append((t, text))
        self._last = t
        return answer

    def _act(self, text: str, t: float) -> bytes:
        if text == "s":
            self._turn(0, 0, t)
        elif text == "t":
            return b"<test#%02d>" % self.number
        elif text == "Q":
            return b"<Miabot PRO emulated 1.0>"
        elif text.startswith("="):
            left, right = (int(part) for part in text[1:].split(","))
            self._turn(left, right, t)
        elif text.startswith(":="):
            self._report_period, self._report_at = int(text[2:]) / 1000.0, t
        elif text.startswith(".vTO="):
            self.timeout = int(text[5:]) / 1000.0
        elif text == ";0,0":
            self._roll(t)
            self._rolled = [0.0, 0.0]
        else:
            raise ValueError(text)
        return b""

    def _turn(self, left: int, right: int, t: float) -> None:
        self._roll(t)
        self.wheels = (_clip(left), _clip(right))
        self.drive(self.wheels[0] / self.speed_scale, self.wheels[1] / self.speed_scale, t)

    def _roll(self, t: float) -> None:
        """Let the wheels turn until now; the encoders follow."""
        for side in (0, 1):
            self._rolled[side] += self.wheels[side] / self.speed_scale * (t - self._rolled_at)
        self._rolled_at = t


def _clip(units: int) -> int:
    return max(-FULL_SCALE, min(FULL_SCALE, units))
