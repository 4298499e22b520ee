"""The loop closed over a plan: the leader tracks it, followers hold rigid places, wheels can."""

from dataclasses import replace
from math import atan2, cos, hypot, pi, sin

import numpy as np
import pytest

from control.formation import Formation, Pair, Shape
from control.geometry import Pose2D
from control.obstacles import Obstacle
from control.plan_request import FollowerPlace, PlanRequest
from control.planner import plan
from control.profile import TanhStep
from control.spline_plan import SplinePlan
from control.unicycle import Twist, wheels_from_twist
from tests.control.plan_scenes import AT_REST, LIMITS
from tests.control.small_world import CAMERA_OFFSET, Case, SmallWorld

TRACK, WHEELS = 0.07, 0.62  # m, m/s: what the robots are said to have
FEEDBACK = 0.9  # of which a plan may use so much; the rest is for the control law
DISTANCE, BEARING = 0.2, 3.0 * pi / 4.0
PLACES = tuple(
    FollowerPlace(
        DISTANCE * cos(BEARING),
        side * DISTANCE * sin(BEARING),
        wheel_speed=FEEDBACK * WHEELS,
        track_width=TRACK,
    )
    for side in (1.0, -1.0)
)
ALPHA = 0.01  # m: accuracy of tracking (9)
REQUEST = PlanRequest(
    AT_REST,
    Pose2D(1.4, 0.6, pi / 2.0),
    limits=LIMITS,
    duration=5.5,
    obstacles=(Obstacle(0.7, 0.1, 0.05),),
    clearance=DISTANCE + ALPHA,
    places=PLACES,
)


def formation() -> Formation:
    """Both followers behind their leader, left and right."""
    shapes = (Shape(TanhStep.constant(DISTANCE), TanhStep.constant(s * BEARING)) for s in (1, -1))
    return Formation(tuple(Pair(1, k, shape) for k, shape in enumerate(shapes, 2)))


class WatchedWorld(SmallWorld):
    """It keeps the true wheel speeds of the followers, and how far camera points are off."""

    def run_watched(self) -> tuple[float, float]:
        """Greatest wheel speed [m/s], and least distance of a camera point to the obstacle [m]."""
        self.wheels, self.nearest = 0.0, np.inf
        self.run()
        return self.wheels, float(self.nearest)

    def advance(self, t: float, dt: float) -> None:
        super().advance(t, dt)
        obstacle = REQUEST.obstacles[0]
        for robot in (2, 3):
            s = self.truth[robot]
            rims = wheels_from_twist(s.twist, TRACK)
            self.wheels = max(self.wheels, abs(rims.left), abs(rims.right))
            x, y = s.x + CAMERA_OFFSET * cos(s.theta), s.y + CAMERA_OFFSET * sin(s.theta)
            gap = hypot(x - obstacle.x, y - obstacle.y) - obstacle.radius
            self.nearest = min(self.nearest, gap)


def driven(found: SplinePlan) -> tuple[float, float]:
    """Followers start at their places; small noise, no gain errors, the camera's usual delay."""
    start = {1: Pose2D(0.0, 0.0, 0.0)}
    for k, place in enumerate(PLACES, 2):
        start[k] = Pose2D(place.x - CAMERA_OFFSET, place.y, 0.0)
    case = Case(formation(), found, start, found.law.duration + 1.0, gain_errors=(0.0, 0.0))
    return WatchedWorld(replace(case, noise=(1e-4, 1e-3), feed_forward=True)).run_watched()


def dragged(found: SplinePlan, place: FollowerPlace) -> float:
    """Greatest wheel speed of a follower whose camera point is always at its place [m/s]."""
    dt, theta, fastest = 0.005, found.heading, 0.0
    for t in np.arange(found.t_start, found.t_end, dt).tolist():
        s = found.at(t).state
        ahead, left = s.v - s.omega * place.y, s.omega * place.x
        off = s.theta + atan2(left, ahead) - theta  # from its heading to its point's direction
        v, omega = hypot(ahead, left) * cos(off), hypot(ahead, left) * sin(off) / CAMERA_OFFSET
        rims = wheels_from_twist(Twist(v, omega), place.track_width)
        fastest = max(fastest, abs(rims.left), abs(rims.right))
        theta += omega * dt
    return fastest


@pytest.mark.parametrize("place", PLACES)
def test_rigid_followers_need_what_was_planned_for_them(place: FollowerPlace) -> None:
    slow = replace(REQUEST, duration=None)
    for found in (plan(REQUEST), plan(slow)):
        assert dragged(found, place) <= place.wheel_speed * 1.03  # axles lag their points


def test_followers_wheels_obey_their_limits_along_a_plan() -> None:
    wheels, nearest = driven(plan(REQUEST))
    assert wheels <= WHEELS  # m/s
    assert nearest >= 0.0  # m: no follower's camera point meets the obstacle


def test_a_plan_that_minds_its_leader_alone_asks_too_much_of_them() -> None:
    wheels, _ = driven(plan(replace(REQUEST, places=())))
    assert wheels > WHEELS
