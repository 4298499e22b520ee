"""The filter: exact roll through commands, covariance, correction, gates, gains."""

from math import isclose, pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from control.actuation import DriveGain
from control.errors import ControlError
from control.estimation import (
    Estimate,
    MotionModel,
    SentCommands,
    correct,
    initial_estimate,
    innovation,
    predict,
    roll,
)
from control.geometry import Pose2D
from control.history import KEEP
from control.motion_model import UNCOMMANDED, process_noise, transition
from control.unicycle import Twist, UnicycleState, advance_lagged, advance_pose

NOISE = np.diag([0.0005**2, 0.0005**2, 0.008**2])
STATE = UnicycleState(0.2, -0.1, 3.0, 0.5, 1.2)


def history(n: int = 20, period: float = 0.005) -> SentCommands:
    """Commands that change every period."""
    sent = SentCommands()
    for i in range(n):
        sent = sent.append(i * period, Twist(0.3 + 0.01 * i, 2.0 - 0.1 * i))
    return sent


def test_command_in_force() -> None:
    sent = history(3)
    assert sent.in_force(-0.001) == Twist(0.0, 0.0)
    assert sent.in_force(0.005) == sent.twists[1]
    assert sent.in_force(0.0099) == sent.twists[1]
    assert sent.in_force(9.0) == sent.twists[2]


@given(st.floats(-0.05, 0.2), st.floats(0.0, 0.2))
def test_pieces_fill_the_interval(t0: float, length: float) -> None:
    sent = history()
    pieces = list(sent.between(t0, t0 + length))
    assert isclose(sum(dt for dt, _ in pieces), length, abs_tol=1e-12)
    t = t0
    for dt, command in pieces:
        assert dt > 0.0
        assert command == sent.in_force(t + 0.5 * dt)
        t += dt


def test_history_forgets_what_nobody_asks_for() -> None:
    sent = SentCommands()
    for i in range(2000):
        sent = sent.append(i * 0.005, Twist(float(i), 0.0))
    assert len(sent.times) <= KEEP / 0.005 + 2
    assert sent.times[0] <= sent.times[-1] - KEEP
    with pytest.raises(ControlError, match="sent after one"):
        sent.append(0.0, Twist(0.0, 0.0))


@given(st.floats(0.0, 0.2), st.floats(0.0, 1.0))
def test_a_roll_in_two_pieces_is_the_roll(length: float, share: float) -> None:
    sent, model, gain = history(), MotionModel(), DriveGain(1.1, 0.9)
    middle = share * length
    whole = roll(STATE, 0.0, length, sent, model, gain)
    half = roll(STATE, 0.0, middle, sent, model, gain)
    both = roll(half, middle, length, sent, model, gain)
    assert abs(whole.x - both.x) < 2e-6  # arcs split within a command differ by their lag
    assert abs(whole.y - both.y) < 2e-6
    assert isclose(whole.theta, both.theta, abs_tol=1e-12)
    assert isclose(whole.v, both.v, abs_tol=1e-12)


def test_unknown_commands_coast_and_known_ones_follow_the_plant() -> None:
    coasting = roll(STATE, 0.0, 0.1, history(), MotionModel(lag=UNCOMMANDED))
    arc = advance_pose(STATE.pose, STATE.twist, 0.1)
    assert (coasting.x, coasting.y, coasting.theta) == (arc.x, arc.y, arc.theta)
    plant = STATE
    for i in range(100):
        plant = advance_lagged(plant, history().in_force(i * 0.001 + 1e-6), 0.001, 0.05)
    known = roll(STATE, 0.0, 0.1, history(), MotionModel(lag=0.05))
    assert abs(known.x - plant.x) < 1e-6
    assert abs(known.theta - plant.theta) < 1e-9


@pytest.mark.parametrize("lag", [0.05, UNCOMMANDED])
def test_transition_against_finite_differences(lag: float) -> None:
    sent, model, dt = history(), MotionModel(lag=lag), 1 / 30
    start = np.array([0.2, -0.1, 0.8, 0.5, 1.2, 1.1, 0.9])

    def end(x: np.ndarray) -> np.ndarray:
        state = roll(UnicycleState(*x[:5]), 0.0, dt, sent, model, DriveGain(x[5], x[6]))
        return np.array([state.x, state.y, state.theta, state.v, state.omega, x[5], x[6]])

    numeric = np.array([(end(start + h) - end(start - h)) / 2e-6 for h in 1e-6 * np.eye(7)]).T
    old, new = UnicycleState(*start[:5]), UnicycleState(*end(start)[:5])
    exact = transition(old, new, dt, lag, DriveGain(*start[5:])).matrix
    # entries of the way are of the order 1e-2: speeds are taken as even within the interval
    np.testing.assert_allclose(exact, numeric, atol=1e-4)


@pytest.mark.parametrize("lag", [0.05, UNCOMMANDED])
def test_process_noise_is_additive_over_pieces_and_positive(lag: float) -> None:
    model = MotionModel(lag=lag, gain_drift=0.0)
    straight = UnicycleState(0.0, 0.0, 0.0, 0.0, 0.0)
    whole, step = process_noise(straight, straight, 0.03, model).matrix, np.zeros((7, 7))
    f = transition(straight, straight, 0.01, lag, DriveGain()).matrix
    for _ in range(3):
        step = f @ step @ f.T + process_noise(straight, straight, 0.01, model).matrix
    np.testing.assert_allclose(whole, step, rtol=1e-9, atol=1e-15)
    assert np.linalg.eigvalsh(whole).min() > -1e-12


@settings(max_examples=30)
@given(st.floats(-20.0, 20.0), st.floats(-0.1, 0.1))
def test_angles_are_compared_modulo_a_turn(theta: float, off: float) -> None:
    estimate = initial_estimate(Pose2D(0.0, 0.0, theta), NOISE, 0.0)
    turned = Pose2D(0.0, 0.0, theta + off + 4 * pi)
    assert innovation(estimate, turned, NOISE).residual[2] == pytest.approx(off, abs=1e-9)
    corrected = correct(estimate, turned, NOISE)
    assert corrected.mean[2] == pytest.approx(theta + off / 2, abs=1e-9)


def simulated(gain: DriveGain, seconds: float, model: MotionModel) -> tuple[list[float], Estimate]:
    """A robot on a known course, seen at 30 fps: normalised innovations and the last estimate."""
    rng, sent, distances = np.random.default_rng(1), SentCommands(), []
    for i in range(round(seconds * 20)):
        sent = sent.append(i * 0.05, Twist(0.4 + 0.1 * np.sin(i / 7), 1.5 * np.cos(i / 11)))
        sent = SentCommands(sent.times, sent.twists)
    truth, t, estimate = UnicycleState(0.0, 0.0, 0.0, 0.0, 0.0), 0.0, None
    kept = sent.times[0]
    for frame in range(1, round((seconds - KEEP) * 30)):
        captured = kept + frame / 30
        for dt, c in sent.between(t, captured):
            truth = advance_lagged(truth, Twist(gain.v * c.v, gain.omega * c.omega), dt, 0.05)
        t = captured
        noise = rng.normal(size=3) * np.sqrt(np.diag(NOISE))
        seen = Pose2D(truth.x + noise[0], truth.y + noise[1], truth.theta + noise[2])
        if estimate is None:
            estimate = initial_estimate(seen, NOISE, captured, model)
            continue
        estimate = predict(estimate, captured, sent, model)
        distances.append(innovation(estimate, seen, NOISE).squared_distance)
        estimate = correct(estimate, seen, NOISE)
    assert estimate is not None
    return distances, estimate


def test_gains_are_found_and_innovations_fit_their_covariance() -> None:
    model = MotionModel(acceleration_std=0.1, angular_acceleration_std=0.3, gain_drift=0.001)
    distances, estimate = simulated(DriveGain(1.1, 0.9), 9.0, model)
    assert estimate.gain.v == pytest.approx(1.1, abs=0.01)
    assert estimate.gain.omega == pytest.approx(0.9, abs=0.02)
    assert 2.0 < np.mean(distances[60:]) < 4.5  # 3 degrees of freedom
    assert np.mean(np.array(distances[60:]) > 11.3) < 0.05


def test_gains_stay_at_one_if_they_are_not_doubted() -> None:
    model = MotionModel(gain_std=0.0, gain_drift=0.0)
    _, estimate = simulated(DriveGain(1.1, 0.9), 3.0, model)
    assert estimate.gain == DriveGain(1.0, 1.0)


def test_estimates_are_values() -> None:
    estimate = initial_estimate(Pose2D(0.0, 0.0, 0.0), NOISE, 0.0)
    with pytest.raises(ValueError, match="read-only"):
        estimate.mean[0] = 1.0
    assert predict(estimate, 0.0, SentCommands(), MotionModel()) is estimate
    later = predict(estimate, 0.033, SentCommands(), MotionModel())
    np.testing.assert_array_equal(later.covariance, later.covariance.T)
    again = correct(later, Pose2D(0.1, 0.0, 0.0), NOISE)
    same = correct(later, Pose2D(0.1, 0.0, 0.0), NOISE)
    assert again.mean.tobytes() == same.mean.tobytes()
    np.testing.assert_array_equal(again.covariance, again.covariance.T)


def test_what_is_refused() -> None:
    estimate = initial_estimate(Pose2D(0.0, 0.0, 0.0), NOISE, 1.0)
    with pytest.raises(ControlError, match="taken back"):
        predict(estimate, 0.9, SentCommands(), MotionModel())
    with pytest.raises(ControlError, match="not a measured pose"):
        correct(estimate, Pose2D(float("nan"), 0.0, 0.0), NOISE)
    with pytest.raises(ControlError, match="not a measured pose"):
        innovation(estimate, Pose2D(0.0, 0.0, 0.0), np.eye(2))
    with pytest.raises(ControlError, match="motion model"):
        MotionModel(lag=0.0)
