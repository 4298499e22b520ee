"""The filter's loops for machine code against numpy and filterpy."""

from math import pi

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from control.actuation import DriveGain
from control.estimation import Estimate, correct, predict
from control.geometry import Pose2D
from control.history import SentCommands
from control.kalman import correct_by_pose, propagate
from control.motion_model import UNCOMMANDED, MotionModel, process_noise, roll, transition
from control.unicycle import Twist, UnicycleState
from vision.compiled import compiled

Array = NDArray[np.float64]

SEEDS = st.integers(0, 2**32 - 1)
SCALES = np.array((1e-3, 1e-3, 1e-2, 0.05, 0.3, 0.1, 0.1))


def propagated(
    old: UnicycleState, new: UnicycleState, dt: float, model: MotionModel, gain: DriveGain,
    covariance: Array,
) -> Array:  # fmt: skip
    """The covariance after a roll."""
    f = transition(old, new, dt, model.lag, gain)
    propagate(covariance, f, process_noise(old, new, dt, model))
    return covariance


fast_propagated, fast_correct = compiled(propagated), compiled(correct_by_pose)


def covariance_of(rng: np.random.Generator, scales: Array) -> Array:
    """A random covariance with standard deviations of about the scales."""
    a = rng.normal(size=(len(scales), len(scales))) * scales[:, None]
    return a @ a.T + np.diag(1e-2 * scales**2)


def relative_gap(one: Array, other: Array) -> float:
    """Greatest difference of two covariances, in standard deviations of the second."""
    std = np.sqrt(np.diag(other))
    return float(np.max(np.abs(one - other) / np.outer(std, std)))


@settings(deadline=None)
@given(SEEDS, st.floats(0.005, 0.1), st.sampled_from([0.05, UNCOMMANDED]))
def test_prediction_agrees_with_that_of_the_live_filter(seed: int, dt: float, lag: float) -> None:
    rng = np.random.default_rng(seed)
    sent, model = SentCommands((-1.0,), (Twist(*rng.normal(size=2)),)), MotionModel(lag)
    mean = np.concatenate((rng.normal(size=5), rng.uniform(0.8, 1.2, 2)))
    before = Estimate(0.0, mean, covariance_of(rng, SCALES))
    after = predict(before, dt, sent, model)
    new = roll(before.state, 0.0, dt, sent, model, before.gain)
    quick = fast_propagated(before.state, new, dt, model, before.gain, before.covariance.copy())
    assert relative_gap(quick, after.covariance) < 1e-12


@settings(deadline=None)
@given(SEEDS)
def test_correction_agrees_with_filterpy(seed: int) -> None:
    rng = np.random.default_rng(seed)
    mean = np.concatenate((rng.normal(size=5), rng.uniform(0.4, 2.2, 2)))
    covariance, noise = covariance_of(rng, SCALES), covariance_of(rng, SCALES[:3])
    measured = mean[:3] + rng.normal(size=3) * SCALES[:3] + (0.0, 0.0, 2.0 * pi)
    slow = correct(Estimate(0.0, mean.copy(), covariance.copy()), Pose2D(*measured), noise)
    state, gain = UnicycleState(*mean[:5].tolist()), DriveGain(*mean[5:].tolist())
    quick = covariance.copy()
    s, g = fast_correct(state, gain, quick, measured, noise, np.empty((7, 3)))
    quick_mean = np.array((s.x, s.y, s.theta, s.v, s.omega, g.v, g.omega))
    assert relative_gap(quick, slow.covariance) < 1e-12
    assert np.max(np.abs(quick_mean - slow.mean) / (1.0 + np.abs(slow.mean))) < 1e-12
    assert np.array_equal(quick, quick.T)
