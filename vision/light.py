"""The light on the robots: how colours look now, against how they looked to the palette."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Light:
    """Exposure and white balance, as factors on the colours the palette was learned from.

    Attributes:
        blue: factor of the blue channel.
        green: of the green channel.
        red: of the red channel.
    """

    blue: float = 1.0
    green: float = 1.0
    red: float = 1.0

    @property
    def gains(self) -> Floats:
        """The factors as an array, shape (3,), BGR."""
        return np.array((self.blue, self.green, self.red))


PALETTE_LIGHT = Light()
"""The light in which the palette was learned."""
