"""The motion planner of the formation's leader (ref. [18]): clear ways that followers can keep.

The leader is flat in (x, y), so a plan is a curve in time, p(t) = P(S(t)): P a clamped B-spline,
S a time law. The cost is the integral of squared jerk and a little acceleration. Limits of the
leader, control authority of the followers, obstacles and the arena are collocated at nodes, and
checked between them.

A robot at rest has no direction of motion. So P never stands still: S' alone falls to 0 at a
standstill, and heading and curvature are those of P. A formation leaves and reaches a standstill
straight ahead, so that its followers' headings agree with the leader's there.
"""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from math import cos, hypot, inf, isclose

import numpy as np

from control.actuation import require_finite
from control.detours import arc_ways, driven, length
from control.errors import ControlError
from control.geometry import Pose2D, compose, inverse
from control.motion_model import Array
from control.obstacles import Obstacle
from control.plan import PlannedPath
from control.plan_ends import (
    arrival,
    departure,
    departure_from,
    greatest_speed,
    least_duration,
    pacing,
)
from control.plan_frame import seen_from
from control.plan_outcome import failure, finished
from control.plan_request import SHORTEST_WAY, PlanRequest, require_room
from control.plan_search import FINER, Attempt, Task, prepare, search, solve
from control.spline_plan import SplinePlan
from control.time_law import ramps
from control.unicycle import UnicycleState

DURATIONS = (1.15, 1.4, 1.75, 2.2, 2.8, 3.6, 5.0)
"""What is tried if no duration is asked for, over the least that the leader's limits allow."""

STRETCHES = (1.0, 1.35, 2.0)
"""What is tried when replanning, over what is left of the old plan."""

_EASY = 3  # of DURATIONS, the one that is tried first
_WAYS = 2  # by arcs, that are tried


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
    ways = _ways(request)
    if request.duration is not None:
        return finished(_first([_fresh(request, request.duration, ways)]))
    least = least_duration(request, length(ways[0]))
    times = [factor * least for factor in DURATIONS]
    found = _first(_fresh(request, time, ways) for time in times[_EASY:])
    if found.task.law.duration == times[_EASY]:
        found = _shortened(found, length(ways[0]), times[:_EASY])
    return finished(found)


def replan(old: SplinePlan, t: float, request: PlanRequest) -> SplinePlan:
    """A plan that goes on from another one: equal position, velocity and acceleration at t.

    The old way is tried first, and kept on its side of every obstacle if that does; else all
    sides are tried. Without a duration it takes what is left of the old plan, or longer if it
    must. At the goal and behind it the old plan stays, or for another goal a fresh one is made.

    Args:
        old: the plan so far.
        t: when the new plan starts, on the mission's clock [s].
        request: goal, limits, and obstacles as they are at t; its start, v_rate and t_start are
            taken from the old plan.

    Returns:
        The new plan, from t on.

    Raises:
        ControlError: if t lies before the old plan, or no plan was found.
    """
    since = t - old.t_start
    if not 0.0 <= since < inf:
        raise ControlError(f"a plan that starts at {old.t_start:g} s cannot be left at {t:g} s")
    left, start = old.duration - since, old.at(t).state
    if _arrives(old, request.goal) and (left <= 0.0 or _apart(request.goal, start) < SHORTEST_WAY):
        return old
    if left <= 0.0:
        return plan(replace(request, start=start, v_rate=0.0, t_start=t))
    request = replace(request, start=start, v_rate=None, t_start=t)
    require_room(request)
    times = [left * stretch for stretch in STRETCHES]
    if request.duration is not None:
        times = [request.duration]
    return finished(_first(_renewed(request, old, since, time) for time in times))


def is_clear(plan: SplinePlan, t: float, obstacles: Iterable[Obstacle], clearance: float) -> bool:
    """Whether the rest of a plan stays off obstacles: if not, it is time to replan.

    Args:
        plan: the plan.
        t: now, on the mission's clock [s].
        obstacles: as they are now.
        clearance: wanted about the leader [m].

    Returns:
        True if no obstacle comes closer than the clearance until the plan's end.

    Raises:
        ControlError: if t or the clearance is not finite.
    """
    require_finite("time and clearance", t, clearance)
    end = plan.t_start + plan.duration
    times = np.linspace(t, max(t, end), FINER * (plan.resolution.nodes - 1) + 1)
    places = np.array([*plan.positions(times), times - t]).T.tolist()
    return all(o.distance(*place) >= clearance for o in obstacles for place in places)


def _first(attempts: Iterable[Attempt]) -> Attempt:
    """The first one that keeps the constraints, or the error of the one that comes closest."""
    tried = []
    for attempt in attempts:
        if attempt.keeps:
            return attempt
        tried.append(attempt)
    raise failure(tried)


def _arrives(old: SplinePlan, goal: Pose2D) -> bool:
    end = old.at(old.t_start + old.duration).state
    return _apart(goal, end) < SHORTEST_WAY and cos(goal.theta - end.theta) > 1.0 - 1e-6


def _apart(goal: Pose2D, state: UnicycleState) -> float:
    return hypot(goal.x - state.x, goal.y - state.y)


def _ways(request: PlanRequest) -> tuple[PlannedPath, ...]:
    """Ways by arcs wide enough for followers to drive forwards, the shortest first."""
    reach = max((hypot(place.x, place.y) for place in request.places), default=0.0)
    radius = max(reach, greatest_speed(request) / request.limits.omega)
    goal = compose(inverse(request.start.pose), request.goal)
    return arc_ways(Pose2D(0.0, 0.0, 0.0), goal, radius)


def _fresh_task(request: PlanRequest, duration: float, way: float) -> Task:
    spread = pacing(request, request.start.v, duration, way)
    origin, (last, end) = departure(request, spread.pace), arrival(request, spread.pace)
    law = ramps(duration, spread.ramp, origin.share, origin.slope, last)
    return prepare(request, law, (origin.end, end), way)


def _fresh(request: PlanRequest, duration: float, ways: tuple[PlannedPath, ...]) -> Attempt:
    """The plan of a duration, from the cheapest curve, or else from ways by arcs."""
    task = _fresh_task(request, duration, length(ways[0]))
    return search(task, _stages(task, ways))


def _stages(task: Task, ways: tuple[PlannedPath, ...]) -> Iterator[list[Array]]:
    yield [task.straightest]
    yield [driven(way, task.shares_of_way) for way in ways[:_WAYS]]


def _shortened(found: Attempt, way: float, times: list[float]) -> Attempt:
    """The same way in the shortest of some durations, the last one tried first."""
    for time in reversed(times):
        task = _fresh_task(found.task.request, time, way)
        shorter = solve(task, task.guess(found.positions[:, ::FINER]))
        if not shorter.keeps:
            break
        found = shorter
    return found


def _renewed(request: PlanRequest, old: SplinePlan, since: float, duration: float) -> Attempt:
    """The old way in a duration; if it does not do, a search that starts from it."""
    s0, s1 = old.law.at(np.array([since, old.duration]))[0]
    task = _renewed_task(request, old, since, duration)
    on_way = old.derivatives(s0 + task.shares_of_way * (s1 - s0))[0]
    old_way = seen_from(request.start.pose, on_way)
    kept = solve(task, task.guess(old_way))
    if kept.keeps:
        return kept
    return search(task, ([old_way], [task.straightest]))


def _renewed_task(request: PlanRequest, old: SplinePlan, since: float, duration: float) -> Task:
    """A task that starts as the old plan goes on; in the time it has left, by its own law."""
    origin, law = departure_from(old, since), old.law.rest(since)
    way, pace = _left(old, since)
    last, end = arrival(request, pace)
    if duration != law.duration or not isclose(last, law.paces[-1], abs_tol=1e-6):
        spread = pacing(request, request.start.v, duration, way)
        last, end = arrival(request, spread.pace)
        law = ramps(duration, spread.ramp, origin.share, origin.slope, last)
    return prepare(request, law, (origin.end, end), way)


def _left(plan: SplinePlan, since: float) -> tuple[float, float]:
    """Length of the rest of a plan's curve [m], and the pace at its end [m/s]."""
    s0, s1 = plan.law.at(np.array([since, plan.duration]))[0]
    paces = np.hypot(*plan.derivatives(np.linspace(s0, s1, FINER * plan.resolution.nodes))[1])
    return float(paces.mean() * (s1 - s0)), float(paces[-1])
