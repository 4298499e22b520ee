"""The first-order laws: Theorem 1's inequality with wrong masses, and what they leave of s."""

from dataclasses import replace
from math import cos, hypot, pi

import pytest
from hypothesis import given
from hypothesis import strategies as st

from control.actuation import Actuation
from control.errors import ControlError
from control.formation import ShapeReference
from control.laws import Law
from control.output import LeaderMotion, pair_output, wanted_output
from control.reaching import ReachingGains, reach, super_twist
from control.relative import RelativeState, Vector2, apply
from control.sliding import (
    FollowerMemory,
    FollowerModel,
    FollowerSample,
    SlidingGains,
    begin,
    follow,
)
from control.unicycle import SpeedLimits, Twist

WIDE = FollowerModel(0.05, Actuation(0.05, SpeedLimits(1e4, 1e6), 1e5, 1e7))  # never saturates
UNIT, ANGLE = st.floats(-1.0, 1.0), st.floats(-pi, pi)
FIRST_ORDER = [Law.FIRST_ORDER_SIGN, Law.FIRST_ORDER_LAYER, Law.FIRST_ORDER_IMPLICIT]
GAINS = SlidingGains(Law.FIRST_ORDER_SIGN)
RELATIVE = st.builds(RelativeState, st.floats(0.1, 1.0), ANGLE, ANGLE)
REFERENCE = st.builds(
    ShapeReference, st.floats(0.1, 1.0), ANGLE, UNIT, st.floats(-3, 3), st.floats(-2, 2), ANGLE
)
TWIST = st.builds(Twist, UNIT, st.floats(-5, 5))


@given(RELATIVE, REFERENCE, TWIST, TWIST, st.tuples(UNIT, UNIT), *[st.tuples(UNIT, UNIT)] * 2)
def test_theorem_1_holds_for_every_error_within_the_bounds(
    relative: RelativeState, reference: ShapeReference, own: Twist, leader: Twist,
    s: Vector2, errors: Vector2, push: Vector2,
) -> None:  # fmt: skip
    """d/dt |s|^2 / 2 <= -eta |s| in metres: the inequality at the end of the proof."""
    bounds = GAINS.reaching
    o = pair_output(relative, own, LeaderMotion(leader, (0.0, 0.0)), 0.05)
    sample = FollowerSample(o, wanted_output([reference]), own)
    memory = begin(o, sample.wanted, (0.0, 0.0), GAINS)
    shifted = FollowerMemory(  # L = 1: a shift of d is one of s
        replace(memory.distance, integral=memory.distance.integral + s[0]),
        replace(memory.bearing, integral=memory.bearing.integral + s[1]),
    )
    after, _ = follow(shifted, sample, 1e-3, GAINS, WIDE)
    u = [
        (1.0 + bounds.model_error * error) * a + bound * p
        for a, error, bound, p in zip(
            after.acceleration, errors, bounds.disturbance, push, strict=True
        )
    ]
    moved = apply(o.input_matrix, (u[0] - o.own[0], u[1] - o.own[1]))
    wanted, slope, size = sample.wanted, 0.0, 0.0
    for n, (channel, unit) in enumerate(((after.distance, 1.0), (after.bearing, o.size))):
        e2 = wanted.rate[n] - o.rate[n]
        e2_rate = wanted.acceleration[n] - moved[n] - o.drift[n]
        s_rate = e2_rate + 2.0 * e2 + channel.error  # (21)
        slope += unit * channel.sliding * unit * s_rate
        size = hypot(size, unit * channel.sliding)
    assert slope <= -bounds.margin * size + 1e-6 * (1.0 + abs(slope))


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
