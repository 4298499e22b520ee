"""What a camera thread reads from: a device or stream that is waited for, picture by picture."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class Picture:
    """What a reader yields.

    Attributes:
        image: uint8, shape (H, W, 3), BGR.
        t_capture: when it was taken, on the run's clock [s].
        t_arrival: when it was at hand, decoded, on the run's clock [s].
        stamp: the camera's own time of it, on any clock [s]; None if it gives none.
    """

    image: NDArray[np.uint8]
    t_capture: float
    t_arrival: float
    stamp: float | None = None


class FrameReader(Protocol):
    """A camera that is read by waiting for it."""

    def read(self) -> Picture:
        """Wait for the next picture.

        Returns:
            The picture.

        Raises:
            CameraError: if the camera has failed or ended.
            EndOfStream: if it has ended as planned.
        """
        ...

    def release(self) -> None:
        """Give the device back."""
        ...
