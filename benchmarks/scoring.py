"""What was found against what was true."""

from dataclasses import dataclass
from math import nan

import numpy as np
from numpy.typing import NDArray

from benchmarks.field import SIDE
from benchmarks.peers import Sightings
from control.geometry import wrap_angle

Floats = NDArray[np.float64]

_NEAR, _AHEAD = 0.5 * SIDE, np.radians(45.0)  # a sighting farther off is not of that robot


@dataclass(frozen=True, slots=True)
class Accuracy:
    """How well robots were found.

    Attributes:
        frames: number of pictures, all different.
        recall: share of the robots that were found.
        false_per_1000: ids reported where that robot is not, per 1000 pictures.
        position_rms_mm: of those found, in the plane, nan if none was found [mm].
        heading_rms_deg: of those found [deg].
    """

    frames: int
    recall: float
    false_per_1000: float
    position_rms_mm: float
    heading_rms_deg: float


class Tally:
    """Counts sightings over pictures."""

    def __init__(self) -> None:
        """Begin at nothing."""
        self._frames, self._robots, self._false = 0, 0, 0
        self._errors: list[Floats] = []

    def add(self, sightings: Sightings, poses: Floats) -> None:
        """Compare the sightings in a picture with the truth.

        Args:
            sightings: at most one of every id.
            poses: shape (R, 3), of robots 1 to R [m, m, rad].
        """
        self._frames += 1
        self._robots += len(poses)
        for robot_id, pose in sightings:
            if robot_id not in range(1, len(poses) + 1):
                self._false += 1
                continue
            error = pose - poses[int(robot_id) - 1]
            error[2] = wrap_angle(error[2])
            if np.hypot(error[0], error[1]) < _NEAR and abs(error[2]) < _AHEAD:
                self._errors.append(error)
            else:
                self._false += 1

    def result(self) -> Accuracy:
        """Sum up.

        Returns:
            Shares and errors over all pictures.
        """
        errors = np.array(self._errors).reshape(-1, 3)
        some = len(errors) > 0
        return Accuracy(
            self._frames,
            len(errors) / self._robots,
            1000.0 * self._false / self._frames,
            1e3 * float(np.sqrt((errors[:, :2] ** 2).sum(axis=1).mean())) if some else nan,
            float(np.degrees(np.sqrt((errors[:, 2] ** 2).mean()))) if some else nan,
        )
