"""What other light does to the scene: soft shadows that move, mirror images of lamps."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from datasets.errors import SimulationError
from datasets.paths import Path

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class Shadow:
    """A round shadow with a soft rim, on the floor and on the robots alike.

    Attributes:
        path: where its middle is.
        radius: to the middle of its rim, > 0 [m].
        softness: width of its rim, > 0 [m].
        darkness: share of the light that it takes, 0 to 1.

    Raises:
        SimulationError: if a number is out of its range.
    """

    path: Path
    radius: float
    softness: float = 0.1
    darkness: float = 0.5

    def __post_init__(self) -> None:
        if not (self.radius > 0.0 and self.softness > 0.0 and 0.0 <= self.darkness <= 1.0):
            raise SimulationError(f"shadow out of range: {self}")

    def light(self, floor: Singles, t: float) -> Singles:
        """What it leaves of the light.

        Args:
            floor: shape (H, W, 2), floor points of the pixels, NaN beyond [m].
            t: moment [s].

        Returns:
            Shape (H, W), 1 - darkness to 1.
        """
        away = _distances(floor, self.path.at(np.array([t]))[0])
        depth = (self.radius - away) / self.softness + 0.5
        depth = np.nan_to_num(np.clip(depth, 0.0, 1.0))
        return np.asarray(1.0 - self.darkness * depth * depth * (3.0 - 2.0 * depth), np.float32)


@dataclass(frozen=True, slots=True)
class Glare:
    """A lamp's mirror image on everything glossy, robots included; white, clipped by the sensor.

    Attributes:
        x: of the place on the floor where it is seen [m].
        y: of that place [m].
        width: standard deviation of its Gaussian profile, > 0 [m].
        strength: light added in its middle, of 255.

    Raises:
        SimulationError: if a number is out of its range.
    """

    x: float
    y: float
    width: float = 0.05
    strength: float = 300.0

    def __post_init__(self) -> None:
        if not (self.width > 0.0 and 0.0 <= self.strength < 1e6):
            raise SimulationError(f"glare out of range: {self}")

    def light(self, floor: Singles) -> Singles:
        """The light it adds.

        Args:
            floor: shape (H, W, 2), floor points of the pixels, NaN beyond [m].

        Returns:
            Shape (H, W), of 255.
        """
        away = _distances(floor, np.array((self.x, self.y))) / np.float32(self.width)
        return np.nan_to_num(np.float32(self.strength) * np.exp(-0.5 * away * away))


def _distances(floor: Singles, place: Floats) -> Singles:
    """From a place to every pixel's floor point, shape (H, W) [m]."""
    x, y = place[:2].astype(np.float32)
    away: Singles = np.hypot(floor[..., 0] - x, floor[..., 1] - y)
    return away
