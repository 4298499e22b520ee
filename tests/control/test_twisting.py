"""The twisting laws: the implicit inclusion, the published signs, what they leave of s."""

from dataclasses import replace
from math import sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from control.channel import ChannelMemory
from control.errors import ControlError
from control.laws import LAW_NAMES, Law, is_first_order, law_named
from control.twisting import (
    TwistingGains,
    implicit_twisting,
    last_extremum,
    sampled_twisting,
    suboptimal,
    twist,
)

GAINS = TwistingGains(20.0, 4.0, 0.05)
STATE = st.floats(-5.0, 5.0)


def in_sign(weight: float, argument: float, tolerance: float) -> tuple[float, float]:
    """The interval weight * Sgn(argument)."""
    if argument > tolerance:
        return weight, weight
    return (-weight, -weight) if argument < -tolerance else (-weight, weight)


@settings(max_examples=1000)
@given(STATE, STATE, st.floats(0.005, 0.3), st.floats(5.0, 30.0), st.floats(0.5, 4.5))
def test_implicit_solves_its_inclusion(
    s: float, rate: float, horizon: float, mu: float, nu: float
) -> None:
    v = implicit_twisting(s, rate, 0.0, 0.005, TwistingGains(mu, nu, horizon))
    tiny = 1e-12 * (abs(s) + abs(rate) + mu)
    a = in_sign((mu + nu) / 2, s + 1.5 * horizon * rate + horizon**2 * v, tiny)
    b = in_sign((mu - nu) / 2, rate + horizon * v, tiny)
    assert -a[1] - b[1] - 1e-9 <= v <= -a[0] - b[0] + 1e-9


@given(STATE, STATE)
def test_implicit_is_odd_and_bounded(s: float, rate: float) -> None:
    v = implicit_twisting(s, rate, 0.0, 0.005, GAINS)
    assert v == -implicit_twisting(-s, -rate, 0.0, 0.005, GAINS)
    assert abs(v) <= GAINS.mu


def test_far_away_implicit_is_plain_twisting() -> None:
    assert implicit_twisting(2.0, 1.0, 0.0, 0.005, GAINS) == -20.0
    assert implicit_twisting(2.0, -1.0, 0.0, 0.005, GAINS) == -4.0
    assert implicit_twisting(-2.0, 1.0, 0.0, 0.005, GAINS) == 4.0


def test_horizon_is_never_shorter_than_the_period() -> None:
    short = TwistingGains(20.0, 4.0, 0.001)
    exact = TwistingGains(20.0, 4.0, 0.06)
    for s, rate in ((0.01, 0.1), (-0.03, 0.2), (0.0, -0.3)):
        assert implicit_twisting(s, rate, 0.0, 0.06, short) == implicit_twisting(
            s, rate, 0.0, 0.06, exact
        )


@pytest.mark.parametrize(
    ("s", "change", "v"),
    [
        (0.1, 0.01, -20.0),
        (0.1, -0.01, -4.0),
        (-0.1, -0.01, 20.0),
        (-0.1, 0.01, 4.0),
        (0.1, 0.0, -4.0),  # Delta = 0: the first sample
        (-0.1, 0.0, 4.0),
        (0.0, 0.1, 0.0),
    ],
)
def test_published_signs(s: float, change: float, v: float) -> None:
    assert sampled_twisting(s, change, GAINS) == v


def left_over(law: Law, tau: float, noise: float = 0.0, seconds: float = 20.0) -> float:
    """Largest |s| of s'' = v + 2 sin t in the second half, s seen within +-noise [m]."""
    rng, gains, fine = np.random.default_rng(1), TwistingGains(20.0, 4.0, tau), 60
    s, rate, worst, memory = 0.0, 0.0, 0.0, ChannelMemory(0.0, 0.0, 0.0)
    for i in range(int(seconds / tau)):
        seen = s + rng.uniform(-noise, noise)
        memory = replace(memory, sliding=seen, before=memory.sliding, before_that=memory.before)
        v, own = twist(memory, tau, gains, law)
        memory = replace(memory, applied=v, applied_before=memory.applied, own=own)
        for j in range(fine):
            acceleration = v + 2.0 * sin((i + j / fine) * tau)
            s += tau / fine * (rate + 0.5 * tau / fine * acceleration)
            rate += tau / fine * acceleration
        worst = max(worst, abs(s)) if i * tau > 0.5 * seconds else worst
    return worst


def test_what_the_laws_leave_at_60_ms() -> None:
    # control.md, section 3: 212, 12.6 and 0.81 mm; with 1 mm of noise 211, 15.1 and 7.5 mm
    assert 0.1 < left_over(Law.SAMPLED_TWISTING, 0.06) < 0.3
    assert 0.005 < left_over(Law.IMPLICIT_TWISTING, 0.06) < 0.013
    assert left_over(Law.COMPENSATED_TWISTING, 0.06) < 0.00085
    assert left_over(Law.IMPLICIT_TWISTING, 0.06, 0.001) < 0.018
    assert left_over(Law.COMPENSATED_TWISTING, 0.06, 0.001) < 0.009


@pytest.mark.parametrize("law", [Law.SAMPLED_TWISTING, Law.SUBOPTIMAL])
def test_switched_laws_leave_a_multiple_of_the_squared_period(law: Law) -> None:
    short, long = left_over(law, 0.005, seconds=8.0), left_over(law, 0.02, seconds=8.0)
    assert 8.0 < long / short < 32.0  # second order: 16 times for 4 times the period
    assert short < 100.0 * 0.005**2


@given(STATE, STATE)
def test_suboptimal_pushes_past_half_its_extremum(s: float, extremum: float) -> None:
    v = suboptimal(s, extremum, GAINS)
    assert v * (s - 0.5 * extremum) <= 0.0
    on_the_way_back = (s - 0.5 * extremum) * (extremum - s) > 0.0
    assert v == 0.0 or abs(v) == (GAINS.nu if on_the_way_back else GAINS.mu)


@pytest.mark.parametrize(
    ("before_that", "before", "s", "extremum"),
    [(0.0, 0.3, 0.2, 0.3), (0.0, 0.1, 0.2, 9.0), (0.3, 0.1, 0.2, 0.1), (0.2, 0.2, 0.1, 9.0)],
)
def test_extremum_is_where_the_change_turns_round(
    before_that: float, before: float, s: float, extremum: float
) -> None:
    memory = ChannelMemory(0.0, 0.0, 0.0, s, before, before_that, own=9.0)
    assert last_extremum(memory) == extremum


def test_names() -> None:
    assert LAW_NAMES[:2] == ("implicit-twisting", "compensated-twisting")
    assert [law_named(name) for name in LAW_NAMES] == list(Law)
    assert [law for law in Law if not is_first_order(law)] == list(Law)[:4]
    with pytest.raises(ControlError, match=r"no law 'magic'.*implicit-twisting"):
        law_named("magic")


@pytest.mark.parametrize("bad", [(4.0, 20.0, 0.05), (20.0, 0.0, 0.05), (20.0, 4.0, 0.0)])
def test_gains_are_checked(bad: tuple[float, float, float]) -> None:
    with pytest.raises(ControlError, match="0 < nu < mu"):
        TwistingGains(*bad)
