"""The first-order laws: Theorem 1's inequality with wrong masses, and what they leave of s."""

from dataclasses import replace
from math import cos, pi, sin, sqrt

import pytest
from hypothesis import given
from hypothesis import strategies as st

from control.actuation import Actuation
from control.errors import ControlError
from control.follower import FollowerMemory, FollowerModel, FollowerSample, SlidingGains
from control.formation import ShapeReference
from control.laws import Law
from control.output import (
    FollowerOutput,
    LeaderMotion,
    WantedOutput,
    output_error,
    pair_output,
    wanted_output,
)
from control.reaching import ReachingGains, reach, super_twist
from control.relative import RelativeState, Vector2, apply
from control.sliding import begin, follow
from control.unicycle import SpeedLimits, Twist

WIDE = FollowerModel(0.05, Actuation(0.05, SpeedLimits(1e4, 1e6), 1e5, 1e7))  # never saturates
UNIT, ANGLE = st.floats(-1.0, 1.0), st.floats(-pi, pi)
FIRST_ORDER = [Law.FIRST_ORDER_SIGN, Law.FIRST_ORDER_LAYER, Law.FIRST_ORDER_IMPLICIT]
RELATIVE = st.builds(RelativeState, st.floats(0.1, 1.0), ANGLE, ANGLE)
REFERENCE = st.builds(
    ShapeReference, st.floats(0.1, 1.0), ANGLE, UNIT, st.floats(-3, 3), st.floats(-2, 2), ANGLE
)
TWIST = st.builds(Twist, UNIT, st.floats(-5, 5))


CORNERS = [(a, b) for a in (-1.0, 1.0) for b in (-1.0, 1.0)]
DIRECTIONS = [
    (cos(a), sin(a)) for a in (0.01, 0.8, 1.56, 1.58, 2.4, 3.13, 3.15, 4.0, 4.7, 4.72, 5.5)
]


@given(RELATIVE, REFERENCE, TWIST, TWIST, st.sampled_from([-1.0, 0.0, 1.0]), st.booleans())
def test_theorem_1_holds_for_every_error_within_the_bounds(
    relative: RelativeState, reference: ShapeReference, own: Twist, leader: Twist,
    balance: float, pushed: bool,
) -> None:  # fmt: skip
    """d/dt |s|^2 / 2 <= -eta |s| in metres, at the corners of the bounds, whichever way s lies."""
    bounds = ReachingGains(0.1, 0.5, (0.2, 2.0) if pushed else (0.0, 0.0))
    gains = SlidingGains(Law.FIRST_ORDER_SIGN, reaching=bounds)
    o = pair_output(relative, own, LeaderMotion(leader, (0.0, 0.0)), 0.05)
    wanted = balanced(o, wanted_output([reference]), balance)
    memory, sample = begin(o, wanted, (0.0, 0.0), gains), FollowerSample(o, wanted, own)
    for direction in DIRECTIONS:
        s = 1e-3 * direction[0], 1e-3 * direction[1] / o.size
        after, _ = follow(shifted(memory, s), sample, 1e-3, gains, WIDE)
        for corner in CORNERS:
            slope = lyapunov_rate(o, wanted, after, (0.0, 0.0), corner, bounds)
            if pushed:
                slope = max(lyapunov_rate(o, wanted, after, p, corner, bounds) for p in CORNERS)
            assert slope <= -bounds.margin * 1e-3 + 1e-9 * (1.0 + abs(slope))


def balanced(o: FollowerOutput, wanted: WantedOutput, balance: float) -> WantedOutput:
    """The wanted output accelerated by F + balance (K e_2 + L e_1), where (20) has its extremes."""
    if balance == 0.0:
        return wanted
    e, own = output_error(o, wanted), apply(o.input_matrix, o.own)
    pull = [2.0 * (wanted.rate[n] - o.rate[n]) + e[n] for n in (0, 1)]
    asked = [o.drift[n] - own[n] + balance * pull[n] for n in (0, 1)]
    return replace(wanted, acceleration=(asked[0], asked[1]))


def shifted(memory: FollowerMemory, s: Vector2) -> FollowerMemory:
    """The memory with another s: L = 1, so a shift of d is one of s."""
    return FollowerMemory(
        replace(memory.distance, integral=memory.distance.integral + s[0]),
        replace(memory.bearing, integral=memory.bearing.integral + s[1]),
    )


def lyapunov_rate(
    o: FollowerOutput, wanted: WantedOutput, after: FollowerMemory, push: Vector2,
    errors: Vector2, bounds: ReachingGains,
) -> float:  # fmt: skip
    """d/dt |s|^2 / 2 in metres of a robot whose mass, inertia and floor are not as believed."""
    u = [
        (1.0 + bounds.model_error * errors[n]) * after.acceleration[n]
        + bounds.disturbance[n] * push[n]
        for n in (0, 1)
    ]
    moved, rate = apply(o.input_matrix, (u[0] - o.own[0], u[1] - o.own[1])), 0.0
    for n, (channel, unit) in enumerate(((after.distance, 1.0), (after.bearing, o.size))):
        e2_rate = wanted.acceleration[n] - moved[n] - o.drift[n]
        s_rate = e2_rate + 2.0 * (wanted.rate[n] - o.rate[n]) + channel.error  # (21)
        rate += unit * channel.sliding * unit * s_rate
    return rate


@pytest.mark.parametrize("law", FIRST_ORDER)
@given(st.floats(-2, 2), st.floats(0.1, 20.0))
def test_the_control_opposes_s_and_is_bounded(law: Law, s: float, strength: float) -> None:
    v = reach(s, strength, 0.01, 0.05, 0.02, law)
    assert v * s <= 0.0
    assert abs(v) <= strength
    assert v == -reach(-s, strength, 0.01, 0.05, 0.02, law)


@pytest.mark.parametrize(
    ("law", "v"),
    [
        (Law.FIRST_ORDER_SIGN, -4.0),
        (Law.FIRST_ORDER_LAYER, -2.0),  # half way into the layer
        (Law.FIRST_ORDER_IMPLICIT, -0.2),  # s / horizon
    ],
)
def test_how_they_differ_near_zero(law: Law, v: float) -> None:
    assert reach(0.01, 4.0, 0.01, 0.05, 0.02, law) == pytest.approx(v)


@given(st.floats(-1.0, 1.0), st.floats(-5.0, 5.0), st.floats(0.1, 20.0), st.floats(0.005, 0.1))
def test_super_twisting_solves_for_the_end_of_the_period(
    s: float, integral: float, lipschitz: float, tau: float
) -> None:
    """Where z cancels the disturbance and s does not reach 0 at once, s+ = s + tau (u + p)."""
    k1, k2 = 1.5 * sqrt(lipschitz), 1.1 * lipschitz
    u, after = super_twist(s, integral, lipschitz, tau)
    end, sign = s + tau * (u - integral), 1.0 if s > 0.0 else -1.0
    if abs(s) > tau**2 * k2:
        assert after == pytest.approx(integral - tau * k2 * sign)
        assert end * sign >= -1e-9 - tau**2 * k2
        rest = end + tau**2 * k2 * sign  # one more k2 than the integral has: settles in two periods
        assert u == pytest.approx(
            after - (k1 * sqrt(abs(rest)) + tau * k2) * sign, rel=1e-6, abs=1e-6
        )


def left_of_s(tau: float, start: float = 0.0, seconds: float = 20.0) -> tuple[float, float]:
    """Largest |s| of s' = u + 2 sin t under super-twisting: in the second half, and at all."""
    s, integral, late, ever = start, 0.0, 0.0, 0.0
    for i in range(round(seconds / tau)):
        u, integral = super_twist(s, integral, 2.0, tau)
        s += tau * u + 2.0 * (cos(i * tau) - cos((i + 1) * tau))  # exact
        ever = max(ever, abs(s))
        late = max(late, abs(s)) if i * tau > 0.5 * seconds else late
    return late, ever


@pytest.mark.parametrize("tau", [0.01, 0.06])
def test_super_twisting_leaves_the_squared_period(tau: float) -> None:
    late, _ = left_of_s(tau)
    assert 0.3 * tau**2 * 2.0 < late <= tau**2 * 2.0  # control.md: 7.2 mm at 60 ms


def test_super_twisting_comes_from_afar() -> None:
    late, ever = left_of_s(0.01, start=1.0)
    assert ever <= 1.05
    assert late <= 2.0 * 0.01**2


@pytest.mark.parametrize(
    "bad", [{"margin": 0.0}, {"layer": 0.0}, {"lipschitz": -1.0}, {"model_error": 0.8}]
)
def test_gains_are_checked(bad: dict[str, float]) -> None:
    with pytest.raises(ControlError, match="first-order laws need"):
        ReachingGains(**bad)
