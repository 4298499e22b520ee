"""What a camera delivered in a run, in numbers."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

ENOUGH = 0.9  # share of the frames asked for below which a camera is called slow


@dataclass(frozen=True, slots=True)
class CameraReport:
    """What a frame source has done so far.

    Attributes:
        frames: that were received, of whatever worth.
        dropped: that were passed over because a newer one had arrived, or came out of order.
        duplicates: that showed the picture before once more; not handed out.
        wrong_size: that were of another size than the first; not handed out.
        reopenings: times the camera was lost and came back.
        fps: frames received per second while it was there; None if too few came [1/s].
        asked_fps: what was asked for, None if nothing was [1/s].
        delay_p50: from capture to arrival, median, None if nobody knows [s].
        delay_p99: the same, 99th percentile [s].
    """

    frames: int = 0
    dropped: int = 0
    duplicates: int = 0
    wrong_size: int = 0
    reopenings: int = 0
    fps: float | None = None
    asked_fps: float | None = None
    delay_p50: float | None = None
    delay_p99: float | None = None


@runtime_checkable
class Reporting(Protocol):
    """A frame source that says how it did."""

    @property
    def report(self) -> CameraReport:
        """What it delivered so far."""
        ...


def told(report: CameraReport) -> Iterator[str]:
    """Say what went otherwise than wished; the rate is told by `pipeline.cadence`.

    Args:
        report: of a camera.

    Yields:
        One line for each thing; nothing where all is well.
    """
    if report.dropped:
        yield f"camera: {report.dropped} frames were passed over for newer ones"
    if report.duplicates:
        yield f"camera: {report.duplicates} frames showed the picture before once more"
    if report.wrong_size:
        yield f"camera: {report.wrong_size} frames of another size were dropped"
    if report.reopenings:
        yield f"camera: it was lost and came back {report.reopenings} times"


def is_slow(fps: float | None, asked: float | None) -> bool:
    """Whether a camera delivers less than was asked of it.

    Args:
        fps: what it delivers, None if unknown [1/s].
        asked: what was asked for, None if nothing was [1/s].

    Returns:
        True if more than a tenth is lacking.
    """
    return fps is not None and asked is not None and fps < ENOUGH * asked
