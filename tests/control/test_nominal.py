"""The sliding phase (23) in closed form: the ODE, dense samples, its own invariances."""

from math import exp, inf, nan, pi, sqrt

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from control.errors import ControlError
from control.nominal import (
    ErrorDynamics,
    Extremes,
    half_width,
    invariant_polygon,
    stays_within,
)

# two real poles, nearly and exactly double poles, and pairs down to a damping of 0.1
POLES = st.floats(0.3, 6.0)
REAL = st.builds(lambda p, q: ErrorDynamics(p + q, p * q), POLES, POLES)
DOUBLE = st.builds(lambda p: ErrorDynamics(2.0 * p, p * p), POLES)
NEAR = st.builds(lambda p, x: ErrorDynamics(2 * p, p * p * (1 + x)), POLES, st.floats(-1e-9, 1e-9))
PAIR = st.builds(lambda w, z: ErrorDynamics(2 * z * w, w * w), POLES, st.floats(0.1, 0.999))
DYNAMICS = REAL | DOUBLE | NEAR | PAIR
ERROR, RATE = st.floats(-1.0, 1.0), st.floats(-5.0, 5.0)


def horizon(dynamics: ErrorDynamics) -> float:
    """Time in which every error falls below a millionth [s]."""
    sigma = 0.5 * dynamics.proportional
    slow = sigma - sqrt(max(0.0, sigma**2 - dynamics.integral))
    return 20.0 / slow


@pytest.mark.parametrize(
    "dynamics", [ErrorDynamics(3.0, 1.0), ErrorDynamics(2.0, 1.0), ErrorDynamics(1.0, 4.0)]
)
def test_response_solves_the_differential_equation(dynamics: ErrorDynamics) -> None:
    k, l = dynamics.proportional, dynamics.integral  # noqa: E741 (the paper's L)
    t = np.linspace(0.0, 8.0, 50)
    truth = solve_ivp(
        lambda _, y: (y[1], -k * y[1] - l * y[0]),
        (0.0, 8.0),
        (0.3, -1.2),
        t_eval=t,
        rtol=1e-10,
        atol=1e-12,
    )
    value, rate = dynamics.at(0.3, -1.2, t)
    assert np.abs(value - truth.y[0]).max() < 1e-8  # m
    assert np.abs(rate - truth.y[1]).max() < 1e-8  # m/s


@given(DYNAMICS, ERROR, RATE, st.floats(0.0, 3.0), st.floats(0.0, 3.0))
def test_response_is_a_flow_forwards_and_backwards(
    dynamics: ErrorDynamics, e: float, r: float, t: float, u: float
) -> None:
    there = [float(x) for x in dynamics.at(e, r, t)]
    assert dynamics.at(*there, u) == pytest.approx(dynamics.at(e, r, t + u), abs=1e-9)
    assume(dynamics.proportional * t < 8.0)  # what has died out cannot be brought back
    assert dynamics.at(*there, -t) == pytest.approx((e, r), abs=1e-6)


def test_the_papers_error_is_1_plus_t_times_exp_minus_t() -> None:
    dynamics = ErrorDynamics(2.0, 1.0)
    for t in (0.0, 0.5, 1.0, 5.0):
        assert float(dynamics.at(1.0, 0.0, t)[0]) == pytest.approx((1 + t) * exp(-t), abs=1e-15)
    found = dynamics.extremes(1.0, 0.0)
    assert (found.low, found.high, found.rate_high) == (0.0, 1.0, 0.0)
    assert found.rate_low == pytest.approx(-exp(-1.0), abs=1e-15)  # -t exp(-t) at t = 1 s
    assert dynamics.settling_time(1.0, 0.0, 0.05) == pytest.approx(4.7439, abs=1e-4)


@given(DYNAMICS, ERROR, RATE)
def test_extremes_are_those_of_dense_samples(dynamics: ErrorDynamics, e: float, r: float) -> None:
    found = dynamics.extremes(e, r)
    t = np.linspace(0.0, horizon(dynamics), 20001)
    value, rate = dynamics.at(e, r, t)
    # samples reach an extreme but for the curvature between two of them
    scale = abs(e) + abs(r)
    for sampled, exact, curvature in (
        ((value.min(), value.max()), (found.low, found.high), 200.0),
        ((rate.min(), rate.max()), (found.rate_low, found.rate_high), 2000.0),
    ):
        room = curvature * scale * (t[1] - t[0]) ** 2 + 1e-5 * scale  # the tail, cut off
        assert exact[0] <= sampled[0] + 1e-12
        assert exact[1] >= sampled[1] - 1e-12
        assert min(sampled[0], 0.0) - exact[0] <= room
        assert exact[1] - max(sampled[1], 0.0) <= room


@given(DYNAMICS, ERROR, RATE, st.floats(0.001, 0.5))
def test_settling_time_is_when_the_band_is_left_for_the_last_time(
    dynamics: ErrorDynamics, e: float, r: float, band: float
) -> None:
    settled = dynamics.settling_time(e, r, band)
    after = settled + np.linspace(0.0, horizon(dynamics), 4001)
    assert np.abs(dynamics.at(e, r, after)[0]).max() <= band * (1 + 1e-6)
    if settled > 0.0:
        assert abs(float(dynamics.at(e, r, settled)[0])) == pytest.approx(band, rel=1e-6)
    else:
        assert dynamics.extremes(e, r).greatest <= band


@given(DYNAMICS, ERROR, RATE, st.floats(0.05, 2.0))
def test_membership_is_what_simulation_says_and_is_kept(
    dynamics: ErrorDynamics, e: float, r: float, bound: float
) -> None:
    peak = np.abs(dynamics.at(e, r, np.linspace(0.0, horizon(dynamics), 20001))[0]).max()
    assume(abs(peak / bound - 1.0) > 1e-3)
    assert stays_within(dynamics, e, r, bound) == (peak <= bound)
    if peak <= bound:  # positively invariant
        for t in (0.1, 0.7, 2.0):
            assert stays_within(dynamics, *(float(x) for x in dynamics.at(e, r, t)), bound)


@given(DYNAMICS, st.floats(0.05, 2.0), RATE)
def test_half_width_is_the_largest_box(dynamics: ErrorDynamics, bound: float, rate: float) -> None:
    width = half_width(dynamics, bound, rate)
    if width == 0.0:
        assert dynamics.extremes(0.0, rate).greatest >= bound * (1 - 1e-9)
        return
    for share in (-1.0, -0.5, 0.0, 0.5, 1.0):
        assert stays_within(dynamics, share * width, rate, bound * (1 + 1e-9))
    wider = 1.001 * width
    ends = [stays_within(dynamics, sign * wider, rate, bound) for sign in (1.0, -1.0)]
    assert not all(ends)


@given(DYNAMICS, st.floats(0.05, 2.0))
def test_from_rest_the_whole_bound_is_allowed(dynamics: ErrorDynamics, bound: float) -> None:
    assert half_width(dynamics, bound) == bound


@given(DYNAMICS, st.floats(0.05, 2.0))
def test_polygon_is_the_edge_of_the_invariant_set(dynamics: ErrorDynamics, bound: float) -> None:
    polygon = invariant_polygon(dynamics, bound, 12)
    assert polygon.shape == (25, 2)
    assert not polygon.flags.writeable
    assert (polygon[0] == polygon[-1]).all()
    for e, r in polygon:
        assert dynamics.extremes(e, r).greatest == pytest.approx(bound, rel=1e-9)
    for e, r in 0.999 * polygon:
        assert stays_within(dynamics, e, r, bound)
    sides = np.diff(polygon, axis=0)
    a, b = sides, np.roll(sides[:-1], -1, axis=0)
    turns = a[:-1, 0] * b[:, 1] - a[:-1, 1] * b[:, 0]
    assert (turns > -1e-9 * np.abs(polygon).max() ** 2).all()  # convex, counter-clockwise


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: ErrorDynamics(0.0, 1.0), "K > 0"),
        (lambda: ErrorDynamics(1.0, nan), "L > 0"),
        (lambda: ErrorDynamics(inf, 1.0), "K > 0"),
        (lambda: ErrorDynamics(2.0, 1.0).extremes(nan, 0.0), "not finite"),
        (lambda: ErrorDynamics(2.0, 1.0).settling_time(1.0, 0.0, 0.0), "band > 0"),
        (lambda: stays_within(ErrorDynamics(2.0, 1.0), 1.0, 0.0, -1.0), "bound"),
        (lambda: half_width(ErrorDynamics(2.0, 1.0), inf), "bound"),
        (lambda: invariant_polygon(ErrorDynamics(2.0, 1.0), 1.0, 1), "at least 2 points"),
        (lambda: Extremes(0.1, 0.2), "include 0"),
        (lambda: Extremes(-1.0, nan), "not finite"),
    ],
)
def test_what_is_refused(make: object, message: str) -> None:
    with pytest.raises(ControlError, match=message):
        make()  # type: ignore[operator]


def test_weak_damping_settles_where_its_envelope_says() -> None:
    dynamics = ErrorDynamics(0.02, 1.0)  # 1 % of critical: some 75 swings to 1 %
    settled = dynamics.settling_time(1.0, 0.0, 0.01)
    assert settled == pytest.approx(-np.log(0.01) / 0.01, abs=pi)
