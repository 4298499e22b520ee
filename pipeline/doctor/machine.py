"""Where a machine tells about itself: files below /proc, /sys and /dev."""

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True)
class Machine:
    """The folders that checks look into.

    Attributes:
        proc: what the kernel says of itself.
        sys: what it says of devices.
        dev: the devices.
        work: where recordings go.
    """

    proc: Path = Path("/proc")
    sys: Path = Path("/sys")
    dev: Path = Path("/dev")
    work: Path = Path()


def text_of(path: Path) -> str:
    """Read a small file.

    Args:
        path: perhaps missing.

    Returns:
        Its text without blanks at the ends; empty if it cannot be read.
    """
    try:
        return path.read_text(encoding="utf-8", errors="replace").strip()
    except OSError:
        return ""


def number_in(path: Path) -> int | None:
    """Read a number.

    Args:
        path: of a file that holds one, perhaps missing.

    Returns:
        The number, None if there is none.
    """
    text = text_of(path)
    return int(text) if text.isdecimal() else None
