"""Where things that nobody steers are over time: standing, along given points, or wandering."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from datasets.errors import SimulationError

Floats = NDArray[np.float64]

_TONES = np.array([0.6, 1.0, 1.5])  # rates of the sinusoids of a wandering path, relative


class Path(Protocol):
    """A pose over time."""

    def at(self, t: Floats) -> Floats:
        """Where the thing is.

        Args:
            t: shape (N,) [s].

        Returns:
            Poses x, y, theta, shape (N, 3) [m, m, rad].
        """
        ...


@dataclass(frozen=True, slots=True)
class Waypoints:
    """Straight from point to point; standing before the first and after the last.

    Attributes:
        times: when each point is reached, ascending [s].
        poses: one per time: x, y, theta; headings are not wrapped [m, m, rad].

    Raises:
        SimulationError: if there is no point, or the times do not ascend.
    """

    times: tuple[float, ...]
    poses: tuple[tuple[float, float, float], ...]

    def __post_init__(self) -> None:
        if not self.times or len(self.times) != len(self.poses) or np.any(np.diff(self.times) <= 0):
            raise SimulationError(f"a path of {len(self.poses)} points at the times {self.times} s")

    def at(self, t: Floats) -> Floats:
        """Where the thing is.

        Args:
            t: shape (N,) [s].

        Returns:
            Poses x, y, theta, shape (N, 3) [m, m, rad].
        """
        axes = np.array(self.poses).T
        return np.column_stack([np.interp(t, self.times, axis) for axis in axes])


class Wandering:
    """A seeded smooth way about a place, never farther from it than the reach."""

    def __init__(
        self,
        center: tuple[float, float],
        reach: tuple[float, float],
        speed: float,
        rng: np.random.Generator,
    ) -> None:
        """Draw the way.

        Args:
            center: x, y of the place [m].
            reach: greatest distance from it along x and y, > 0 [m].
            speed: rms along each axis, >= 0 [m/s].
            rng: decides.
        """
        self._center, self._reach = np.array(center), np.array(reach)
        rates = _TONES[:, None] * rng.uniform(0.9, 1.1, (len(_TONES), 2))
        rms = self._reach * np.sqrt(0.5 * (rates**2).sum(axis=0)) / len(_TONES)
        self._rates = rates * speed / rms  # [rad/s]
        self._phases = rng.uniform(0.0, 2.0 * np.pi, (len(_TONES), 2))
        self._heading = rng.uniform(-np.pi, np.pi)
        self._turn = speed / float(self._reach.mean()) * rng.uniform(-1.0, 1.0)  # [rad/s]

    def at(self, t: Floats) -> Floats:
        """Where the thing is.

        Args:
            t: shape (N,) [s].

        Returns:
            Poses x, y, theta, shape (N, 3) [m, m, rad].
        """
        waves = np.sin(self._rates * t[:, None, None] + self._phases).mean(axis=1)
        return np.column_stack((self._center + self._reach * waves, self._heading + self._turn * t))
