"""What a formation keeps off: obstacles that move, and the border of the arena."""

from dataclasses import dataclass, replace
from math import isfinite

from control.actuation import require_finite
from control.errors import ControlError
from control.motion_model import Array
from control.safety import Arena


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

    def after(self, t: float) -> "Obstacle":
        """The obstacle as it is some time later.

        Args:
            t: since time 0 [s].

        Returns:
            The same, moved on.
        """
        return replace(self, x=self.x + self.vx * t, y=self.y + self.vy * t)

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


def borders(arena: Arena) -> list[tuple[str, tuple[float, float], float]]:
    """The sides of an arena that are somewhere: inside is inward . (x, y) >= at.

    Args:
        arena: what must not be left.

    Returns:
        Name, inward normal [1, 1] and place along it [m] of each.
    """
    sides = (
        ("x", (1.0, 0.0), arena.x_low),
        ("x", (-1.0, 0.0), -arena.x_high),
        ("y", (0.0, 1.0), arena.y_low),
        ("y", (0.0, -1.0), -arena.y_high),
    )
    return [
        (f"the arena's border {axis} = {sum(inward) * at:g} m", inward, at)
        for axis, inward, at in sides
        if isfinite(at)
    ]
