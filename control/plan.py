"""Plans of the formation's leader: what a plan is, and paths of arcs and straight lines."""

from dataclasses import dataclass
from typing import Protocol

from control.errors import ControlError
from control.geometry import Pose2D
from control.unicycle import Twist, UnicycleState, advance_pose
from control.value import value


@dataclass(frozen=True, slots=True)
class PathSegment:
    """A piece of a path with constant curvature.

    Attributes:
        length: along the path, > 0 [m].
        curvature: 1/radius, positive to the left, 0 straight [1/m].
    """

    length: float
    curvature: float = 0.0


@value
@dataclass(frozen=True, slots=True)
class PlannedMotion:
    """Wanted motion of the leader at one moment.

    Attributes:
        state: wanted pose and velocities [m, m, rad, m/s, rad/s].
        v_rate: wanted forward acceleration [m/s^2].
        omega_rate: wanted angular acceleration [rad/s^2].
    """

    state: UnicycleState
    v_rate: float
    omega_rate: float


class Plan(Protocol):
    """What the leader's law tracks: a wanted motion for every time."""

    def at(self, t: float) -> PlannedMotion:
        """Wanted motion at a time.

        Args:
            t: time on the mission's clock [s].

        Returns:
            Wanted state and accelerations; the heading is not wrapped.
        """
        ...


@dataclass(frozen=True, slots=True)
class PlannedPath:
    """A path of arcs and straight lines, driven with a ramp of speed and then at cruise speed.

    Behind the last segment the path goes on with that segment's curvature: a robot never stands
    still unasked. At the joints the curvature jumps; omega_rate ignores the jump.

    Attributes:
        start: pose at t = 0 [m, m, rad].
        segments: pieces in driving order, at least one.
        cruise_speed: speed after the ramp [m/s].
        start_speed: speed at t = 0 [m/s].
        ramp_time: duration of the ramp, >= 0 [s].

    Raises:
        ControlError: if there is no segment, a length is not positive, or ramp_time is negative.
    """

    start: Pose2D
    segments: tuple[PathSegment, ...]
    cruise_speed: float
    start_speed: float = 0.0
    ramp_time: float = 0.0

    def __post_init__(self) -> None:
        if not self.segments or any(not segment.length > 0.0 for segment in self.segments):
            raise ControlError("a path needs at least one segment, every length > 0 m")
        if not self.ramp_time >= 0.0:
            raise ControlError(f"the ramp of a path must last >= 0 s, got {self.ramp_time} s")

    def at(self, t: float) -> PlannedMotion:
        """Wanted motion at a time, in closed form.

        Args:
            t: time on the mission's clock; before 0 the motion of 0 is given [s].

        Returns:
            Wanted state and accelerations; the heading is not wrapped.
        """
        way, v, v_rate = self._progress(max(t, 0.0))
        pose, curvature = self._place(way)
        state = UnicycleState(pose.x, pose.y, pose.theta, v, v * curvature)
        return PlannedMotion(state, v_rate, v_rate * curvature)

    def _progress(self, t: float) -> tuple[float, float, float]:
        """Way [m], speed [m/s] and acceleration [m/s^2] at t >= 0."""
        if t >= self.ramp_time:
            ramp_way = 0.5 * (self.start_speed + self.cruise_speed) * self.ramp_time
            return ramp_way + self.cruise_speed * (t - self.ramp_time), self.cruise_speed, 0.0
        v_rate = (self.cruise_speed - self.start_speed) / self.ramp_time
        return t * (self.start_speed + 0.5 * v_rate * t), self.start_speed + v_rate * t, v_rate

    def _place(self, way: float) -> tuple[Pose2D, float]:
        """Pose after a way [m], and the curvature there [1/m]."""
        pose, last = self.start, self.segments[-1]
        for segment in self.segments[:-1]:
            if way < segment.length:
                last = segment
                break
            pose = advance_pose(
                pose, Twist(segment.length, segment.length * segment.curvature), 1.0
            )
            way -= segment.length
        return advance_pose(pose, Twist(way, way * last.curvature), 1.0), last.curvature
