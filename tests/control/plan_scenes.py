"""Scenes for the planner's tests, and what a plan does seen from outside, by its motion alone."""

from dataclasses import replace
from math import cos, hypot, sin

import numpy as np
from numpy.typing import NDArray

from control.geometry import Pose2D, compose
from control.obstacles import Obstacle
from control.plan_request import FollowerPlace, LeaderLimits, PlanRequest
from control.spline_plan import SplinePlan
from control.unicycle import UnicycleState

Array = NDArray[np.float64]

AT_REST = UnicycleState(0.0, 0.0, 0.0, 0.0, 0.0)
LIMITS = LeaderLimits(v=0.8, omega=3.0, v_rate=1.5, omega_rate=15.0)
PLACES = tuple(
    FollowerPlace(-0.14, side * 0.14, wheel_speed=1.0, track_width=0.07) for side in (1.0, -1.0)
)
IN_THE_WAY = Obstacle(1.0, 0.05, 0.1)
BLOCKED = PlanRequest(
    AT_REST,
    Pose2D(2.0, 0.0, 0.0),
    limits=LIMITS,
    duration=5.0,
    obstacles=(IN_THE_WAY,),
    clearance=0.35,
    places=PLACES,
)
CROSSED = replace(
    BLOCKED,
    start=UnicycleState(0.0, 0.0, 0.0, 0.4, 0.0),
    goal=Pose2D(2.4, 0.3, 0.4),
    goal_speed=0.4,
    duration=6.0,
    obstacles=(Obstacle(1.1, -0.7, 0.1, 0.0, 0.25),),
)
TWO = replace(
    BLOCKED,
    goal=Pose2D(3.0, 0.0, 0.0),
    duration=7.0,
    obstacles=(IN_THE_WAY, Obstacle(2.0, -0.15, 0.1)),
)
HAIRPIN = replace(CROSSED, goal=Pose2D(0.0, 1.0, np.pi), obstacles=(), duration=None)
BEHIND = replace(BLOCKED, goal=Pose2D(-0.8, 0.2, 0.5), obstacles=(), duration=None)


def times(plan: SplinePlan, intervals: int = 400) -> Array:
    """Even times from start to goal [s]."""
    return np.linspace(plan.t_start, plan.t_end, intervals + 1)


def motions(plan: SplinePlan, at: Array) -> Array:
    """(7, n): x, y, theta, v, omega, v_rate, omega_rate."""
    rows = [plan.at(t) for t in at.tolist()]
    return np.array(
        [(m.state.x, m.state.y, m.state.theta, m.state.v, m.state.omega, m.v_rate, m.omega_rate)
         for m in rows]
    ).T  # fmt: skip


def follower_motion(plan: SplinePlan, at: Array, place: FollowerPlace) -> tuple[Array, Array]:
    """Speed of a point rigid in the leader's frame, and the turning rate of its direction.

    The direction comes from the place's velocity (v - omega y, omega x) in the leader's frame,
    its turning rate from central differences.
    """
    h = 1e-6 * plan.law.duration
    ends = []
    for t in (at - h, at + h):
        _, _, theta, v, omega, _, _ = motions(plan, t)
        ends.append(theta + np.arctan2(omega * place.x, v - omega * place.y))
    _, _, _, v, omega, _, _ = motions(plan, at)
    turn = (ends[1] - ends[0] + np.pi) % (2.0 * np.pi) - np.pi
    return np.hypot(v - omega * place.y, omega * place.x), turn / (2.0 * h)


def wheels(plan: SplinePlan, at: Array, place: FollowerPlace) -> Array:
    """Rim speed of the faster wheel of a follower that drives along its place's way [m/s]."""
    speed, turn = follower_motion(plan, at, place)
    faster: Array = speed + 0.5 * place.track_width * np.abs(turn)
    return faster


def least_clearance(plan: SplinePlan, request: PlanRequest, at: Array) -> float:
    """Least distance of the leader to an obstacle's edge [m]."""
    x, y, *_ = motions(plan, at)
    return min(
        hypot(px - o.x - t * o.vx, py - o.y - t * o.vy) - o.radius
        for o in request.obstacles
        for px, py, t in zip(x, y, at - plan.t_start, strict=True)
    )


def random_request(rng: np.random.Generator) -> PlanRequest:
    """One obstacle near the way to a goal further on, with time for it."""
    way, turn, end, share = rng.uniform((1.5, -0.5, -0.5, 0.35), (3.0, 0.5, 0.5, 0.65))
    goal = Pose2D(way * cos(turn), way * sin(turn), 2.0 * turn + end)
    x, y, radius = rng.uniform((-0.2, -0.2, 0.05), (0.2, 0.2, 0.15))
    obstacle = Obstacle(share * goal.x + x, share * goal.y + y, radius)
    speeds = rng.choice([0.0, 0.3], 2)
    return replace(
        BLOCKED,
        start=UnicycleState(0.0, 0.0, 0.0, speeds[0], 0.0),
        goal=goal,
        goal_speed=speeds[1],
        duration=way / rng.uniform(0.3, 0.45),
        obstacles=(obstacle,),
        clearance=0.25,
    )


def placed(pose: Pose2D, frame: Pose2D, mirror: float) -> Pose2D:
    """A pose mirrored at the x axis for -1, then placed in a frame."""
    return compose(frame, Pose2D(pose.x, mirror * pose.y, mirror * pose.theta))


def moved(request: PlanRequest, frame: Pose2D, mirror: float) -> PlanRequest:
    """The whole scene mirrored at the x axis for -1, then placed in a frame."""

    def obstacle(o: Obstacle) -> Obstacle:
        at = placed(Pose2D(o.x, o.y, 0.0), frame, mirror)
        c, s, vy = cos(frame.theta), sin(frame.theta), mirror * o.vy
        return Obstacle(at.x, at.y, o.radius, c * o.vx - s * vy, s * o.vx + c * vy)

    s = request.start
    start = placed(s.pose, frame, mirror)
    return replace(
        request,
        start=UnicycleState(start.x, start.y, start.theta, s.v, mirror * s.omega),
        goal=placed(request.goal, frame, mirror),
        obstacles=tuple(map(obstacle, request.obstacles)),
        places=tuple(replace(p, y=mirror * p.y) for p in request.places),
    )
