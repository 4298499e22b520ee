"""The shutter: how long every row collects light, and when."""

from collections.abc import Callable
from dataclasses import dataclass
from math import ceil

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Project = Callable[[Floats], Floats]  # offsets from the frame's moment (V,) [s] -> pixels (V, 2)

_STEP = 0.25  # a moving edge is drawn at least every so many pixels [px]
_MOST = 64  # pictures averaged over one exposure
_SETTLE = 4  # rounds until a corner is at the time of its own row; each gains two digits


@dataclass(frozen=True, slots=True)
class Shutter:
    """When the rows of a picture are exposed; the frame's moment is the middle of the middle row.

    Attributes:
        exposure: how long every row collects light [s].
        readout: from the first row's exposure to the last row's; 0: all at once [s].
        rows: height of the image [px].
    """

    exposure: float = 0.0
    readout: float = 0.0
    rows: int = 1

    @property
    def instant(self) -> bool:
        """Whether the whole picture is taken at once."""
        return not (self.exposure or self.readout)

    def row_offset(self, y: Floats) -> Floats:
        """When rows are exposed.

        Args:
            y: rows [px].

        Returns:
            From the frame's moment to the middle of each row's exposure, same shape [s].
        """
        near = np.clip(y, -self.rows, 2 * self.rows)  # nothing far outside is ever exposed
        return (near / max(self.rows - 1, 1) - 0.5) * self.readout

    def views(self, project: Project, corners: int) -> Floats:
        """Where the corners of a moving thing are while the shutter is open.

        Every corner is taken at the time of the row it is seen in. For straight image motion edges
        stay straight, and the result is exact.

        Args:
            project: gives the pixels of all V corners, each at its own offset from the frame's
                moment.
            corners: V, how many.

        Returns:
            K views evenly spread over the exposure, to be averaged, shape (K, V, 2) [px].
        """
        if not self.exposure:
            return self._at(0.0, project, corners)[None]
        half = 0.5 * self.exposure
        first, last = (self._at(offset, project, corners) for offset in (-half, half))
        way = float(np.nan_to_num(np.abs(last - first)).max(initial=0.0))
        count = min(max(ceil(way / _STEP), 1), _MOST)
        offsets = ((np.arange(count) + 0.5) / count - 0.5) * self.exposure
        return np.stack([self._at(offset, project, corners) for offset in offsets.tolist()])

    def _at(self, offset: float, project: Project, corners: int) -> Floats:
        """Corners at one moment of every row's exposure."""
        offsets = np.full(corners, offset)
        pixels = project(offsets)
        for _ in range(_SETTLE if self.readout else 0):
            pixels = project(offset + self.row_offset(pixels[:, 1]))
        return pixels
