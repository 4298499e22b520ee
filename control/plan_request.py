"""What is asked of the planner: from where to where, among what, within which limits."""

from dataclasses import dataclass
from math import hypot, inf

from control.actuation import require_finite
from control.errors import ControlError
from control.geometry import Pose2D
from control.obstacles import Arena, Obstacle
from control.unicycle import UnicycleState

SHORTEST_WAY = 1e-3
"""A goal closer to the start than this is no goal: the planner does not turn on the spot [m]."""

REST = 1e-9
"""Speeds below this are a standstill [m/s]."""

_ROUNDING = 1e-6  # a plan starts from the state that another one has reached


@dataclass(frozen=True, slots=True)
class LeaderLimits:
    """What a plan may ask of the leader; a part of what its motors can, the rest is for feedback.

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

    The point is rigid in the leader's frame; the follower drives along the point's own path. A
    place at (0, 0) puts the same limits on the leader's own wheels.

    Attributes:
        x: forwards, < 0 behind the leader [m].
        y: to the left [m].
        speed_limit: of the follower, > 0 [m/s].
        turn_limit: of the follower, > 0 [rad/s].
        wheel_speed: rim speed that no wheel may exceed, > 0 [m/s].
        track_width: between its wheels, >= 0 [m].

    Raises:
        ControlError: if the place is not finite, a limit not positive or the track width negative.
    """

    x: float
    y: float
    speed_limit: float = inf
    turn_limit: float = inf
    wheel_speed: float = inf
    track_width: float = 0.0

    def __post_init__(self) -> None:
        require_finite("place of a follower", self.x, self.y, self.track_width)
        limits = (self.speed_limit, self.turn_limit, self.wheel_speed)
        if not (all(limit > 0.0 for limit in limits) and self.track_width >= 0.0):
            raise ControlError(f"limits of a follower must be > 0, its track >= 0 m, got {self}")


@dataclass(frozen=True, slots=True)
class Resolution:
    """How finely a plan is described and checked.

    Attributes:
        control_points: of the spline, at least 8 and degree + 3.
        degree: of the spline, at least 4: its third derivative is continuous.
        nodes: times at which the constraints are collocated, at least 2 per control point.

    Raises:
        ControlError: if a number is too small.
    """

    control_points: int = 12
    degree: int = 5
    nodes: int = 41

    def __post_init__(self) -> None:
        least = max(self.degree + 3, 8)
        if self.degree < 4 or self.control_points < least or self.nodes < 2 * self.control_points:
            raise ControlError(
                f"a plan needs degree >= 4, control points >= {least} and twice as many nodes, "
                f"got {self.degree}, {self.control_points}, {self.nodes}"
            )


@dataclass(frozen=True, slots=True)
class PlanRequest:
    """One task for the planner.

    The circle of ``clearance`` about the leader stays off every obstacle and inside the arena. It
    is the formation's radius plus alpha of (9), the accuracy of tracking (Remark 4).

    Attributes:
        start: pose and velocities of the leader; it drives forwards or stands.
        goal: wanted pose at the end [m, m, rad].
        goal_speed: wanted speed at the end, >= 0: 0 stands there, else straight on [m/s].
        limits: of the leader.
        v_rate: forward acceleration at the start; None leaves it open while driving, and is 0
            at a standstill [m/s^2].
        duration: None finds the shortest of a few that does, > 0 [s].
        t_start: when the plan starts, on the mission's clock [s].
        arena: None is an unbounded floor.
        obstacles: where they are at t_start.
        clearance: about the leader, >= 0 [m].
        places: of the followers.
        resolution: of the spline and its nodes.

    Raises:
        ControlError: if a number is not usable, or the start is none that a plan can have.
    """

    start: UnicycleState
    goal: Pose2D
    goal_speed: float = 0.0
    limits: LeaderLimits = LeaderLimits()
    v_rate: float | None = None
    duration: float | None = None
    t_start: float = 0.0
    arena: Arena | None = None
    obstacles: tuple[Obstacle, ...] = ()
    clearance: float = 0.0
    places: tuple[FollowerPlace, ...] = ()
    resolution: Resolution = Resolution()

    def __post_init__(self) -> None:
        s, g = self.start, self.goal
        require_finite("start of a plan", s.x, s.y, s.theta, s.v, s.omega, self.v_rate or 0.0)
        require_finite("goal of a plan", g.x, g.y, g.theta, self.goal_speed)
        require_finite("clearance and time of a plan", self.clearance, self.t_start)
        _require_sizes(self)
        _require_drivable(self)


def _require_sizes(request: PlanRequest) -> None:
    if not request.clearance >= 0.0:
        raise ControlError(f"the clearance of a plan must be >= 0 m, got {request.clearance} m")
    if request.duration is not None and not 0.0 < request.duration < inf:
        raise ControlError(f"the duration of a plan must be > 0 s, got {request.duration} s")
    way = hypot(request.goal.x - request.start.x, request.goal.y - request.start.y)
    if way < SHORTEST_WAY:
        raise ControlError(
            f"the goal is {1e3 * way:.2g} mm from the start: a plan needs a way of at least "
            f"{1e3 * SHORTEST_WAY:g} mm and does not turn on the spot"
        )


def _require_drivable(request: PlanRequest) -> None:
    start, limits, v_rate = request.start, request.limits, request.v_rate or 0.0
    if start.v < 0.0 or request.goal_speed < 0.0:
        raise ControlError(
            f"plans drive forwards, got {start.v:g} m/s at the start and "
            f"{request.goal_speed:g} m/s at the goal; stop or turn round first"
        )
    if start.v < REST and (abs(start.omega) > _ROUNDING or v_rate < 0.0):
        raise ControlError(
            f"a plan from a standstill starts with omega 0 and v_rate >= 0, got "
            f"{start.omega:g} rad/s and {v_rate:g} m/s^2; plan from the planned state, not the seen"
        )
    for what, has, most in (
        ("speed at the start", start.v, limits.v),
        ("turning rate at the start", abs(start.omega), limits.omega),
        ("acceleration at the start", abs(v_rate), limits.v_rate),
        ("speed at the goal", request.goal_speed, limits.v),
    ):
        if has > most * (1.0 + _ROUNDING):
            raise ControlError(f"{what}: {has:g} is beyond the leader's limit of {most:g}")


def require_room(request: PlanRequest) -> None:
    """Refuse a task whose start or goal no plan can reach, before one is searched.

    At the start all obstacles count, at the goal those that stay where they are.

    Args:
        request: start, goal, clearance, obstacles and arena.

    Raises:
        ControlError: if there is no room for the clearance; it says where and how much is missing.
    """
    for what, at in (("start", request.start.pose), ("goal", request.goal)):
        for obstacle in request.obstacles:
            free = obstacle.distance(at.x, at.y, 0.0) - request.clearance
            stays = what == "start" or obstacle.vx == obstacle.vy == 0.0
            if free < -_ROUNDING and stays:
                raise ControlError(
                    f"the {what} ({at.x:g}, {at.y:g}) m is {-free:.3g} m too close to the obstacle "
                    f"at ({obstacle.x:g}, {obstacle.y:g}) m; move it or use a smaller formation"
                )
        free = request.arena.distance(at.x, at.y) - request.clearance if request.arena else 0.0
        if free < -_ROUNDING:
            raise ControlError(
                f"the {what} ({at.x:g}, {at.y:g}) m with its clearance reaches {-free:.3g} m out "
                "of the arena; move it, enlarge the arena or use a smaller formation"
            )
