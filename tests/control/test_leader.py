"""The planned path in closed form, and the first-order law that tracks it."""

from dataclasses import replace
from math import atan2, cos, hypot, nan, pi, sin

import pytest
from hypothesis import given
from hypothesis import strategies as st

from control.actuation import Actuation, DriveGain
from control.errors import ControlError
from control.geometry import Pose2D
from control.laws import LeaderLaw
from control.leader import LeaderGains, begin_leader, leader_step
from control.plan import PathSegment, Plan, PlannedMotion, PlannedPath
from control.relative import Vector2
from control.unicycle import SpeedLimits, Twist, UnicycleState, advance_lagged

ARC = PathSegment(pi * 0.4, 2.5)
PAPER = PlannedPath(Pose2D(0, 0, 0), (PathSegment(1.05), ARC, PathSegment(1.0)), 0.5, 0.0, 1.0)
GAINS, ACTUATION = LeaderGains(), Actuation()
KNOWN = (0.0, 0.0)  # errors of drive gains that the filter has found


def test_the_paper_s_path() -> None:
    joint = PAPER.at(2.6).state
    assert (joint.x, joint.y, joint.theta) == pytest.approx((1.05, 0.0, 0.0), abs=1e-12)
    turned = PAPER.at(2.6 + pi * 0.4 / 0.5).state
    assert (turned.x, turned.y, turned.theta) == pytest.approx((1.05, 0.8, pi), abs=1e-12)
    half = PAPER.at(0.5)
    assert (half.state.x, half.state.v, half.v_rate) == pytest.approx((0.0625, 0.25, 0.5))
    assert PAPER.at(3.0).state.omega == pytest.approx(1.25)
    assert PAPER.at(-1.0) == PAPER.at(0.0)


def test_the_path_goes_on_behind_its_end() -> None:
    path = PlannedPath(Pose2D(0, 0, 0), (PathSegment(0.5, 1.0),), 0.5)
    assert path.at(pi / 0.5).state.x == pytest.approx(0.0, abs=1e-12)  # half a circle of 1 m
    assert path.at(pi / 0.5).state.y == pytest.approx(2.0)


@given(st.floats(0.01, 7.9))
def test_velocities_are_the_derivative_of_the_pose(t: float) -> None:
    h = 1e-6
    a, b, motion = PAPER.at(t - h).state, PAPER.at(t + h).state, PAPER.at(t)
    if all(abs(t - joint) > 2 * h for joint in (1.0, 2.6, 2.6 + pi * 0.8)):
        assert hypot(b.x - a.x, b.y - a.y) / (2 * h) == pytest.approx(motion.state.v, abs=1e-7)
        assert (b.theta - a.theta) / (2 * h) == pytest.approx(motion.state.omega, abs=1e-7)
        assert (b.v - a.v) / (2 * h) == pytest.approx(motion.v_rate, abs=1e-7)


@pytest.mark.parametrize(
    "make",
    [
        lambda: PlannedPath(Pose2D(0, 0, 0), (), 0.5),
        lambda: PlannedPath(Pose2D(0, 0, 0), (PathSegment(0.0),), 0.5),
        lambda: PlannedPath(Pose2D(0, 0, 0), (PathSegment(1.0),), 0.5, 0.0, -1.0),
        lambda: LeaderGains(reaching=0.0),
    ],
)
def test_what_is_refused(make: object) -> None:
    with pytest.raises(ControlError):
        make()  # type: ignore[operator]


@pytest.mark.parametrize("t", [0.5, 2.0, 3.5, 7.0])
def test_on_its_plan_the_leader_accelerates_as_planned(t: float) -> None:
    planned = PAPER.at(t)
    memory = begin_leader(planned.state, planned, GAINS)
    after, _ = leader_step(memory, planned.state, planned, 0.005, GAINS, ACTUATION)
    assert after.acceleration == pytest.approx((planned.v_rate, planned.omega_rate), abs=1e-9)


def track(
    start: UnicycleState,
    gain: DriveGain,
    tick: float,
    plan: Plan = PAPER,
    gains: LeaderGains = GAINS,
    errors: Vector2 = (0.1, -0.1),
) -> list[tuple[float, float, float]]:
    """Ideal measurements: time, position error [m] and greatest |s| [m/s]."""
    state, rows = start, []
    memory = begin_leader(state, plan.at(0.0), gains)
    for i in range(round(8.0 / tick)):
        planned = plan.at(i * tick)
        memory, command = leader_step(memory, state, planned, tick, gains, ACTUATION, gain)
        off = hypot(planned.state.x - state.x, planned.state.y - state.y)
        rows.append((i * tick, off, max(map(abs, memory.sliding))))
        v, omega = gain.v * command.v, gain.omega * command.omega
        driven = Twist((1.0 + errors[0]) * v, (1.0 + errors[1]) * omega)
        state = advance_lagged(state, driven, tick, ACTUATION.lag)
    return rows


@pytest.mark.parametrize("gain", [DriveGain(), DriveGain(0.8, 1.2)])
def test_an_off_start_is_tracked_in_despite_wrong_gains(gain: DriveGain) -> None:
    rows = track(UnicycleState(-0.05, 0.05, 0.2, 0.0, 0.0), gain, 0.005)
    assert rows[0][2] < 1e-12  # s(0) = 0, equation (17)
    late = [off for t, off, _ in rows if t > 2.0]
    assert max(late) < 0.015  # m
    assert (sum(off**2 for off in late) / len(late)) ** 0.5 < 0.006


class FigureOfEight:
    """x = sin wt, y = sin 2wt / 2: a closed way that never stands still."""

    def at(self, t: float) -> PlannedMotion:
        """Wanted motion; accelerations by differences."""
        h = 1e-4
        before, now, after = (self.state(t + k * h) for k in (-1, 0, 1))
        return PlannedMotion(
            now, (after.v - before.v) / (2 * h), (after.omega - before.omega) / (2 * h)
        )

    def state(self, t: float) -> UnicycleState:
        """Pose and velocities, flat in (x, y)."""
        w = 0.6
        x1, y1 = w * cos(w * t), w * cos(2 * w * t)
        x2, y2 = -w * w * sin(w * t), -2 * w * w * sin(2 * w * t)
        v = hypot(x1, y1)
        return UnicycleState(
            sin(w * t), 0.5 * sin(2 * w * t), atan2(y1, x1), v, (x1 * y2 - y1 * x2) / v**2
        )


@pytest.mark.parametrize("law", list(LeaderLaw))
@pytest.mark.parametrize("tick", [0.005, 0.06])
def test_every_law_stays_on_its_way(law: LeaderLaw, tick: float) -> None:
    eight, gains = FigureOfEight(), LeaderGains(law=law)
    for plan in (PAPER, eight):
        rows = track(plan.at(0.0).state, DriveGain(), tick, plan, gains, KNOWN)
        late = [off for t, off, _ in rows if t > 2.0]
        assert (sum(off**2 for off in late) / len(late)) ** 0.5 < 0.015  # m


@pytest.mark.parametrize("law", list(LeaderLaw))
def test_every_law_comes_back_to_its_way(law: LeaderLaw) -> None:
    eight = FigureOfEight()
    off = replace(eight.at(0.0).state, x=-0.1, y=0.1, v=0.5)
    rows = track(off, DriveGain(), 0.01, eight, LeaderGains(law=law), KNOWN)
    assert rows[0][1] > 0.1
    assert max(off for t, off, _ in rows if t > 3.0) < 0.02


class HurryThenStroll:
    """Straight on, 0.6 m/s for four seconds and 0.1 m/s from then on."""

    def at(self, t: float) -> PlannedMotion:
        """Wanted motion."""
        x, v = (0.6 * t, 0.6) if t < 4.0 else (2.4 + 0.1 * (t - 4.0), 0.1)
        return PlannedMotion(UnicycleState(x, 0.0, 0.0, v, 0.0), 0.0, 0.0)


def test_a_leader_that_was_held_does_not_run_past_its_plan() -> None:
    plan, slow = HurryThenStroll(), Actuation(0.05, SpeedLimits(0.4, 15.0))
    state = UnicycleState(0.0, 0.0, 0.0, 0.4, 0.0)
    memory, ahead = begin_leader(state, plan.at(0.0), GAINS), []
    for i in range(2000):
        planned = plan.at(0.005 * i)
        memory, command = leader_step(memory, state, planned, 0.005, GAINS, slow)
        state = advance_lagged(state, command, 0.005, slow.lag)
        ahead.append(state.x - planned.state.x)
    assert min(ahead) < -0.7  # m
    assert max(ahead) < 0.05
    assert abs(ahead[-1]) < 0.005


def test_limits_hold_and_s_starts_at_zero_for_any_start() -> None:
    far = UnicycleState(3.0, -2.0, 2.0, 1.0, -4.0)
    memory = begin_leader(far, PAPER.at(3.0), GAINS)
    memory, command = leader_step(memory, far, PAPER.at(3.0), 0.06, GAINS, ACTUATION)
    assert max(map(abs, memory.sliding)) < 1e-12
    assert abs(command.v) <= ACTUATION.limits.v
    assert abs(command.omega) <= ACTUATION.limits.omega


def test_non_finite_input_is_refused_before_the_law() -> None:
    state = UnicycleState(0.0, 0.0, 0.0, 0.0, 0.0)
    memory = begin_leader(state, PAPER.at(0.0), GAINS)
    with pytest.raises(ControlError, match="leader's state"):
        leader_step(memory, replace(state, v=nan), PAPER.at(0.0), 0.005, GAINS, ACTUATION)
    with pytest.raises(ControlError, match="dt > 0"):
        leader_step(memory, state, PAPER.at(0.0), 0.0, GAINS, ACTUATION)
