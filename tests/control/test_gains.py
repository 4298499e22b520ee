"""Certificates: where one holds the law holds s = 0, and the paper's pairs with their numbers."""

from math import exp, inf, isinf, pi, sqrt

import numpy as np
import pytest

from control.actuation import Actuation
from control.course import Motion, PairCourse, ideal_follower, pair_course
from control.follower import FollowerModel, FollowerSample, SlidingGains
from control.formation import Shape, ShapeReference
from control.gains import Certificate, certify, omega_for
from control.laws import Law
from control.output import LeaderMotion, WantedOutput, follower_output
from control.profile import TanhStep
from control.relative import Vector2, relative_state
from control.sliding import begin, follower_step
from control.unicycle import SpeedLimits, Twist, UnicycleState, advance_pose
from tests.control.courses import LEFT, slow_pair

D, TICK = 0.05, 0.001
UNLIMITED = FollowerModel(D, Actuation(0.05, SpeedLimits(1e5, 1e6), 1e6, 1e7))


def certificate_of(course: PairCourse, gains: SlidingGains, known: bool = False) -> Certificate:
    """A certificate of a follower that heads as its leader at first."""
    return certify(course, ideal_follower(course, 0.0, D), gains, D, known)


def accelerated(state: UnicycleState, u: Vector2, dt: float) -> UnicycleState:
    """A robot after a short time under constant accelerations."""
    v, omega = state.v + u[0] * dt, state.omega + u[1] * dt
    pose = advance_pose(state.pose, Twist(0.5 * (state.v + v), 0.5 * (state.omega + omega)), dt)
    return UnicycleState(pose.x, pose.y, pose.theta, v, omega)


def peaks(course: PairCourse, gains: SlidingGains, eps: Vector2, push: Vector2) -> Vector2:
    """Greatest |s| of both channels, a fast law on the model (3) along a course."""
    wanted, start = WantedOutput(tuple(course.wanted[0, :, 0])), course.output[0, :, 0]
    x, y = start[0] * np.cos(start[1]) - D, start[0] * np.sin(start[1])
    lead, own = UnicycleState(0.0, 0.0, 0.0, 0.0, 0.0), UnicycleState(x, y, 0.0, 0.0, 0.0)
    memory, found = None, np.zeros(2)
    for k in range(round(course.times[-1] / TICK)):
        known = LeaderMotion(lead.twist, (0.0, 0.0))
        relative = relative_state(lead.pose, own.pose, D)
        output = follower_output([relative], own.twist, [known], D)
        memory = memory or begin(output, wanted, (0.0, 0.0), gains)
        sample = FollowerSample(output, wanted, own.twist)
        memory, _ = follower_step(memory, sample, TICK, gains, UNLIMITED)
        found = np.maximum(found, np.abs((memory.distance.sliding, memory.bearing.sliding)))
        u = [(1.0 + e) * a + p for e, a, p in zip(eps, memory.acceleration, push, strict=True)]
        own = accelerated(own, (u[0], u[1]), TICK)
        pushed = course.leader.acceleration[:, int(k * TICK / 0.01)]
        lead = accelerated(lead, (float(pushed[0]), float(pushed[1])), TICK)
    return float(found[0]), float(found[1])


@pytest.mark.parametrize("law", [Law.SAMPLED_TWISTING, Law.SUBOPTIMAL, Law.FIRST_ORDER_SIGN])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_where_a_certificate_holds_s_stays_at_0(law: Law, sign: float) -> None:
    course, gains = slow_pair(0.015, law)
    assert certificate_of(course, gains).run.holds
    eps, push = (0.015 * sign, -0.015), (0.05 * sign, 0.5)
    found = peaks(course, gains, eps, push)
    # sampling leaves |s| of some mu tau^2, s of (16) lambda tau
    assert max(found) < (0.02 if law == Law.FIRST_ORDER_SIGN else 2e-4)


def test_where_gains_do_not_do_s_leaves_0() -> None:
    course, gains = slow_pair(0.0, Law.SAMPLED_TWISTING, mu=0.2, nu=0.1)
    certificate = certificate_of(course, gains)
    assert not certificate.exact.holds
    assert max(peaks(course, gains, (0.0, 0.0), (0.0, 0.5))) > 0.02


def test_omega_is_a_tenth_wider_than_the_nominal_path() -> None:
    course, gains = slow_pair(0.0)
    assert omega_for(course, gains).bounds == pytest.approx((0.11, 0.33))
    assert omega_for(course, gains).invariant == pytest.approx((0.11, 0.33))  # from rest
    assert omega_for(course, gains).rates == pytest.approx((0.11 / exp(1.0), 0.33 / exp(1.0)))
    start = (0.0, 0.0), (0.1, 0.0)
    shape = [ShapeReference(0.5, LEFT)] * len(course.times)
    moving = pair_course(course.times, course.leader, shape, start, gains)
    bounds, widths = omega_for(moving, gains).bounds, omega_for(moving, gains).invariant
    assert bounds == pytest.approx((0.11 / exp(1.0), 0.1))  # t e^-t, and the least one
    assert widths[0] < bounds[0]


def paper_pair(distance: TanhStep, bearing: float, start: Vector2) -> PairCourse:
    """A pair of section V: 0 to 0.5 m/s in 1 s, a half-circle of 0.4 m from 2.6 to 5.11 s."""
    times = np.arange(0.0, 8.0, 0.01)
    v = np.minimum(0.5 * times, 0.5)
    omega = np.where((times >= 2.6) & (times < 5.11), 1.25, 0.0)
    rates = np.stack((np.where(times < 1.0, 0.5, 0.0), np.zeros_like(times)))
    shape = Shape(distance, TanhStep.constant(bearing))
    wanted = [shape.at(t) for t in times.tolist()]
    still = (start, (0.0, 0.0))
    return pair_course(times, Motion(np.stack((v, omega)), rates), wanted, still, SlidingGains())


def test_the_paper_s_gains_do_for_exact_robots_and_no_further() -> None:
    second = paper_pair(TanhStep(0.2, 0.15, 5.5), LEFT, (-0.15, -0.25 * pi))
    third = paper_pair(TanhStep(0.2, 0.3, 5.5), -LEFT, (-0.05, 0.25 * pi))
    for course, rho, exact in ((second, 2.223, True), (third, 2.888, True)):
        certificate = certificate_of(course, SlidingGains())
        assert certificate.exact.holds is exact
        assert certificate.exact.rho[1] == pytest.approx(rho, rel=2e-3)
        assert not certificate.run.holds
        assert certificate.needs is not None
        assert certificate.needs.gains is None  # 0.15 mu / 0.15 m comes back as more than mu
        assert (certificate.needs.pace, certificate.needs.spacing) == (None, None)
        assert certificate.needs.model_error is not None
        assert certificate.needs.model_error < 0.007
    # R2 begins 0.15 m from its place and is wanted as near as 0.15 m: Omega holds the leader
    everywhere = certificate_of(second, SlidingGains()).everywhere
    assert isinf(everywhere.rho[0])
    assert not everywhere.holds
    first_order = certificate_of(second, SlidingGains(Law.FIRST_ORDER_SIGN))
    assert first_order.run.holds
    assert not first_order.everywhere.holds


def test_the_steady_turn_by_hand() -> None:
    # In the turn R3, in its place at 0.2 m: l w^2 - v w sin psi and v w cos psi / l
    course = paper_pair(TanhStep.constant(0.2), -LEFT, (0.0, 0.0))
    rho = certificate_of(course, SlidingGains()).exact.rho
    assert rho == pytest.approx((0.2 * 1.25**2 + 0.625 * sqrt(0.5), 0.625 * sqrt(0.5) / 0.2))


def test_super_twisting_is_not_certified_over_omega() -> None:
    course, gains = slow_pair(0.0, Law.SUPER_TWISTING)
    certificate = certificate_of(course, gains)
    assert certificate.run.holds
    assert not certificate.everywhere.holds
    assert certificate.everywhere.conditions[0].needed == inf
