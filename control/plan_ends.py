"""How a plan leaves its start and reaches its goal: what the ends fix of its curve and its law.

With pace u = |P'| at an end, the robot has v = S' u, v' = S'^2 P''_along + S'' u and curvature
P''_across / u^2 there. An end slower than the pace of the way is reached by S', so that P keeps
its pace; a faster one by P.
"""

from dataclasses import dataclass
from math import hypot, sqrt

import numpy as np

from control.geometry import compose, inverse
from control.plan_problem import End
from control.plan_request import REST, PlanRequest
from control.spline_plan import SplinePlan

_LONGEST_RAMP = 1.0 / 3.0  # of the duration
_CRUISE = 0.95  # of the greatest speed, at which the way between short ramps is driven
_STEEPEST = 1.7  # over the mean slope: the steepest point of a ramp, and a little
_BY_LAW = 0.5  # up to this S' an acceleration at the start is one of S', beyond one of P


@dataclass(frozen=True, slots=True)
class Pacing:
    """How a way is spread over a duration.

    Attributes:
        ramp: duration of the ramps at both ends [s].
        pace: of the curve between them [m/s].
    """

    ramp: float
    pace: float


def pacing(request: PlanRequest, speed: float, duration: float, way: float) -> Pacing:
    """Long ramps where there is time, as long as the limits allow where there is not.

    Args:
        request: its goal's speed and limits.
        speed: at the start [m/s].
        duration: of the plan [s].
        way: its length, roughly [m].

    Returns:
        Ramps and pace.
    """
    mean, v, a = way / duration, greatest_speed(request), request.limits.v_rate
    lost = sum(max(0.0, 1.0 - end / mean) for end in (speed, request.goal_speed))
    ramp = _LONGEST_RAMP * duration
    if lost > 0.0:
        spare = 2.0 / lost * (duration - way / (_CRUISE * v))
        ramp = min(ramp, max(spare, _STEEPEST * mean / a))
    return Pacing(ramp, way / (duration - 0.5 * lost * ramp))


def least_duration(request: PlanRequest, way: float) -> float:
    """Time for a way at full speed, with full acceleration at its ends.

    Args:
        request: speeds at the ends, and limits.
        way: its length [m].

    Returns:
        The time [s].
    """
    a, ends = request.limits.v_rate, (request.start.v, request.goal_speed)
    v = min(greatest_speed(request), max(sqrt(way * a), *ends))
    return way / v + sum((v - end) ** 2 / (2.0 * a * v) for end in ends)


def greatest_speed(request: PlanRequest) -> float:
    """The least of all limits on a speed: of the leader, its followers and their wheels.

    Args:
        request: limits and places.

    Returns:
        The speed [m/s].
    """
    wheels = [min(place.speed_limit, place.wheel_speed) for place in request.places]
    return min([request.limits.v, *wheels])


@dataclass(frozen=True, slots=True)
class Departure:
    """The start of a curve and of its time law.

    Attributes:
        share: S' [1].
        slope: S'' [1/s].
        end: of the curve, seen from the start pose.
    """

    share: float
    slope: float
    end: End


def departure(request: PlanRequest, pace: float) -> Departure:
    """The start that a request asks for.

    Args:
        request: its start state and v_rate.
        pace: of the curve on the way [m/s].

    Returns:
        The start of the curve and its law.
    """
    v, omega, v_rate = request.start.v, request.start.omega, request.v_rate
    if v < REST:
        v, omega, v_rate = 0.0, 0.0, v_rate or 0.0
    share, speed = min(1.0, v / pace), max(v, pace)
    slope, along = 0.0, None
    if v_rate is not None and share <= _BY_LAW:
        slope, along = v_rate / speed, 0.0
    elif v_rate is not None:
        along = v_rate / share**2
    curvature = omega / v if v > 0.0 else 0.0
    return Departure(share, slope, End((0.0, 0.0), 0.0, speed, along, curvature * speed**2))


def departure_from(plan: SplinePlan, since: float) -> Departure:
    """A start that goes on as a plan does, with equal velocity and acceleration.

    Args:
        plan: the plan so far.
        since: time since its start, less than its duration [s].

    Returns:
        The start of the curve and its law.
    """
    s, share, slope, _ = plan.law.at(np.array([since]))[:, 0].tolist()
    _, (x1, y1), (x2, y2), _ = plan.derivatives(np.array([s]))[:, :, 0].tolist()
    speed = hypot(x1, y1)
    along, across = (x1 * x2 + y1 * y2) / speed, (x1 * y2 - y1 * x2) / speed
    return Departure(share, slope, End((0.0, 0.0), 0.0, speed, along, across))


def arrival(request: PlanRequest, pace: float) -> tuple[float, End]:
    """The goal that a request asks for: reached straight and with constant speed.

    Args:
        request: its start, goal and speed.
        pace: of the curve on the way [m/s].

    Returns:
        S' there, and the end of the curve, seen from the start pose [1].
    """
    goal = compose(inverse(request.start.pose), request.goal)
    speed = max(request.goal_speed, pace)
    share = min(1.0, request.goal_speed / pace)
    along = 0.0 if share > 0.0 else None
    return share, End((goal.x, goal.y), goal.theta, speed, along)
