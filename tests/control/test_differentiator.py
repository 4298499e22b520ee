"""Differentiator: exactness on its class, noise, varying periods; the line fit."""

from math import cos, pi, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from control.differentiator import (
    begin_differentiator,
    differentiate,
    initial_rate,
    unwrapped,
)
from control.errors import ControlError


def worst_on_sine(noise: float, times: np.ndarray, order: int = 2) -> float:
    """Largest error of the rate of sin t in the second half of the times."""
    rng = np.random.default_rng(0)
    memory, worst = begin_differentiator(0.0, 0.0, 1.0, order), 0.0
    for i, t in enumerate(times):
        memory = differentiate(memory, float(t), sin(t) + noise * rng.uniform(-1, 1))
        if i > len(times) / 2:
            worst = max(worst, abs(memory.rate - cos(t)))
    return worst


@pytest.mark.parametrize(
    ("tau", "noise", "bound"),
    [(0.06, 0.0, 0.0014), (1 / 30, 0.0, 0.0005), (0.06, 1e-3, 0.033), (1 / 30, 1e-2, 0.13)],
)
def test_errors_of_the_design_table(tau: float, noise: float, bound: float) -> None:
    assert worst_on_sine(noise, np.arange(tau, 40.0, tau)) < bound


def test_varying_periods_and_missing_samples() -> None:
    rng = np.random.default_rng(3)
    times = np.cumsum(rng.uniform(0.02, 0.05, size=1200))
    assert worst_on_sine(0.0, times) < 0.002
    assert worst_on_sine(0.0, np.delete(times, rng.integers(0, 1200, 200))) < 0.005


@pytest.mark.parametrize("order", [1, 2, 3, 4, 5])
def test_exact_on_polynomials_of_its_order(order: int) -> None:
    # the derivative of order + 1 is 0: after the transient the implicit form has no error left
    coefficients = [0.3, -0.2, 0.05, -0.01, 0.002, -0.0003][: order + 1]
    memory = begin_differentiator(0.0, coefficients[0], 1.0, order)
    for i in range(1, 400):
        t = 0.05 * i + 0.02 * sin(i)  # uneven periods
        value = sum(c * t**k for k, c in enumerate(coefficients))
        memory = differentiate(memory, t, value)
    exact = sum(k * c * t ** (k - 1) for k, c in enumerate(coefficients) if k)
    assert abs(memory.rate - exact) < 1e-7


@settings(max_examples=30)
@given(st.floats(0.1, 10.0))
def test_homogeneous(scale: float) -> None:
    a, b = begin_differentiator(0.0, 0.0, 1.0), begin_differentiator(0.0, 0.0, scale)
    for i in range(1, 60):
        t = 0.04 * i
        a, b = differentiate(a, t, sin(3 * t)), differentiate(b, t, scale * sin(3 * t))
    assert b.rate == pytest.approx(scale * a.rate, rel=1e-6, abs=1e-9)


def test_what_is_refused() -> None:
    memory = begin_differentiator(1.0, 0.0, 1.0)
    for t, value in ((1.0, 0.0), (0.5, 0.0), (2.0, float("nan"))):
        with pytest.raises(ControlError, match="differentiator"):
            differentiate(memory, t, value)
    with pytest.raises(ControlError, match="order 6"):
        begin_differentiator(0.0, 0.0, 1.0, 6)
    with pytest.raises(ControlError, match="bound"):
        begin_differentiator(0.0, 0.0, 0.0)
    with pytest.raises(ControlError, match="2 samples"):
        initial_rate([1.0], [0.0], 1.0)
    with pytest.raises(ControlError, match="ascending"):
        initial_rate([1.0, 1.0], [0.0, 0.0], 1.0)


def test_the_initial_rate_of_a_watched_signal_and_its_spread() -> None:
    times = np.arange(31) / 30  # s
    arc = 0.3 - 0.2 * times + 0.05 * times**2  # m
    exact = initial_rate(times.tolist(), arc.tolist(), 1.0)
    assert exact.rate == pytest.approx(-0.1, abs=2e-3)  # m/s, at the end
    assert exact.spread < 0.01
    rng = np.random.default_rng(0)
    noise = rng.normal(size=(100, 31)) * 3e-4
    fits = [initial_rate(times.tolist(), (arc + n).tolist(), 1.0) for n in noise]
    errors = np.array([fit.rate + 0.1 for fit in fits])
    assert np.abs(errors).max() < 0.03
    assert 0.3 < np.mean([fit.spread for fit in fits]) / errors.std() < 3.0


@given(st.lists(st.floats(-1.5, 1.5), min_size=1, max_size=50))
def test_unwrapping_undoes_wrapping(steps: list[float]) -> None:
    angles = np.cumsum(steps)
    wrapped = [float(pi - (pi - angle) % (2 * pi)) for angle in angles]
    out = np.array(unwrapped(wrapped))
    np.testing.assert_allclose(out - out[0], angles - angles[0], atol=1e-9)
