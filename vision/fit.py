"""The outcome of fitting tags to a picture."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]


@dataclass(frozen=True, slots=True)
class Fit:
    """Fitted tags.

    Attributes:
        poses: shape (R, 3), x, y, theta on the floor [m, m, rad].
        covariances: shape (R, 3, 3) [m^2, m rad, rad^2].
        residual_px: shape (R,), rms misfit as a displacement of edges [px].
        colors: shape (R, K + 1, 3), BGR of every part, and of the floor around, as they would look
            without blur.
        settled: shape (R,), whether another step would change nothing.
    """

    poses: Floats
    covariances: Floats
    residual_px: Floats
    colors: Floats
    settled: NDArray[np.bool_]

    def put(self, rows: Indices, other: "Fit") -> None:
        """Put another fit in the place of some rows.

        Args:
            rows: shape (M,), their indices.
            other: of M tags.
        """
        self.poses[rows], self.covariances[rows] = other.poses, other.covariances
        self.residual_px[rows], self.colors[rows] = other.residual_px, other.colors
        self.settled[rows] = other.settled


def empty_fit(count: int, parts: int) -> Fit:
    """Make room for a fit.

    Args:
        count: R, number of tags.
        parts: K.

    Returns:
        A fit without values.
    """
    return Fit(
        np.empty((count, 3)), np.empty((count, 3, 3)), np.empty(count),
        np.empty((count, parts + 1, 3)), np.empty(count, np.bool_),
    )  # fmt: skip
