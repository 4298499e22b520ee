"""The motion planner of the formation's leader (ref. [18]): clear ways that followers can keep.

The leader is flat in (x, y), so a plan is a curve in time, p(t) = P(S(t)): P a clamped B-spline, S
a time law. The cost is the integral of |P'''|^2. Limits of the leader, wheels of the followers,
obstacles and the arena are collocated at nodes and checked between them; SLSQP finds the cheapest
curve that keeps them.

A formation leaves and reaches a standstill straight ahead, so that its followers' headings agree
with the leader's there.
"""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from importlib import import_module
from math import hypot, inf

import numpy as np

from control.detours import arc_ways, detours, driven, length
from control.errors import ControlError
from control.geometry import Pose2D
from control.motion_model import Array
from control.plan import PlannedPath
from control.plan_curves import End
from control.plan_failure import failure
from control.plan_problem import FINER, NODES, Problem, problem
from control.plan_request import REST, SHORTEST_WAY, PlanRequest, require_room
from control.plan_search import Attempt, search
from control.spline_plan import SplinePlan
from control.time_law import TimeLaw, ramps

DURATIONS = (1.2, 1.5, 1.9, 2.4, 3.2, 4.5)
"""What is tried if no duration is asked for, over the least that the limits allow."""

_WAYS = 2  # by arcs, that are tried
_RAMP = 2.0  # duration of a ramp over the least, which has the limit as its mean acceleration
_OVER = 1e-6  # a plan with less time left has been driven [s]
_CRUISE = 0.8  # of the greatest speed: ramps are longer if that leaves time


def load_libraries() -> None:
    """Import now what the first plan would wait for (half a second)."""
    for name in ("scipy.interpolate", "scipy.optimize"):
        import_module(name)


def plan(request: PlanRequest) -> SplinePlan:
    """A plan from the start to the goal.

    With a duration it is the cheapest one found; without, that of the shortest of a few durations
    that does. Ways on either side of every obstacle in the way are tried.

    Args:
        request: what is asked.

    Returns:
        The plan; it keeps every constraint, also between the nodes.

    Raises:
        ControlError: if no plan was found: which constraint fails, where, by how much, a remedy.
    """
    require_room(request)
    ways = _arc_ways(request)
    durations = [request.duration] if request.duration else _durations(request, length(ways[0]))
    return _first(_fresh(request, duration, ways) for duration in durations)


def replan(old: SplinePlan, t: float, request: PlanRequest) -> SplinePlan:
    """A plan that goes on from another one: equal pose, velocities and accelerations at t.

    The old way is tried first, and kept on its side of every obstacle if that does. Without a
    duration it takes what is left of the old plan, or longer if it must.

    Args:
        old: the plan so far.
        t: when the new plan starts, on the mission's clock [s].
        request: goal, limits, and obstacles as they are at t; its start and t_start are those of
            the old plan at t.

    Returns:
        The new plan, from t on; the old one if that has reached the goal.

    Raises:
        ControlError: if t lies before the old plan, or no plan was found.
    """
    if not old.t_start <= t < inf:
        raise ControlError(f"a plan that starts at {old.t_start:g} s cannot be left at {t:g} s")
    here, (end,) = old.at(t).state, old.way(old.t_end, 1).T
    left, off = (hypot(request.goal.x - x, request.goal.y - y) for x, y in ((here.x, here.y), end))
    over = t > old.t_end - _OVER
    if off < SHORTEST_WAY and (over or left < SHORTEST_WAY):
        return old
    request = replace(request, start=here, t_start=t)
    if over:
        return plan(request)
    require_room(request)
    return _first(_renewals(request, old, t))


def _first(attempts: Iterable[Attempt]) -> SplinePlan:
    """The first one that keeps the constraints, or the error of the one that comes closest."""
    tried = []
    for attempt in attempts:
        if attempt.keeps:
            return _finished(attempt)
        tried.append(attempt)
    raise failure(tried)


def _finished(attempt: Attempt) -> SplinePlan:
    task, (best, directions) = attempt.problem, attempt.problem.curves
    points, request = (best + directions @ attempt.w).T, task.request
    return SplinePlan(points, task.law, request.start.theta, request.t_start)


def _fresh(request: PlanRequest, duration: float, ways: list[PlannedPath]) -> Attempt:
    """The cheapest plan of a duration, round what is on ways by arcs."""
    start, way = request.start, length(ways[0])
    ramp, pace = _pacing(request, duration, way, start.v * duration / way)
    law = ramps(duration, ramp, _share(start.v, pace), 0.0, _share(request.goal_speed, pace))
    curvature = start.omega / start.v if start.v > REST else 0.0
    ends = _end(start.pose, start.v, pace, curvature), _end(request.goal, request.goal_speed, pace)
    task = problem(request, ends, law, way)
    return search(task, _guesses(task, ways))


def _renewals(request: PlanRequest, old: SplinePlan, t: float) -> Iterator[Attempt]:
    """For each duration the old way as it is, ways round what is on it, and ways by arcs."""
    arcs, rest, start = _arc_ways(request), old.law.rest(t - old.t_start), old.end_at(t)
    way = old.way(t, NODES)
    left = float(np.hypot(*np.diff(way)).sum())
    for duration in _times_left(request, rest.duration, length(arcs[0])):
        task = _renewed(request, start, rest, duration, left)
        yield search(task, [way])
        yield search(task, _round(task, way))
        task = _renewed(request, start, rest, duration, length(arcs[0]))
        yield search(task, _guesses(task, arcs))


def _times_left(request: PlanRequest, left: float, way: float) -> list[float]:
    """What is left of the old plan's time if that can do, then longer ones."""
    if request.duration:
        return [request.duration]
    distance = hypot(request.goal.x - request.start.x, request.goal.y - request.start.y)
    longer = [time for time in _durations(request, way) if time > left]
    return [left, *longer] if distance < left * _greatest_speed(request) else longer


def _renewed(
    request: PlanRequest, start: End, rest: TimeLaw, duration: float, way: float
) -> Problem:
    """To go on as an old plan does, by its own law in the time that it has left."""
    law, last, speed = rest, rest.paces[-1], request.goal_speed
    pace = speed / last if last > 0.0 else way / rest.end
    if duration != rest.duration or (last > 0.0) != (speed > 0.0):
        ramp, pace = _pacing(request, duration, way, rest.paces[0])
        law = ramps(duration, ramp, rest.paces[0], rest.slopes[0], _share(speed, pace))
    return problem(request, (start, _end(request.goal, speed, pace)), law, way)


def _guesses(task: Problem, ways: list[PlannedPath]) -> list[Array]:
    """Ways by arcs, driven by the task's law, round what is on them."""
    passed = task.law.at(task.t[::FINER])[0] / task.law.end
    return [found for way in ways for found in _round(task, driven(way, passed))]


def _pacing(request: PlanRequest, duration: float, way: float, first: float) -> tuple[float, float]:
    """Duration of the ramps, long where there is time [s]; pace of the curve on the way [m/s]."""
    mean, spare = way / duration, duration - way / (_CRUISE * _greatest_speed(request))
    lost = sum(1.0 - min(1.0, share) for share in (first, request.goal_speed / mean))
    least = _RAMP * mean / request.limits.v_rate
    ramp = min(duration / 3.0, max(least, 2.0 * spare / max(lost, 1.0)))
    return ramp, way / (duration - 0.5 * lost * ramp)


def _share(v: float, pace: float) -> float:
    """S' at an end."""
    return v / max(v, pace)


def _end(pose: Pose2D, v: float, pace: float, curvature: float = 0.0) -> End:
    """An end that is driven through steadily, or a standstill, which asks for less."""
    u = max(v, pace)
    return End(pose, (u, 0.0) if v > 0.0 else (u,), (0.0, curvature * u**2))


def _round(task: Problem, way: Array) -> list[Array]:
    inflated = (
        replace(o, radius=o.radius + task.request.clearance) for o in task.request.obstacles
    )
    return detours(way, task.t[::FINER], tuple(inflated))


def _arc_ways(request: PlanRequest) -> list[PlannedPath]:
    """Ways by arcs wide enough for followers to drive forwards."""
    reach = max((hypot(place.x, place.y) for place in request.places), default=0.0)
    radius = max(reach, _greatest_speed(request) / request.limits.omega)
    return arc_ways(request.start.pose, request.goal, radius)[:_WAYS]


def _durations(request: PlanRequest, way: float) -> list[float]:
    """Times for a way, over that at full speed with full acceleration at its ends."""
    a, ends = request.limits.v_rate, (request.start.v, request.goal_speed)
    v = min(_greatest_speed(request), max((way * a) ** 0.5, *ends))
    least = way / v + sum((v - end) ** 2 / (2.0 * a * v) for end in ends)
    return [factor * least for factor in DURATIONS]


def _greatest_speed(request: PlanRequest) -> float:
    return min([request.limits.v, *(place.wheel_speed for place in request.places)])
