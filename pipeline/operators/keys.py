"""What keys mean: arrows drive the leader, one key stops everything, one arms again."""

from control.keyed import KeyDrive
from control.unicycle import Twist
from datasets.cycle import Orders

STEPS = 5  # presses from a standstill to the greatest speed
HANDS_OFF = 10.0  # without a key for this long the leader stands: nobody may be there [s]
LONGEST = 8  # an escape sequence that is longer is none [B]
HALT, ARM, STAND, REPORT = b" ", b"r", b"s", b"c"
ARROWS = {b"\x1b[A": (1, 0), b"\x1b[B": (-1, 0), b"\x1b[D": (0, 1), b"\x1b[C": (0, -1)}
"""Up, down, left, right: steps of speed, steps of turn (left is positive)."""

HELP = "space: emergency stop; r: arm; c: cadence"
HELP_DRIVING = f"arrows: drive the leader; s: stand; {HELP}"


class Keys:
    """Bytes of a terminal in, orders out."""

    def __init__(self, drive: KeyDrive | None) -> None:
        """Start standing.

        Args:
            drive: how the leader may be driven; None: not at all.
        """
        self._drive = drive
        self._speed = self._turn = 0  # steps
        self._last, self._partial = 0.0, b""

    def read(self, data: bytes, now: float) -> Orders:
        """Take what was typed.

        Args:
            data: any bytes; keys that mean nothing are ignored.
            now: the moment of the cycle [s].

        Returns:
            The orders.
        """
        keys = self._keys(data)
        self._last = now if keys else self._last
        for key in keys:
            self._press(key)
        if HALT in keys or now - self._last > HANDS_OFF:
            self._speed = self._turn = 0
        arm = ARM in keys and HALT not in keys
        return Orders(self._wanted(), HALT in keys, arm, REPORT in keys)

    def _press(self, key: bytes) -> None:
        if key == STAND:
            self._speed = self._turn = 0
        speed, turn = ARROWS.get(key, (0, 0))
        self._speed = max(-STEPS, min(STEPS, self._speed + speed))
        self._turn = max(-STEPS, min(STEPS, self._turn + turn))

    def _wanted(self) -> Twist | None:
        if self._drive is None:
            return None
        v, omega = self._drive.speed / STEPS, self._drive.turn / STEPS
        return Twist(v * self._speed, omega * self._turn)

    def _keys(self, data: bytes) -> list[bytes]:
        """Single bytes and arrows; what may go on to be an arrow waits for the rest."""
        data, keys = self._partial + data, []
        while data:
            size = next((len(arrow) for arrow in ARROWS if data.startswith(arrow)), 1)
            if size == 1 and any(arrow.startswith(data) for arrow in ARROWS):
                break
            keys.append(data[:size])
            data = data[size:]
        self._partial = data[-LONGEST:]
        return keys
