"""The rate of a watched signal: its error, its spread, what is refused."""

import numpy as np
import pytest

from control.errors import ControlError
from control.initial_rate import MIN_SAMPLES, initial_rate


def test_the_initial_rate_of_a_watched_signal_and_its_spread() -> None:
    times = np.arange(31) / 30  # s
    arc = 0.3 - 0.2 * times + 0.05 * times**2  # m
    exact = initial_rate(times.tolist(), arc.tolist(), 1.0)
    assert exact.rate == pytest.approx(-0.1, abs=2e-3)  # m/s, at the end
    assert exact.spread < 0.01
    noise = np.random.default_rng(0).normal(size=(100, 31)) * 3e-4
    fits = [initial_rate(times.tolist(), (arc + n).tolist(), 1.0) for n in noise]
    errors = np.array([fit.rate + 0.1 for fit in fits])
    assert np.abs(errors).max() < 0.03
    assert 0.3 < np.mean([fit.spread for fit in fits]) / errors.std() < 3.0


@pytest.mark.parametrize(("samples", "fps"), [(6, 10), (6, 30), (15, 30), (30, 30)])
@pytest.mark.parametrize(("noise", "jerk"), [(1e-4, 1.0), (2.3e-3, 3.0)])  # distance, bearing
def test_the_spread_tells_the_error(samples: int, fps: int, noise: float, jerk: float) -> None:
    rng, times = np.random.default_rng(0), np.arange(samples) / fps
    found = [
        initial_rate(times.tolist(), (0.1 * times + noise * n).tolist(), jerk)
        for n in rng.normal(size=(100, samples))
    ]
    error = np.mean([(rate.rate - 0.1) ** 2 for rate in found]) ** 0.5
    assert 0.45 < np.mean([rate.spread for rate in found]) / error < 1.5
    assert error < 1.5 * jerk ** (1 / 3) * noise ** (2 / 3)  # Levant: the best order of noise


@pytest.mark.parametrize("lost", [0.2, 0.4])
def test_missing_frames_cost_little(lost: float) -> None:
    rng, every = np.random.default_rng(1), np.arange(24) / 30
    errors = []
    for _ in range(200):
        times = every[rng.random(24) >= lost]
        values = 0.3 - 0.2 * times + 0.05 * times**2 + 1e-4 * rng.normal(size=len(times))
        found = initial_rate(times.tolist(), values.tolist(), 1.0)
        errors.append(found.rate - (-0.2 + 0.1 * times[-1]))
    assert np.abs(errors).max() < 0.02  # m/s; 0.0075 with all frames


def test_what_is_refused() -> None:
    times, values = [0.1 * i for i in range(MIN_SAMPLES)], [0.0] * MIN_SAMPLES
    with pytest.raises(ControlError, match="needs 6 samples, got 5 times"):
        initial_rate(times[1:], values[1:], 1.0)
    with pytest.raises(ControlError, match="6 times, 5 values"):
        initial_rate(times, values[1:], 1.0)
    for bad in ([0.0, 0.2, 0.1, 0.3, 0.4, 0.5], [0.0, 0.1, 0.1, 0.2, 0.3, 0.4]):
        with pytest.raises(ControlError, match="ascending"):
            initial_rate(bad, values, 1.0)
    for at, bad_value in ((0, float("nan")), (5, float("inf"))):
        spoiled = [*values[:at], bad_value, *values[at + 1 :]]
        with pytest.raises(ControlError, match="differentiator"):
            initial_rate(times, spoiled, 1.0)
