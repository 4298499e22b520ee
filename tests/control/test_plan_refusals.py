"""What the planner refuses: bad input at once, and tasks without a plan, with the reason."""

from dataclasses import replace
from math import inf, nan

import pytest

from control.errors import ControlError
from control.geometry import Pose2D
from control.obstacles import Obstacle
from control.plan_request import FollowerPlace, LeaderLimits
from control.planner import plan, replan
from control.safety import Arena
from control.unicycle import UnicycleState
from tests.control.plan_scenes import BLOCKED, IN_THE_WAY, PLACES

ARENA = Arena(-1.0, -1.0, 3.0, 1.0)
WALL = tuple(Obstacle(1.0, 0.3 * k, 0.1) for k in (-2, 0, 2))
FAR_OUT = replace(PLACES[0], x=-1.0, y=1.0)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"duration": 1.0}, r"no plan in 1 s: .* times its limit at t = .* more time"),
        ({"duration": 1e-3}, r"no plan in 0.001 s: "),
        (
            {"obstacles": WALL, "arena": ARENA},
            r"distance to the obstacle at .* lacks 0\.\d+ m at t = .* m; .* another goal",
        ),
        (
            {"arena": Arena(-0.5, -0.45, 2.5, 0.45), "clearance": 0.3},
            r"lacks 0\.\d+ m at t",
        ),
        (
            {"goal": Pose2D(0.0, 1.5, 3.1), "obstacles": (), "places": (FAR_OUT,)},
            r"of the follower at \(-1, 1\) m needs .* times .* closer to the leader",
        ),
        (
            {"obstacles": (Obstacle(2.0, -1.5, 0.1, 0.0, 0.3),)},  # at the goal in time
            r"obstacle at \(2, -1.5\) m lacks 0.45 m at t = 5 s, \(2.00, 0.00\) m",
        ),
    ],
)
def test_what_cannot_be_planned_says_why(changes: dict[str, object], reason: str) -> None:
    with pytest.raises(ControlError, match=reason) as caught:
        plan(replace(BLOCKED, **changes))  # type: ignore[arg-type]
    assert "\n" not in str(caught.value)


def test_the_error_says_which_durations_were_tried() -> None:
    wall = replace(
        BLOCKED,
        goal=Pose2D(4.0, 0.0, 0.0),
        obstacles=(Obstacle(2.0, 0.0, 0.8),),
        arena=Arena(-1.0, -1.0, 5.0, 1.0),
        duration=None,
    )
    with pytest.raises(ControlError, match=r"no plan in \d.* s to .* s, at best in .* s: "):
        plan(wall)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"start": UnicycleState(nan, 0.0, 0.0, 0.0, 0.0)}, "start of a plan: not finite"),
        ({"start": UnicycleState(0.0, 0.0, 0.0, 0.0, inf)}, "start of a plan: not finite"),
        ({"start": UnicycleState(0.0, 0.0, 0.0, -0.1, 0.0)}, "forwards, got -0.1 m/s"),
        ({"start": UnicycleState(0.0, 0.0, 0.0, 0.0, 0.5)}, "standstill starts with omega 0"),
        ({"start": UnicycleState(0.0, 0.0, 0.0, 0.9, 0.0)}, "0.9 is beyond .* limit of 0.8"),
        ({"start": UnicycleState(0.0, 0.0, 0.0, 0.2, -3.5)}, "3.5 is beyond .* limit of 3"),
        ({"goal": Pose2D(0.0, 0.0, 0.0)}, "0 mm from the start.* does not turn on the spot"),
        ({"goal": Pose2D(1.0, inf, 0.0)}, "goal of a plan: not finite"),
        ({"goal_speed": -0.1}, "forwards, got .* -0.1 m/s at the goal"),
        ({"goal_speed": 0.9}, "speed at the goal: 0.9 is beyond"),
        ({"duration": 0.0}, "duration of a plan must be > 0 s"),
        ({"duration": nan}, "duration of a plan must be > 0 s"),
        ({"clearance": -0.1}, "clearance of a plan must be >= 0 m"),
        ({"clearance": nan}, "not finite"),
        ({"t_start": inf}, "not finite"),
        ({"obstacles": (Obstacle(0.3, 0.0, 0.1),)}, r"the start \(0, 0\) m is 0.15 m too close"),
        ({"obstacles": (Obstacle(2.0, 0.1, 0.1),)}, r"the goal \(2, 0\) m is 0.35 m too close"),
        (
            {"arena": Arena(-0.6, -1.5, 2.2, 1.5)},
            "goal .* 0.15 m too close to the arena's border x = 2.2",
        ),
        (
            {"arena": Arena(-0.2, -1.5, 2.6, 1.5)},
            "start .* 0.15 m too close to the arena's border x = -0.2",
        ),
    ],
)
def test_unusable_requests_are_refused_at_once(changes: dict[str, object], reason: str) -> None:
    with pytest.raises(ControlError, match=reason):
        plan(replace(BLOCKED, **changes))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "make",
    [
        lambda: Obstacle(0.0, 0.0, -0.1),
        lambda: Obstacle(nan, 0.0, 0.1),
        lambda: Obstacle(0.0, 0.0, 0.1, vx=inf),
        lambda: LeaderLimits(v=0.0),
        lambda: LeaderLimits(omega_rate=nan),
        lambda: FollowerPlace(nan, 0.0, 1.0, 0.1),
        lambda: FollowerPlace(0.0, 0.0, nan, 0.1),
        lambda: FollowerPlace(0.0, 0.0, -1.0, 0.1),
        lambda: FollowerPlace(0.0, 0.0, 1.0, -0.1),
    ],
)
def test_values_that_are_none_are_refused(make: object) -> None:
    with pytest.raises(ControlError):
        make()  # type: ignore[operator]


def test_replanning_refuses_times_before_its_plan_and_no_times() -> None:
    found = plan(replace(BLOCKED, t_start=10.0))
    for t in (9.9, nan, inf):
        with pytest.raises(ControlError, match="starts at 10 s cannot be left at"):
            replan(found, t, BLOCKED)
    with pytest.raises(ControlError, match="not finite"):
        found.clearance(nan, (IN_THE_WAY,))
    with pytest.raises(ControlError, match=r"the start .* too close"):
        replan(found, 12.5, replace(BLOCKED, obstacles=(Obstacle(1.0, -0.2, 0.3),)))
