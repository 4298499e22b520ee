"""The unicycle of equations (1)-(3): twists, states, wheels, exact steps, motor lag."""

from dataclasses import dataclass
from math import cos, exp, sin

from control.compilable import compilable
from control.errors import ControlError
from control.geometry import Pose2D, sine_ratio
from control.value import value


@value
@dataclass(frozen=True, slots=True)
class Twist:
    """Velocities of a unicycle.

    Attributes:
        v: forwards [m/s].
        omega: turning, counter-clockwise [rad/s].
    """

    v: float
    omega: float


@value
@dataclass(frozen=True, slots=True)
class UnicycleState:
    """Pose and velocities, equations (1) and (2).

    Attributes:
        x: position [m].
        y: position [m].
        theta: heading, not wrapped [rad].
        v: forward velocity [m/s].
        omega: angular velocity [rad/s].
    """

    x: float
    y: float
    theta: float
    v: float
    omega: float

    @property
    def pose(self) -> Pose2D:
        """Position and heading [m, m, rad]."""
        return Pose2D(self.x, self.y, self.theta)

    @property
    def twist(self) -> Twist:
        """Velocities [m/s, rad/s]."""
        return Twist(self.v, self.omega)


@value
@dataclass(frozen=True, slots=True)
class WheelSpeeds:
    """Rolling speeds of the two driven wheels.

    Attributes:
        left: rim speed of the left wheel [m/s].
        right: rim speed of the right wheel [m/s].
    """

    left: float
    right: float


@value
@dataclass(frozen=True, slots=True)
class SpeedLimits:
    """Greatest speeds that may be commanded, the same in both directions.

    Attributes:
        v: forward speed, > 0 [m/s].
        omega: angular speed, > 0 [rad/s].

    Raises:
        ControlError: if a limit is not positive.
    """

    v: float
    omega: float

    def __post_init__(self) -> None:
        if not (self.v > 0.0 and self.omega > 0.0):
            raise ControlError(f"speed limits must be > 0, got {self.v} m/s, {self.omega} rad/s")

    def saturate(self, twist: Twist) -> Twist:
        """Clip each velocity to its limit.

        Args:
            twist: wanted velocities [m/s, rad/s].

        Returns:
            The nearest velocities within the limits [m/s, rad/s].
        """
        return Twist(
            max(-self.v, min(self.v, twist.v)),
            max(-self.omega, min(self.omega, twist.omega)),
        )


@compilable
def wheels_from_twist(twist: Twist, track_width: float) -> WheelSpeeds:
    """Wheel speeds of a differential drive that rolls without slip, equation (2).

    Args:
        twist: velocities of the midpoint of the axle [m/s, rad/s].
        track_width: distance between the wheels [m].

    Returns:
        Speeds of both wheels [m/s].
    """
    half = 0.5 * track_width * twist.omega
    return WheelSpeeds(twist.v - half, twist.v + half)


@compilable
def twist_from_wheels(wheels: WheelSpeeds, track_width: float) -> Twist:
    """Velocities of a differential drive from its wheel speeds, equation (2).

    Args:
        wheels: speeds of both wheels [m/s].
        track_width: distance between the wheels, > 0 [m].

    Returns:
        Velocities of the midpoint of the axle [m/s, rad/s].
    """
    return Twist(0.5 * (wheels.left + wheels.right), (wheels.right - wheels.left) / track_width)


@compilable
def advance_pose(pose: Pose2D, twist: Twist, dt: float) -> Pose2D:
    """Drive for a time at constant velocities: the exact solution of (2), an arc.

    Args:
        pose: where the robot starts [m, m, rad].
        twist: constant velocities [m/s, rad/s].
        dt: duration, may be negative [s].

    Returns:
        Where it ends; the heading is not wrapped [m, m, rad].
    """
    x, y, theta = _along_arc(pose.x, pose.y, pose.theta, twist.v * dt, twist.omega * dt)
    return Pose2D(x, y, theta)


@compilable
def advance_lagged(state: UnicycleState, command: Twist, dt: float, lag: float) -> UnicycleState:
    """Drive for a time under a constant command that the motors follow with a first-order lag.

    Velocities, way and turn are exact; the way is laid along one arc, which errs by O(dt^3).

    Args:
        state: pose and velocities at the start [m, m, rad, m/s, rad/s].
        command: commanded velocities [m/s, rad/s].
        dt: duration, >= 0 [s].
        lag: time constant of the motors, > 0 [s].

    Returns:
        Pose and velocities at the end [m, m, rad, m/s, rad/s].
    """
    decay = exp(-dt / lag)
    dv, domega = state.v - command.v, state.omega - command.omega
    reach = lag * (1.0 - decay)
    way, turn = command.v * dt + dv * reach, command.omega * dt + domega * reach
    x, y, theta = _along_arc(state.x, state.y, state.theta, way, turn)
    return UnicycleState(x, y, theta, command.v + dv * decay, command.omega + domega * decay)


@compilable
def _along_arc(
    x: float, y: float, theta: float, way: float, turn: float
) -> tuple[float, float, float]:
    """End of an arc of length ``way`` [m] that turns by ``turn`` [rad]."""
    half = 0.5 * turn
    chord = way * sine_ratio(half)
    return x + chord * cos(theta + half), y + chord * sin(theta + half), theta + turn
