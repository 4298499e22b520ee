"""An emulated ESP32 that passes `<id,wl,wr,id,wl,wr>` on to VSSS robots, written from the protocol.

Numbers have an optional sign and point; anything else makes the whole message void.
"""

import re

NUMBER = re.compile(r"-?\d{1,5}(\.\d{1,4})?\Z")
LONGEST = 200  # characters of a message


class VsssBase:
    """The firmware behind the serial port; it never stops anybody by itself.

    Attributes:
        robots: wheel speeds by id, as last told [in the firmware's unit].
        messages: (t, {id: (left, right)}) of all that was understood.
        errors: messages that were not.
        received: bytes so far.
    """

    def __init__(self) -> None:
        self.robots: dict[int, tuple[float, float]] = {}
        self.messages: list[tuple[float, dict[int, tuple[float, float]]]] = []
        self.errors, self.received = 0, 0
        self._text: str | None = None

    def receive(self, data: bytes, t: float) -> bytes:
        """Take bytes; it answers nothing."""
        self.received += len(data)
        for char in data.decode("latin-1"):
            self._take(char, t)
        return b""

    def wake(self, t: float) -> bytes:  # noqa: ARG002 - it has nothing to do by itself
        """It says nothing."""
        return b""

    def due(self) -> float:
        """It never has to be woken [s]."""
        return 1e9

    def _take(self, char: str, t: float) -> None:
        if char == "<":
            self.errors += self._text is not None
            self._text = ""
        elif self._text is None:
            return
        elif char == ">":
            text, self._text = self._text, None
            self._obey(text, t)
        elif len(self._text) < LONGEST:
            self._text += char
        else:
            self.errors, self._text = self.errors + 1, None

    def _obey(self, text: str, t: float) -> None:
        parts = text.split(",")
        if len(parts) % 3 or not all(NUMBER.match(part) for part in parts):
            self.errors += 1
            return
        told = {
            int(parts[n]): (float(parts[n + 1]), float(parts[n + 2]))
            for n in range(0, len(parts), 3)
        }
        self.robots |= told
        self.messages.append((t, told))
