"""Conditions on gains: plants at their worst obey and disobey them; needs are where they begin."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from control.conditions import Condition, Doubt, Needs, conditions, find_needs
from control.demands import ON_COURSE, Demands, demands
from control.follower import SlidingGains
from control.laws import Law
from control.reaching import ReachingGains
from control.twisting import TwistingGains, sampled_twisting, suboptimal
from tests.control.courses import slow_pair

D = 0.05
LOW, HIGH, RHO = 0.8, 1.2, 3.0
SECOND_ORDER = [Law.SAMPLED_TWISTING, Law.SUBOPTIMAL]


def plain(rho: float, l: float = 1.0) -> Demands:  # noqa: E741 (the paper's l)
    """The same disturbance in both channels, and nothing that model errors multiply but v."""
    one = np.ones(2)
    return Demands(rho * np.ones((2, 2)), 0.0 * one, 0.3 * one, False, l * one, l * one)


def needed(law: Law, gains: TwistingGains) -> dict[str, float]:
    """What is needed of mu and nu in the distance, its channels uncoupled."""
    demand = plain(RHO)
    alone = replace(demand, near=np.full(2, np.inf), far=np.zeros(2))
    found = conditions(SlidingGains(law, twisting=gains), alone, Doubt(0.2))
    return {c.name.split()[0]: c.needed for c in found if c.channel == "distance"}


def worst_swing(law: Law, gains: TwistingGains) -> float:
    """|s| at its next extremum over that at the last one, the plant at its worst."""
    s, rate, extremum, tick, change = 1.0, 0.0, 1.0, 2e-5, 0.0
    for _ in range(400_000):
        if law == Law.SUBOPTIMAL:
            v = suboptimal(s, extremum, gains)
        else:
            v = sampled_twisting(s, change, gains)
        speeds_up = rate == 0.0 or v * rate > 0.0
        v = v * (HIGH if speeds_up else LOW) - RHO  # towards and beyond 0 as fast as may be
        before, rate = rate, rate + v * tick
        change = rate * tick
        s += change
        if before < 0.0 <= rate:
            break
    return abs(s)


@pytest.mark.parametrize("law", SECOND_ORDER)
@pytest.mark.parametrize(("share", "shrinks"), [(1.03, True), (0.97, False)])
def test_mu_is_sharp(law: Law, share: float, shrinks: bool) -> None:
    nu = 5.0
    mu = share * needed(law, TwistingGains(100.0, nu))["mu"]
    assert (worst_swing(law, TwistingGains(mu, nu)) < 1.0) is shrinks


@pytest.mark.parametrize(("share", "comes"), [(1.05, True), (0.95, False)])
def test_nu_is_sharp(share: float, comes: bool) -> None:
    nu = share * needed(Law.SAMPLED_TWISTING, TwistingGains(100.0, 1.0))["nu"]
    gains, s, rate, change, tick = TwistingGains(100.0, nu), 0.1, -0.01, -1.0, 1e-4
    for _ in range(20_000):
        v = sampled_twisting(s, change, gains)
        rate += (LOW * v + RHO) * tick  # away from 0
        change = rate * tick
        s += change
        if s <= 0.0:
            break
    assert (s <= 0.0) is comes


def test_the_paper_s_form_is_met_where_channels_do_not_disturb_each_other() -> None:
    found = needed(Law.IMPLICIT_TWISTING, TwistingGains(20.0, 4.0))
    assert found == pytest.approx({"nu": RHO / LOW, "mu": HIGH * 4.0 / LOW + 2.0 * RHO / LOW})


@given(st.floats(0.1, 20.0), st.floats(0.3, 3.0), st.floats(0.0, 0.12), st.floats(0.0, 1.0),
       st.sampled_from([15.0, 50.0]), st.sampled_from(SECOND_ORDER))  # fmt: skip
def test_least_gains_and_greatest_error_are_edges(
    rho: float,
    l: float,  # noqa: E741 (the paper's l)
    error: float,
    push: float,
    nu: float,
    law: Law,
) -> None:
    demand, doubt = plain(rho, l), Doubt(error, push)

    def holds(gains: SlidingGains, doubt: Doubt) -> bool:
        return all(c.holds for c in conditions(gains, demand, doubt))

    def ask(gains: SlidingGains) -> Needs:
        needs = find_needs(gains, doubt, lambda *_: demand)
        assert needs is not None
        return needs

    given_gains = SlidingGains(law, twisting=TwistingGains(60.0, nu))
    least = ask(given_gains).gains
    if least is None:  # then more does not help
        assert not holds(SlidingGains(law, twisting=TwistingGains(1e7, 1e6)), doubt)
    else:
        for share, good in ((1.001, True), (0.999, False)):
            gains = TwistingGains(share * least[0], share * least[1])
            assert holds(SlidingGains(law, twisting=gains), doubt) is good
    most = ask(given_gains).model_error
    assert (most is None) is not holds(given_gains, Doubt(0.0, push))
    if most is not None:
        assert holds(given_gains, Doubt(0.999 * most, push))
        assert not holds(given_gains, Doubt(1.001 * most, push))


def slow_demands(gains: SlidingGains) -> Callable[[float, float], Demands]:
    course, _ = slow_pair(0.0)
    return lambda pace, added: demands(course.moved(pace, added), ON_COURSE, gains, D, False)


def test_pace_and_spacing_are_where_conditions_begin_to_hold() -> None:
    moved = slow_demands(SlidingGains())
    doubt = Doubt(0.0, 0.1)
    rho = moved(1.0, 0.0).disturbance(0.0, 0.1).max()
    gains = SlidingGains(twisting=TwistingGains(60.0, 0.9 * rho))
    needs = find_needs(gains, doubt, moved)
    assert needs is not None
    assert needs.pace is not None
    assert needs.spacing is not None

    def holds(pace: float, added: float) -> bool:
        return all(c.holds for c in conditions(gains, moved(pace, added), doubt))

    assert holds(needs.pace, 0.0)
    assert not holds(needs.pace + 0.01, 0.0)
    assert holds(1.0, needs.spacing)
    assert not holds(1.0, 0.8 * needs.spacing - 0.02)


def test_first_order_laws_need_one_number() -> None:
    gains = SlidingGains(Law.FIRST_ORDER_SIGN, reaching=ReachingGains(margin=0.3))
    (margin,) = conditions(gains, plain(100.0), Doubt(0.5, 9.0))  # lambda grows with the rest
    assert (margin.needed, margin.holds) == (0.3, True)  # equality is enough to stay on s = 0
    (told,) = conditions(gains, replace(plain(1.0), leader_known=True), Doubt(0.1))
    assert told.needed == pytest.approx(0.03)
    assert find_needs(gains, Doubt(), lambda *_: plain(1.0)) is None


def test_super_twisting_needs_a_greater_bound_of_the_rate() -> None:
    gains = SlidingGains(Law.SUPER_TWISTING, reaching=ReachingGains(lipschitz=10.0))

    def lip(model_error: float, rate: float) -> Condition:
        return conditions(gains, plain(1.0), Doubt(model_error), rate)[0]

    k1, k2 = 1.5 * 10.0**0.5, 11.0
    for g in (1.0, 0.9, 0.8):
        edge = min(g * k2, (g * k1) ** 2 - g * k2)
        assert lip(1.0 - g, 0.999 * edge).holds
        assert not lip(1.0 - g, 1.001 * edge).holds
    assert not lip(0.6, 0.0001).holds
