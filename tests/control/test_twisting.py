"""The twisting laws: the implicit inclusion, the published signs, what they leave of s."""

from math import sin

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from control.errors import ControlError
from control.twisting import (
    TWISTING_LAWS,
    TwistingGains,
    implicit_twisting,
    sampled_twisting,
    twisting_law,
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
    assert sampled_twisting(s, 99.0, change, 0.06, GAINS) == v


def left_over(law: str, tau: float) -> float:
    """Largest |s| of s'' = v + 2 sin t after 10 s, rate from outputs alone."""
    step, (s, rate, old, v) = twisting_law(law), (0.0, 0.0, 0.0, 0.0)
    gains, worst, fine = TwistingGains(20.0, 4.0, tau), 0.0, 60
    for i in range(int(20.0 / tau)):
        v = step(s, (s - old) / tau + 0.5 * tau * v, s - old, tau, gains)
        old = s
        for j in range(fine):
            acceleration = v + 2.0 * sin((i + j / fine) * tau)
            s += tau / fine * (rate + 0.5 * tau / fine * acceleration)
            rate += tau / fine * acceleration
        worst = max(worst, abs(s)) if i * tau > 10.0 else worst
    return worst


def test_implicit_leaves_a_tenth_of_what_sampled_leaves_at_60_ms() -> None:
    assert 0.005 < left_over("implicit-twisting", 0.06) < 0.016  # design: 12.6 mm
    assert left_over("sampled-twisting", 0.06) > 0.1  # design: 212 mm


def test_names() -> None:
    assert TWISTING_LAWS == ("implicit-twisting", "sampled-twisting")
    with pytest.raises(ControlError, match=r"no twisting law 'magic'.*implicit-twisting"):
        twisting_law("magic")


@pytest.mark.parametrize("bad", [(4.0, 20.0, 0.05), (20.0, 0.0, 0.05), (20.0, 4.0, 0.0)])
def test_gains_are_checked(bad: tuple[float, float, float]) -> None:
    with pytest.raises(ControlError, match="0 < nu < mu"):
        TwistingGains(*bad)
