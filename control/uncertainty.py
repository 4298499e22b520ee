"""What is not known exactly, as bounds: the leader's motion, the shape, the follower."""

from dataclasses import dataclass, field, replace
from math import inf, pi
from typing import TypeAlias

from control.actuation import require_finite
from control.errors import ControlError
from control.nominal import Extremes

Interval: TypeAlias = tuple[float, float]

FULL_CIRCLE: Interval = (-pi, pi)


@dataclass(frozen=True, slots=True)
class LeaderBounds:
    """Greatest magnitudes of a leader's motion, both signs allowed.

    Attributes:
        speed: of v_i [m/s].
        turn_rate: of w_i [rad/s].
        acceleration: of u_i, forward [m/s^2].
        angular_acceleration: of u_i, angular [rad/s^2].

    Raises:
        ControlError: if a bound is negative or not finite.
    """

    speed: float
    turn_rate: float
    acceleration: float = 0.0
    angular_acceleration: float = 0.0

    def __post_init__(self) -> None:
        _require_bounds(
            "leader", self.speed, self.turn_rate, self.acceleration, self.angular_acceleration
        )

    def scaled(self, factor: float) -> "LeaderBounds":
        """The same path driven at another pace: accelerations go with the square of it.

        Args:
            factor: speed over the speed now, >= 0 [1].

        Returns:
            Bounds at that pace.
        """
        square = factor * factor
        return LeaderBounds(
            factor * self.speed,
            factor * self.turn_rate,
            square * self.acceleration,
            square * self.angular_acceleration,
        )


@dataclass(frozen=True, slots=True)
class ReferenceBounds:
    """Ranges of a wanted shape h^d and greatest magnitudes of its derivatives.

    Attributes:
        distance: least and greatest l^d, > 0 [m].
        bearing: least and greatest psi^d, not wrapped [rad].
        distance_rate: of l^d' [m/s].
        bearing_rate: of psi^d' [rad/s].
        distance_acceleration: of l^d'' [m/s^2].
        bearing_acceleration: of psi^d'' [rad/s^2].

    Raises:
        ControlError: if a range is empty, l^d not positive, or a bound negative or not finite.
    """

    distance: Interval
    bearing: Interval
    distance_rate: float = 0.0
    bearing_rate: float = 0.0
    distance_acceleration: float = 0.0
    bearing_acceleration: float = 0.0

    def __post_init__(self) -> None:
        _require_interval("wanted distance", self.distance)
        _require_interval("wanted bearing", self.bearing)
        _require_bounds("reference's rates", self.distance_rate, self.bearing_rate)
        _require_bounds(
            "reference's accelerations", self.distance_acceleration, self.bearing_acceleration
        )
        if not self.distance[0] > 0.0:
            raise ControlError(f"the wanted distance must be > 0 m, got {self.distance} m")

    def moved(self, by: float) -> "ReferenceBounds":
        """The same shape with a wider spacing.

        Args:
            by: added to the wanted distance [m].

        Returns:
            Bounds of that shape.
        """
        return replace(self, distance=(self.distance[0] + by, self.distance[1] + by))


@dataclass(frozen=True, slots=True)
class FollowerBounds:
    """A follower and what is not known of it, equations (3)-(5).

    Attributes:
        camera_offset: from the axle forward to the camera point, d > 0 [m].
        mass_error: greatest |eps|, < 1 [1].
        inertia_error: greatest |eps'|, < 1 [1].
        push: greatest disturbance of the axle's acceleration, any direction, in pi_k [m/s^2].
        twist: greatest disturbance of the angular acceleration, in pi_k [rad/s^2].

    Raises:
        ControlError: if d is not positive, an error not in [0, 1), or a bound negative.
    """

    camera_offset: float = 0.05
    mass_error: float = 0.0
    inertia_error: float = 0.0
    push: float = 0.0
    twist: float = 0.0

    def __post_init__(self) -> None:
        if not 0.0 < self.camera_offset < inf:
            raise ControlError(f"the camera offset must be > 0 m, got {self.camera_offset} m")
        _require_bounds("model errors", self.mass_error, self.inertia_error)
        _require_bounds("disturbance", self.push, self.twist)
        if not max(self.mass_error, self.inertia_error) < 1.0:
            raise ControlError(
                f"model errors must be < 1 (5), got {self.mass_error}, {self.inertia_error}"
            )


@dataclass(frozen=True, slots=True)
class Motion:
    """Everything that may happen to one pair: Omega of (9), with the rates, and what surrounds it.

    Attributes:
        leader: bounds of the leader's motion.
        reference: bounds of the wanted shape.
        follower: the follower and its model errors.
        errors: extremes of the errors of distance and bearing; only 0 by default.
        heading: range of phi = psi + theta_ik, the full circle by default [rad].

    Raises:
        ControlError: if the range of phi is empty or not finite.
    """

    leader: LeaderBounds
    reference: ReferenceBounds
    follower: FollowerBounds = field(default_factory=FollowerBounds)
    errors: tuple[Extremes, Extremes] = (Extremes(0.0, 0.0), Extremes(0.0, 0.0))
    heading: Interval = FULL_CIRCLE

    def __post_init__(self) -> None:
        _require_interval("phi", self.heading)

    @property
    def spacing(self) -> Interval:
        """Range of the distance l = l^d - e_l; its low end may be <= 0 [m]."""
        low, high = self.reference.distance
        return low - self.errors[0].high, high - self.errors[0].low


def _require_bounds(what: str, *values: float) -> None:
    require_finite(what, *values)
    if min(values) < 0.0:
        raise ControlError(f"bounds of the {what} must be >= 0, got {values}")


def _require_interval(what: str, interval: Interval) -> None:
    require_finite(what, *interval)
    if not interval[0] <= interval[1]:
        raise ControlError(f"the range of the {what} must go from low to high, got {interval}")
