"""Capture times from a stream's timestamps: jitter does not enter, drift is followed."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.cameras.timing import StreamTiming

FPS = 30.0


def times_of(delays: np.ndarray, latency: float = 0.0, rate: float = 1.0) -> np.ndarray:
    """Capture times found minus true ones, for frames with given delays [s]."""
    timing, taken = StreamTiming(latency), np.arange(len(delays)) / FPS
    found = [
        timing.capture_time(1000.0 + rate * t, t + delay)
        for t, delay in zip(taken, delays, strict=True)
    ]
    return np.array(found) - taken


@given(st.integers(0, 2**32 - 1), st.floats(0.0, 0.2))
def test_jitter_of_arrival_does_not_enter(seed: int, latency: float) -> None:
    jitter = np.random.default_rng(seed).uniform(0.0, 0.03, 300)
    jitter[[0, 100, 200]] = 0.0
    errors = times_of(latency + jitter, latency)
    assert np.abs(errors).max() < 1e-9


def test_a_late_start_is_corrected_by_the_first_frame_in_time() -> None:
    errors = times_of(np.array([0.5, 0.4, 0.3, 0.0, 0.2, 0.1]))
    np.testing.assert_allclose(errors, [0.5, 0.4, 0.3, 0.0, 0.0, 0.0], atol=1e-9)


@pytest.mark.parametrize("drift", [-5e-5, 5e-5])
def test_a_drifting_clock_is_followed_within_half_a_millisecond(drift: float) -> None:
    errors = times_of(np.zeros(30 * 120), rate=1.0 + drift)
    assert np.abs(errors).max() < 5.1e-4


@pytest.mark.parametrize("jump", [-100.0, -0.5, 2.0, 100.0])
def test_a_camera_that_restarts_its_time_is_dated_anew(jump: float) -> None:
    timing = StreamTiming(0.01)
    for n in range(30):
        timing.capture_time(n / FPS, n / FPS)
    assert timing.capture_time(1.0 + jump, 1.0) == pytest.approx(0.99)
    assert timing.capture_time(1.5 + jump, 1.6) == pytest.approx(1.49)


def test_a_frame_held_up_for_seconds_is_as_old_as_it_is() -> None:
    delays = np.zeros(120)
    delays[60:] = np.maximum(0.0, 2.5 - np.arange(60) / FPS)  # all that was held up comes at once
    np.testing.assert_allclose(times_of(delays), 0.0, atol=1e-9)


def test_a_pause_that_the_streams_time_leaves_out_is_forgotten_within_ten_seconds() -> None:
    errors = times_of(np.where(np.arange(30 * 30) < 300, 0.0, 3.0))
    np.testing.assert_allclose(errors[:300], 0.0, atol=1e-9)
    assert errors.max() < 3.0 + 1e-9  # never later than it arrived
    np.testing.assert_allclose(errors[300 + 30 * 11 :], 3.0, atol=1e-9)


def test_without_timestamps_arrival_minus_latency_counts() -> None:
    timing = StreamTiming(0.04)
    assert timing.capture_time(None, 1.0) == pytest.approx(0.96)
