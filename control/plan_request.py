"""What is asked of the planner: from where to where, among what, within which limits."""

from dataclasses import dataclass
from math import hypot, inf

from control.actuation import require_finite
from control.errors import ControlError
from control.geometry import Pose2D
from control.obstacles import Obstacle, borders
from control.safety import Arena
from control.unicycle import UnicycleState

SHORTEST_WAY = 1e-3
"""A goal closer to the start than this is no goal: plans do not turn on the spot [m]."""

REST = 1e-6
"""Speeds below this have no direction [m/s]."""

_ROUNDING = 1e-4  # a plan starts from where another one is, within its accuracy [1, m]


@dataclass(frozen=True, slots=True)
class LeaderLimits:
    """What a plan may ask of the leader: a part of what its motors can, the rest is for feedback.

    Attributes:
        v: forward speed, > 0 [m/s].
        omega: turning rate, > 0 [rad/s].
        v_rate: forward acceleration, > 0 [m/s^2].
        omega_rate: angular acceleration, > 0 [rad/s^2].

    Raises:
        ControlError: if a limit is not finite and positive.
    """

    v: float = 1.0
    omega: float = 5.0
    v_rate: float = 2.0
    omega_rate: float = 30.0

    def __post_init__(self) -> None:
        limits = (self.v, self.omega, self.v_rate, self.omega_rate)
        if not all(0.0 < limit < inf for limit in limits):
            raise ControlError(f"the leader's limits must be finite and > 0, got {self}")


@dataclass(frozen=True, slots=True)
class FollowerPlace:
    """Where a follower's camera point is about the leader, and what its wheels can.

    The point is rigid in the leader's frame, its follower drives along the point's own path. Its
    axle lags behind the point, which takes up to 2 % more than planned: leave a reserve, as
    feedback needs one too. (0, 0) puts the limit on the leader's own wheels.

    Attributes:
        x: forwards, < 0 behind the leader [m].
        y: to the left [m].
        wheel_speed: rim speed that no wheel may exceed, > 0 [m/s].
        track_width: between its wheels, >= 0 [m].

    Raises:
        ControlError: if a number is not finite, or the limit or the track width is none.
    """

    x: float
    y: float
    wheel_speed: float
    track_width: float

    def __post_init__(self) -> None:
        numbers = (self.x, self.y, self.wheel_speed, self.track_width)
        require_finite("place of a follower", *numbers)
        if not (self.wheel_speed > 0.0 and self.track_width >= 0.0):
            raise ControlError(f"a follower needs a wheel speed > 0, a track >= 0 m, got {self}")


@dataclass(frozen=True, slots=True)
class PlanRequest:
    """One task for the planner.

    The circle of ``clearance`` about the leader stays off every obstacle and inside the arena. It
    is the formation's radius, bodies included, plus alpha of (9), the accuracy of tracking.

    Attributes:
        start: pose and velocities of the leader; it drives forwards or stands.
        goal: wanted pose at the end [m, m, rad].
        goal_speed: wanted speed at the end, >= 0: 0 stands there, else straight on [m/s].
        duration: None finds the shortest of a few that does, > 0 [s].
        t_start: when the plan starts, on the mission's clock [s].
        clearance: about the leader, >= 0 [m].
        obstacles: where they are at t_start.
        arena: what the clearance must not leave.
        limits: of the leader.
        places: of the followers.

    Raises:
        ControlError: if a number is not usable, or the start is none that a plan can have.
    """

    start: UnicycleState
    goal: Pose2D
    goal_speed: float = 0.0
    duration: float | None = None
    t_start: float = 0.0
    clearance: float = 0.0
    obstacles: tuple[Obstacle, ...] = ()
    arena: Arena = Arena()  # noqa: RUF009 (immutable)
    limits: LeaderLimits = LeaderLimits()
    places: tuple[FollowerPlace, ...] = ()

    def __post_init__(self) -> None:
        s, g = self.start, self.goal
        require_finite("start of a plan", s.x, s.y, s.theta, s.v, s.omega)
        require_finite("goal of a plan", g.x, g.y, g.theta, self.goal_speed)
        require_finite("clearance and time of a plan", self.clearance, self.t_start)
        _require_sizes(self)
        _require_drivable(self)


def _require_sizes(request: PlanRequest) -> None:
    if not request.clearance >= 0.0:
        raise ControlError(f"the clearance of a plan must be >= 0 m, got {request.clearance:g} m")
    if request.duration is not None and not 0.0 < request.duration < inf:
        raise ControlError(f"the duration of a plan must be > 0 s, got {request.duration:g} s")
    way = hypot(request.goal.x - request.start.x, request.goal.y - request.start.y)
    if way < SHORTEST_WAY:
        raise ControlError(
            f"the goal is {1e3 * way:.2g} mm from the start: a plan needs a way of at least "
            f"{1e3 * SHORTEST_WAY:g} mm and does not turn on the spot"
        )


def _require_drivable(request: PlanRequest) -> None:
    start, limits = request.start, request.limits
    if start.v < 0.0 or request.goal_speed < 0.0:
        raise ControlError(
            f"plans drive forwards, got {start.v:g} m/s at the start and "
            f"{request.goal_speed:g} m/s at the goal; stop or turn round first"
        )
    if start.v < REST < abs(start.omega):
        raise ControlError(
            f"a plan from a standstill starts with omega 0, got {start.omega:g} rad/s; "
            "plan from the planned state, not from the seen one"
        )
    for what, has, most in (
        ("speed at the start", start.v, limits.v),
        ("turning rate at the start", abs(start.omega), limits.omega),
        ("speed at the goal", request.goal_speed, limits.v),
    ):
        if has > most * (1.0 + _ROUNDING):
            raise ControlError(f"{what}: {has:g} is beyond the leader's limit of {most:g}")


def require_room(request: PlanRequest) -> None:
    """Refuse a start or a goal that no plan can have, before one is searched.

    At the start all obstacles count, at the goal those that stay where they are.

    Args:
        request: start, goal, clearance, obstacles and arena.

    Raises:
        ControlError: if there is no room for the clearance; it says where and how much is missing.
    """
    for what, at in (("start", request.start.pose), ("goal", request.goal)):
        for o in request.obstacles:
            if what == "start" or o.vx == o.vy == 0.0:
                distance = hypot(at.x - o.x, at.y - o.y) - o.radius
                _require(request, distance, what, at, f"the obstacle at ({o.x:g}, {o.y:g}) m")
        for name, (nx, ny), reach in borders(request.arena):
            _require(request, nx * at.x + ny * at.y - reach, what, at, name)


def _require(request: PlanRequest, distance: float, what: str, at: Pose2D, thing: str) -> None:
    lack = request.clearance - distance
    if lack > _ROUNDING:
        raise ControlError(
            f"the {what} ({at.x:g}, {at.y:g}) m is {lack:.3g} m too close to {thing}; "
            "move it or use a smaller formation"
        )
