"""Coloured clutter on the floor: seeded shapes, lying about or wandering."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from datasets.errors import SimulationError
from datasets.paths import Path, Wandering, Waypoints
from datasets.things import Thing, regular_outline

Floats = NDArray[np.float64]
Bgr = tuple[float, float, float]

_CORNERS = (3, 4, 24)  # triangles, squares, discs
_REACH = 0.4  # how far a wandering thing goes, as a share of the floor


@dataclass(frozen=True, slots=True)
class Clutter:
    """How much lies about.

    Attributes:
        count: of the things.
        colors: blue, green, red of 255; each thing has one of them.
        size: least and greatest width [m].
        moving: share of the things that wander.
        speed: of these, rms along each axis [m/s].

    Raises:
        SimulationError: if a number is out of its range.
    """

    count: int
    colors: tuple[Bgr, ...]
    size: tuple[float, float] = (0.02, 0.06)
    moving: float = 0.0
    speed: float = 0.2

    def __post_init__(self) -> None:
        sound = self.count >= 0 and 0.0 < self.size[0] <= self.size[1] and self.colors
        if not (sound and 0.0 <= self.moving <= 1.0 and 0.0 <= self.speed < 1e3):
            raise SimulationError(f"clutter out of range: {self}")

    def things(self, low: Floats, high: Floats, seed: int) -> tuple[Thing, ...]:
        """Strew them.

        Args:
            low: least x, y of the floor, shape (2,) [m].
            high: greatest x, y of the floor, shape (2,) [m].
            seed: of shapes, places, colours and ways, >= 0.

        Returns:
            The things, all on the floor.
        """
        rng = np.random.default_rng((seed, 4))
        return tuple(self._thing(low, high, rng) for _ in range(self.count))

    def _thing(self, low: Floats, high: Floats, rng: np.random.Generator) -> Thing:
        x, y = rng.uniform(low, high).tolist()
        outline = regular_outline(int(rng.choice(_CORNERS)), 0.5 * rng.uniform(*self.size))
        color = self.colors[int(rng.integers(len(self.colors)))]
        path: Path = Waypoints((0.0,), ((x, y, rng.uniform(-np.pi, np.pi)),))
        if rng.random() < self.moving and self.speed:
            across, along = (_REACH * (high - low)).tolist()
            path = Wandering((x, y), (across, along), self.speed, rng)
        return Thing(outline, color, path)
