"""The leader's plan in a run: what comes into its way is seen, and another way is asked for.

The planner takes its time, so a question goes out with one cycle and its answer comes in with a
later one. A plan that is found on the way begins a little ahead, where the old one will be then.
Where there is none in time, all stand, and a way from the standstill is asked for.
"""

from collections.abc import Mapping
from dataclasses import replace
from math import cos, hypot, inf, sin

from control.command import RobotId
from control.obstacles import Obstacle
from control.plan import PlannedMotion
from control.plan_request import REST, SHORTEST_WAY
from control.replanning import Answer, Question
from control.spline_plan import SplinePlan
from control.unicycle import UnicycleState
from datasets.cycle import SafetyEvent, Tick
from pipeline.course import ACCURACY
from pipeline.memory import Mission, Route, Track
from pipeline.setup import Setup

AHEAD = 0.3  # from a question to the start of the plan it asks for [s]
PAUSE = 0.2  # between two questions [s]
BRAKING = 0.3  # all stand this long before they would come too near [s]
TOLERANCE = 0.01  # of the clearance that plans are made with, before there is another one [m]
FORESIGHT = (0.0, 0.5, 1.0)  # what moves is looked for in all these places on its way [s]
STANDING = 0.03  # what is slower stands [m/s]
AT_ONCE = 0.1  # while all stand the mission's clock moves by the loop's jitter alone [s]

NOTHING_TOLD: tuple[str, ...] = ()
Tracks = Mapping[RobotId, Track]
Shares = Mapping[RobotId, float]


def wanted_motion(setup: Setup, route: Route, t: float) -> PlannedMotion | None:
    """What the leader's plan wants.

    Args:
        setup: with the first plan.
        route: the plans since.
        t: on the mission's clock [s].

    Returns:
        The motion; None without a plan.
    """
    plan = route.plan or setup.path
    if route.before is not None and isinstance(plan, SplinePlan) and t < plan.t_start:
        plan = route.before
    return plan.at(t) if plan else None


def renew(
    setup: Setup, route: Route, mission: Mission, tracks: Tracks, shares: Shares, tick: Tick
) -> tuple[Route, Shares, tuple[SafetyEvent, ...], tuple[str, ...]]:
    """Take the planner's answer, and look whether the way is still clear where something moves.

    Args:
        setup: the goal, and who is an obstacle.
        route: so far.
        mission: its clock.
        tracks: of the robots seen so far, rolled ahead.
        shares: of its speed that each robot may drive, from the safety rules.
        tick: the present inputs.

    Returns:
        The route, with a question if there is one; the shares, 0 for the leader while its way is
        blocked; a way that is newly blocked or free; what else is worth telling.
    """
    after, plan, notes = replace(route, question=None), route.plan or setup.path, NOTHING_TOLD
    if not setup.worn or mission.t_start is None or not isinstance(plan, SplinePlan):
        return after, shares, (), notes
    now = tick.t - mission.t_start
    if tick.answer is not None:
        after, notes = _answered(after, plan, tick.answer, now)
    if tick.frame is not None:
        after = _judged(setup, after, tracks, tick.t, now)
    if after.blocked:
        shares = {**shares, setup.formation.root: 0.0}
    return after, shares, _events(route, after, tick.t), notes


def _answered(
    route: Route, plan: SplinePlan, answer: Answer, now: float
) -> tuple[Route, tuple[str, ...]]:
    """The route with the new plan, if it fits: from the standstill now, or ahead on the way."""
    new = answer.plan
    if new is None:
        told = () if route.refused else (f"no other way: {answer.reason}",)
        return replace(route, refused=True), told
    early = new.t_start - now
    from_rest = new.at(new.t_start).state.v <= REST
    if not (from_rest and abs(early) < AT_ONCE if route.blocked else early > 0.0):
        return route, ("another way came too late and was not taken",)
    told = (f"another way from {new.t_start:.2f} s on: at the goal at {new.t_end:.2f} s",)
    before = None if route.blocked else plan
    return Route(new, answer.clearance, before, asked=route.asked), told


def _judged(setup: Setup, route: Route, tracks: Tracks, t: float, now: float) -> Route:
    """Whether the way is clear, blocked, or to be left for another one."""
    plan, errand = route.plan or setup.path, setup.errand
    assert isinstance(plan, SplinePlan)
    assert errand
    seen = _seen(setup, tracks)
    clearance = (route.clearance or errand.clearance) - TOLERANCE
    meets = plan.meets(now, seen, clearance) if now < plan.t_end else inf
    blocked = meets < inf if route.blocked else meets - now < BRAKING
    question = None
    driven = blocked or now >= plan.t_start  # not before the last one that was found
    if meets < inf and driven and t - route.asked >= PAUSE:
        question = _question(setup, plan, tracks, seen, now, blocked)
    return replace(route, question=question, asked=t if question else route.asked, blocked=blocked)


def _question(
    setup: Setup,
    plan: SplinePlan,
    tracks: Tracks,
    seen: tuple[Obstacle, ...],
    now: float,
    blocked: bool,
) -> Question | None:
    """Another way: from the place where the leader stands, or ahead on its way."""
    errand, t_start = setup.errand, now if blocked else now + AHEAD
    assert errand
    obstacles = (*(o.after(t_start) for o in errand.obstacles), *seen)
    request = replace(errand, t_start=t_start, obstacles=obstacles)
    if not blocked:
        return Question(request, plan)
    lead, goal = tracks[setup.formation.root].ahead, errand.goal
    if abs(lead.v) > STANDING or hypot(goal.x - lead.x, goal.y - lead.y) <= SHORTEST_WAY:
        return None  # it still drives, or has nowhere to go
    start = UnicycleState(lead.x, lead.y, lead.theta, 0.0, 0.0)
    room = min(hypot(o.x - lead.x, o.y - lead.y) - o.radius for o in obstacles)
    clearance = min(errand.clearance, max(room, errand.clearance - ACCURACY))
    return Question(replace(request, start=start, clearance=clearance), None)


def _seen(setup: Setup, tracks: Tracks) -> tuple[Obstacle, ...]:
    """Obstacles that wear a tag: where each is and where it goes, for it may stop anywhere."""
    return tuple(
        Obstacle(state.x + vx * later, state.y + vy * later, radius)
        for robot, radius in setup.worn.items()
        if robot in tracks
        for state in (tracks[robot].ahead,)
        for vx, vy in ((state.v * cos(state.theta), state.v * sin(state.theta)),)
        for later in (FORESIGHT if abs(state.v) > STANDING else FORESIGHT[:1])
    )


def _events(before: Route, after: Route, t: float) -> tuple[SafetyEvent, ...]:
    if after.blocked and not before.blocked:
        detail = "the way is blocked: all stand until it is free, or there is another one"
        return (SafetyEvent(t, "way-blocked", None, detail),)
    if before.blocked and not after.blocked:
        return (SafetyEvent(t, "way-free", None, "the way is free again"),)
    return ()
