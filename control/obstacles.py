"""What a formation keeps off: obstacles that move, and the border of the arena."""

from dataclasses import dataclass

from control.actuation import require_finite
from control.errors import ControlError
from control.motion_model import Array


@dataclass(frozen=True, slots=True)
class Obstacle:
    """A disc that moves with constant velocity.

    Attributes:
        x: centre at time 0 [m].
        y: centre at time 0 [m].
        radius: of the thing itself, without clearance, >= 0 [m].
        vx: velocity on the floor [m/s].
        vy: velocity on the floor [m/s].

    Raises:
        ControlError: if a number is not finite or the radius is negative.
    """

    x: float
    y: float
    radius: float
    vx: float = 0.0
    vy: float = 0.0

    def __post_init__(self) -> None:
        require_finite("obstacle", self.x, self.y, self.radius, self.vx, self.vy)
        if not self.radius >= 0.0:
            raise ControlError(f"the radius of an obstacle must be >= 0 m, got {self.radius:g} m")

    def apart(self, positions: Array, t: Array) -> Array:
        """From the centre to positions, each at its time.

        Args:
            positions: (2, n) [m].
            t: (n,) times [s].

        Returns:
            (2, n) [m].
        """
        apart: Array = positions - [self.x + self.vx * t, self.y + self.vy * t]
        return apart


@dataclass(frozen=True, slots=True)
class Arena:
    """A rectangle along the floor's axes.

    Attributes:
        x_min: [m].
        x_max: > x_min [m].
        y_min: [m].
        y_max: > y_min [m].

    Raises:
        ControlError: if a number is not finite or a side has no length.
    """

    x_min: float
    x_max: float
    y_min: float
    y_max: float

    def __post_init__(self) -> None:
        require_finite("arena", self.x_min, self.x_max, self.y_min, self.y_max)
        if not (self.x_min < self.x_max and self.y_min < self.y_max):
            raise ControlError(f"an arena needs x_min < x_max and y_min < y_max, got {self}")

    def borders(self) -> tuple[tuple[str, tuple[float, float], float], ...]:
        """The four sides: inside is inward . (x, y) >= at.

        Returns:
            Name, inward normal [1, 1] and place along it [m] of each.
        """
        return (
            (f"border x = {self.x_min:g} m", (1.0, 0.0), self.x_min),
            (f"border x = {self.x_max:g} m", (-1.0, 0.0), -self.x_max),
            (f"border y = {self.y_min:g} m", (0.0, 1.0), self.y_min),
            (f"border y = {self.y_max:g} m", (0.0, -1.0), -self.y_max),
        )
