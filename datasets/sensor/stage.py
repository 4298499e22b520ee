"""What all parts of a sensor share: the picture, its number, and the protocol of a stage."""

from typing import Any, Protocol

from numpy.typing import NDArray

Image = NDArray[Any]  # (H, W, 3) BGR: float32 until it is digitised, uint8 from then on

_TICKS = 1_000_000  # frames are numbered by the microsecond


class Stage(Protocol):
    """One thing lens or electronics do to a frame."""

    def __call__(self, image: Image, frame: int) -> Image:
        """Change a frame.

        Args:
            image: shape (H, W, 3), BGR, 0 to 255; may be written to.
            frame: its number, see `frame_number`; randomness depends on it and the seed alone.

        Returns:
            The changed frame, same shape.
        """
        ...


def frame_number(t: float) -> int:
    """Number a frame by its capture.

    Args:
        t: moment of capture [s].

    Returns:
        The microsecond of the capture.
    """
    return round(t * _TICKS) & 0xFFFFFFFFFFFF


def frame_time(frame: int) -> float:
    """When a frame was taken.

    Args:
        frame: its number.

    Returns:
        Moment of capture, to the microsecond [s].
    """
    return frame / _TICKS
