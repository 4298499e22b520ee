"""What a formation keeps off: obstacles that move, and the border of the arena."""

from dataclasses import dataclass
from math import cos, hypot, sin

from control.actuation import require_finite
from control.errors import ControlError
from control.geometry import Pose2D


@dataclass(frozen=True, slots=True)
class Obstacle:
    """A disc that moves with constant velocity.

    Attributes:
        x: centre when the plan starts [m].
        y: centre when the plan starts [m].
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
            raise ControlError(f"the radius of an obstacle must be >= 0 m, got {self.radius} m")

    def distance(self, x: float, y: float, t: float) -> float:
        """Distance of a point from the edge.

        Args:
            x: the point [m].
            y: the point [m].
            t: time since the plan's start [s].

        Returns:
            Distance, negative inside [m].
        """
        return hypot(x - self.x - t * self.vx, y - self.y - t * self.vy) - self.radius


@dataclass(frozen=True, slots=True)
class Arena:
    """A rectangle on the floor.

    Attributes:
        center: its middle, and the direction of its length [m, m, rad].
        length: > 0 [m].
        width: > 0 [m].

    Raises:
        ControlError: if a number is not finite or a side not positive.
    """

    center: Pose2D
    length: float
    width: float

    def __post_init__(self) -> None:
        center = self.center
        require_finite("arena", center.x, center.y, center.theta, self.length, self.width)
        if not min(self.length, self.width) > 0.0:
            raise ControlError(f"sides of an arena must be > 0 m, got {self.length}, {self.width}")

    def sides(self) -> tuple[tuple[float, float, float], ...]:
        """The four sides as (nx, ny, reach): inside is nx x + ny y <= reach.

        Returns:
            Outward normals and their reach from the origin: front, left, back, right [1, 1, m].
        """
        c, s = cos(self.center.theta), sin(self.center.theta)
        halves = (0.5 * self.length, 0.5 * self.width) * 2
        normals = ((c, s), (-s, c), (-c, -s), (s, -c))
        x, y = self.center.x, self.center.y
        return tuple(
            (nx, ny, nx * x + ny * y + half) for (nx, ny), half in zip(normals, halves, strict=True)
        )

    def distance(self, x: float, y: float) -> float:
        """Distance of a point from the nearest side.

        Args:
            x: the point [m].
            y: the point [m].

        Returns:
            Distance, negative outside [m].
        """
        return min(reach - nx * x - ny * y for nx, ny, reach in self.sides())
