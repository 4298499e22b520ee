"""What a calibration gives: lens, floor, and how well they are known."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.calibration.bundle import LENS
from vision.calibration.detect import BoardView
from vision.calibration.doubts import floor_doubts
from vision.calibration.floor import FittedFloor, camera_of
from vision.camera import CameraModel
from vision.errors import VisionError

Floats = NDArray[np.float64]

GIVEN = "given"  # the terms of a lens that was not fitted


@dataclass(frozen=True, slots=True)
class Calibration:
    """A fitted camera.

    Attributes:
        size_px: width and height of the pictures [px].
        lens: shape (9,), fx, fy, cx, cy [px], k1, k2, p1, p2, k3.
        covariance: shape (9, 9), of the lens; zeros if it was given.
        terms: which distortion was fitted, in words.
        views: boards in the hands, then on the floor, without mistaken corners.
        residuals: found minus predicted corners of the views, shape (N, 2) each [px].
        left_out: sentences on views and corners that were left out.
        cross_px: reprojection error of views that took no part in their lens's fit [px]; NaN if the
            lens was given.
        floor: if it is known.
    """

    size_px: tuple[int, int]
    lens: Floats
    covariance: Floats
    terms: str
    views: tuple[BoardView, ...]
    residuals: tuple[Floats, ...]
    left_out: tuple[str, ...]
    cross_px: float
    floor: FittedFloor | None

    @property
    def deviations(self) -> Floats:
        """Standard deviations of the lens's numbers, shape (9,)."""
        return np.asarray(np.sqrt(np.diag(self.covariance)), np.float64)

    @property
    def rms_px(self) -> float:
        """Reprojection error of all corners [px]; NaN without views."""
        if not self.residuals:
            return float("nan")
        return float(np.sqrt((np.vstack(self.residuals) ** 2).sum(axis=1).mean()))

    def camera(self, tag_height: float) -> CameraModel:
        """The camera model.

        Args:
            tag_height: of the tags above the floor [m].

        Returns:
            The camera.

        Raises:
            VisionError: if the floor is unknown.
        """
        if self.floor is None:
            raise VisionError("the camera's floor is unknown")
        return camera_of(self.size_px, self.lens, self.floor.pose, tag_height)

    def check_floor(self, tag_height: float) -> None:
        """Refuse a floor that is not known well enough.

        Args:
            tag_height: of the tags above the floor [m].

        Raises:
            VisionError: with the reason.
        """
        if self.floor is not None:
            doubts = floor_doubts(self.size_px, self.lens, self.floor, tag_height)
            if doubts:
                raise VisionError("; ".join(doubts))


def given_lens(lens: Floats, size_px: tuple[int, int]) -> Calibration:
    """A lens that was calibrated before.

    Args:
        lens: shape (9,).
        size_px: width and height of its pictures [px].

    Returns:
        A calibration without views or floor.
    """
    return Calibration(size_px, lens, np.zeros((LENS, LENS)), GIVEN, (), (), (), float("nan"), None)
