"""What nobody can follow: finite commands meanwhile, no wind-up, and the place again afterwards."""

from collections.abc import Callable
from math import isfinite, pi

import pytest

from control.actuation import Actuation
from control.follower import FollowerMemory, FollowerModel, FollowerSample, SlidingGains
from control.formation import ShapeReference
from control.geometry import Pose2D
from control.laws import Law
from control.output import LeaderMotion, pair_output, wanted_output
from control.relative import relative_state
from control.sliding import begin, follower_step
from control.unicycle import SpeedLimits, Twist, UnicycleState, advance_lagged, advance_pose

TICK, D, LAG = 0.005, 0.05, 0.05
BEHIND = ShapeReference(0.25, 3 * pi / 4)
Rows = list[tuple[float, float, float]]


def drive(
    law: Law,
    lead: Callable[[float], Twist],
    seconds: float,
    limit: float = 1.5,
    start: UnicycleState | None = None,
    wanted: ShapeReference = BEHIND,
) -> Rows:
    """An ideal follower with a speed limit [m/s] behind any leader: time, errors of l and psi."""
    model = FollowerModel(D, Actuation(LAG, SpeedLimits(limit, 15.0)))
    leader, gains, rows = Pose2D(0.0, 0.0, 0.0), SlidingGains(law), Rows()
    own = start or UnicycleState(-0.25, 0.1, 0.0, lead(0.0).v, 0.0)
    memory: FollowerMemory | None = None
    for k in range(round(seconds / TICK)):
        twist = lead(k * TICK)
        relative = relative_state(leader, own.pose, D)
        output = pair_output(relative, own.twist, LeaderMotion(twist, (0.0, 0.0)), D)
        goal = wanted_output([wanted])
        memory = memory or begin(output, goal, output.rate, gains)
        memory, command = follower_step(
            memory, FollowerSample(output, goal, own.twist), TICK, gains, model
        )
        assert isfinite(command.v + command.omega)
        assert abs(command.v) <= limit
        assert abs(command.omega) <= 15.0
        rows.append((k * TICK, memory.distance.error, memory.bearing.error))
        own = advance_lagged(own, command, TICK, LAG)
        leader = advance_pose(leader, twist, TICK)
    return rows


def after(rows: Rows, t: float) -> Rows:
    """What came after a time [s]."""
    return [row for row in rows if row[0] >= t]


def off(rows: Rows, t: float) -> tuple[float, float]:
    """Greatest errors of distance [m] and bearing [rad] from a time on."""
    return max(abs(e) for _, e, _ in after(rows, t)), max(abs(psi) for *_, psi in after(rows, t))


SWITCHED = (Law.SAMPLED_TWISTING, Law.SUBOPTIMAL)  # chatter within these limits


def assert_in_place(rows: Rows, law: Law, t: float) -> None:
    """In its place from a time on: 1 cm and 0.05 rad."""
    distance, bearing = off(rows, t)
    slack = 6.0 if law in SWITCHED else 1.0
    assert distance < 0.01 * slack
    assert bearing < 0.05 * slack


def test_the_published_law_pays_back_what_its_wheels_could_not_do() -> None:
    """(31) is left as published: its integrals wind up."""
    rows = drive(Law.SAMPLED_TWISTING, hurried, 20.0, limit=0.4)
    assert max(e for _, e, _ in after(rows, 5.0)) > 0.1


def hurried(t: float) -> Twist:
    """A leader that runs away for four seconds, then goes slowly."""
    return Twist(0.5 if 1.0 < t < 5.0 else 0.2, 0.0)


@pytest.mark.parametrize("law", [law for law in Law if law != Law.SAMPLED_TWISTING])
def test_wheels_that_cannot_keep_up_for_seconds(law: Law) -> None:
    """No error of the other sign afterwards."""
    rows = drive(law, hurried, 20.0, limit=0.4)
    assert min(e for _, e, _ in rows) < -0.35
    assert max(e for _, e, _ in after(rows, 5.0)) < 0.03
    assert_in_place(rows, law, 16.0)


HARD: dict[str, Callable[[float], Twist]] = {
    "stops": lambda t: Twist(0.4 if t < 2.0 else 0.0, 0.0),
    "reverses": lambda t: Twist(0.3 if t < 2.0 else -0.2 if t < 4.0 else 0.3, 0.0),
    "turns on the spot": lambda t: Twist(0.0, 1.0 if 1.0 < t < 4.0 else 0.0),
}


@pytest.mark.parametrize("law", list(Law))
@pytest.mark.parametrize("how", HARD)
def test_leaders_that(how: str, law: Law) -> None:
    rows = drive(law, HARD[how], 14.0)
    distance, bearing = off(rows, 1.0)
    assert distance < 0.06  # also meanwhile
    assert bearing < 0.3
    assert_in_place(rows, law, 12.0)


@pytest.mark.parametrize("law", list(Law))
@pytest.mark.parametrize("start", [-0.05, -0.04, -0.06])
def test_robots_in_one_place(law: Law, start: float) -> None:
    """The camera point on the leader's axle, and a centimetre on either side: l = 0."""
    own = UnicycleState(start, 0.0, 0.0, 0.3, 0.0)
    rows = drive(law, lambda _: Twist(0.3, 0.0), 14.0, start=own)
    assert_in_place(rows, law, 12.0)


@pytest.mark.parametrize("law", list(Law))
@pytest.mark.parametrize("side", [0.15, -0.15])
def test_a_place_straight_behind_where_bearings_wrap(law: Law, side: float) -> None:
    """From the left and from the right the short way, whatever the sign of psi."""
    own = UnicycleState(-0.25, side, 0.0, 0.3, 0.0)
    rows = drive(law, lambda _: Twist(0.3, 0.0), 10.0, start=own, wanted=ShapeReference(0.25, pi))
    assert max(abs(psi) for *_, psi in rows) < 1.0
    assert_in_place(rows, law, 8.0)
