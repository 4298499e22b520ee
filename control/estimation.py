"""An extended Kalman filter per robot: corrected at capture time, rolled on to command time.

State: x, y, theta, v, omega. The mean follows the unicycle exactly through every command sent;
the covariance is propagated once per interval between frames.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from math import cos, exp, sin
from typing import Any

import numpy as np
from numpy.typing import NDArray

from control.errors import ControlError
from control.geometry import Pose2D, wrap_angle
from control.history import SentCommands as SentCommands
from control.unicycle import UnicycleState, advance_lagged, advance_pose

Array = NDArray[np.float64]

_OBSERVED = np.eye(3, 5)  # a camera sees the pose, not the velocities
_HOLD = 1.0 / 30.0  # for which an unknown acceleration keeps its value in MotionModel [s]


@dataclass(frozen=True, slots=True)
class MotionModel:
    """How a robot is believed to move between frames.

    Attributes:
        lag: time constant with which it follows the commands sent to it; None if nobody knows its
            commands: it then keeps its velocities but for unknown accelerations [s].
        acceleration_std: unknown forward acceleration, standard deviation of a value that holds
            for 1/30 s [m/s^2].
        angular_acceleration_std: the same of the turning [rad/s^2].
        initial_v_std: forward velocity before the first frames tell [m/s].
        initial_omega_std: angular velocity before the first frames tell [rad/s].

    Raises:
        ControlError: if the lag or a standard deviation is not positive.
    """

    lag: float | None = 0.05
    acceleration_std: float = 2.0
    angular_acceleration_std: float = 5.0
    initial_v_std: float = 0.03
    initial_omega_std: float = 0.1

    def __post_init__(self) -> None:
        accelerations = (self.acceleration_std, self.angular_acceleration_std)
        speeds = (self.initial_v_std, self.initial_omega_std)
        if not min(*accelerations, *speeds, 1.0 if self.lag is None else self.lag) > 0.0:
            raise ControlError(f"a motion model needs a lag and deviations > 0, got {self}")


@dataclass(frozen=True, slots=True)
class Estimate:
    """What is believed of one robot at one time.

    Attributes:
        t: the time, on the capture clock [s].
        mean: (5,) x, y, theta (not wrapped), v, omega [m, m, rad, m/s, rad/s]; read-only.
        covariance: (5, 5) of the mean, symmetric; read-only.
    """

    t: float
    mean: Array
    covariance: Array

    def __post_init__(self) -> None:
        self.mean.flags.writeable = False
        self.covariance.flags.writeable = False

    @property
    def state(self) -> UnicycleState:
        """The mean as a state [m, m, rad, m/s, rad/s]."""
        return UnicycleState(*self.mean.tolist())


@dataclass(frozen=True, slots=True)
class Innovation:
    """How far a measured pose lies from the predicted one.

    Attributes:
        residual: (3,) measured minus predicted, angle wrapped [m, m, rad].
        covariance: (3, 3) expected of the residual.
        squared_distance: residual in standard deviations, squared: chi-square with 3 degrees of
            freedom if all is well (11.3 is exceeded once in 100).
    """

    residual: Array
    covariance: Array
    squared_distance: float


def initial_estimate(
    pose: Pose2D, covariance: Array, t: float, model: MotionModel | None = None
) -> Estimate:
    """Estimate from a first measured pose: velocities 0, with the model's doubt.

    Args:
        pose: measured pose [m, m, rad].
        covariance: (3, 3) of the pose.
        t: capture time [s].
        model: motion model for the doubt of the velocities; the default one if None.

    Returns:
        The estimate at t.

    Raises:
        ControlError: if pose or covariance is not finite.
    """
    _require_measurement(pose, covariance)
    model = model or MotionModel()
    full = np.diag([0.0, 0.0, 0.0, model.initial_v_std**2, model.initial_omega_std**2])
    full[:3, :3] = covariance
    return Estimate(t, np.array([pose.x, pose.y, pose.theta, 0.0, 0.0]), full)


def predict(estimate: Estimate, t: float, sent: SentCommands, model: MotionModel) -> Estimate:
    """Estimate at a later time: the mean through every command, the covariance in one step.

    Args:
        estimate: the estimate so far.
        t: when it is wanted, usually a frame's capture time [s].
        sent: commands sent to this robot.
        model: how it moves.

    Returns:
        The estimate at t; unchanged if t is its own time.

    Raises:
        ControlError: if t lies before the estimate.
    """
    dt = t - estimate.t
    if dt < 0.0:
        raise ControlError(f"a frame of {t:.4f} s cannot correct an estimate of {estimate.t:.4f} s")
    if dt == 0.0:
        return estimate
    old = estimate.state
    new = roll(old, estimate.t, t, sent, model)
    f = _transition(old, new, dt, model.lag)
    covariance = f @ estimate.covariance @ f.T + _process_noise(old, new, dt, model)
    mean = np.array([new.x, new.y, new.theta, new.v, new.omega])
    return Estimate(t, mean, _symmetric(covariance))


def roll(
    state: UnicycleState, t0: float, t1: float, sent: SentCommands, model: MotionModel
) -> UnicycleState:
    """Roll a state forward through every command in force on the way; without lag, it coasts.

    Args:
        state: pose and velocities at t0.
        t0: start [s].
        t1: end; the state is returned as it is unless t1 > t0 [s].
        sent: commands sent to this robot.
        model: how it moves.

    Returns:
        Pose and velocities at t1; the heading is not wrapped.
    """
    if model.lag is None:
        pose = advance_pose(state.pose, state.twist, max(t1 - t0, 0.0))
        return UnicycleState(pose.x, pose.y, pose.theta, state.v, state.omega)
    for dt, command in sent.between(t0, t1):
        state = advance_lagged(state, command, dt, model.lag)
    return state


def innovation(estimate: Estimate, pose: Pose2D, covariance: Array) -> Innovation:
    """Compare a measured pose with an estimate of the same time; the caller gates on it.

    Args:
        estimate: estimate predicted to the capture time.
        pose: measured pose [m, m, rad].
        covariance: (3, 3) of the measured pose.

    Returns:
        Residual, its expected covariance and its squared Mahalanobis distance.

    Raises:
        ControlError: if pose or covariance is not finite.
    """
    _require_measurement(pose, covariance)
    residual = _residual(np.array([pose.x, pose.y, pose.theta]), estimate.mean[:3])
    expected = estimate.covariance[:3, :3] + covariance
    distance = float(residual @ np.linalg.solve(expected, residual))
    return Innovation(residual, expected, distance)


def correct(estimate: Estimate, pose: Pose2D, covariance: Array) -> Estimate:
    """Correct an estimate by a pose measured at the same time.

    Args:
        estimate: estimate predicted to the capture time.
        pose: measured pose [m, m, rad].
        covariance: (3, 3) of the measured pose.

    Returns:
        The corrected estimate.

    Raises:
        ControlError: if pose or covariance is not finite.
    """
    _require_measurement(pose, covariance)
    ekf = _extended_kalman_filter()(dim_x=5, dim_z=3)
    ekf.x, ekf.P, ekf.R = estimate.mean.copy(), estimate.covariance.copy(), covariance
    measured = np.array([pose.x, pose.y, pose.theta])
    ekf.update(measured, lambda _: _OBSERVED, lambda mean: mean[:3], residual=_residual)
    return Estimate(estimate.t, ekf.x, _symmetric(ekf.P))


@cache
def _extended_kalman_filter() -> Callable[..., Any]:
    from filterpy.kalman import ExtendedKalmanFilter  # here, for it takes 0.8 s to import

    constructor: Callable[..., Any] = ExtendedKalmanFilter
    return constructor


def _residual(measured: Array, predicted: Array) -> Array:
    difference = measured - predicted
    difference[2] = wrap_angle(float(difference[2]))
    return difference


def _symmetric(matrix: Array) -> Array:
    half: Array = 0.5 * (matrix + matrix.T)
    return half


def _require_measurement(pose: Pose2D, covariance: Array) -> None:
    finite = np.isfinite([pose.x, pose.y, pose.theta]).all() and np.isfinite(covariance).all()
    if covariance.shape != (3, 3) or not finite:
        raise ControlError(f"not a measured pose with a (3, 3) covariance: {pose}, {covariance}")


def _transition(old: UnicycleState, new: UnicycleState, dt: float, lag: float | None) -> Array:
    """Jacobian of the roll from old to new, (5, 5)."""
    decay = exp(-dt / lag) if lag else 1.0
    reach = lag * (1.0 - decay) if lag else dt  # way per initial velocity
    dx, dy, middle = new.x - old.x, new.y - old.y, 0.5 * (old.theta + new.theta)
    f = np.eye(5)
    f[0, 2:] = -dy, reach * cos(middle), -0.5 * reach * dy
    f[1, 2:] = dx, reach * sin(middle), 0.5 * reach * dx
    f[2, 4] = reach
    f[3, 3] = f[4, 4] = decay
    return f


def _process_noise(old: UnicycleState, new: UnicycleState, dt: float, model: MotionModel) -> Array:
    """Covariance that white accelerations add in dt, (5, 5)."""
    way, cross, speed = _white_acceleration(dt, model.lag)
    middle = 0.5 * (old.theta + new.theta)
    # a turn within the interval also shifts the robot sideways, by about a third of way x turn
    sideways = (old.y - new.y) / 3.0, (new.x - old.x) / 3.0
    along = np.array([[cos(middle), 0.0], [sin(middle), 0.0], [0.0, 0.0], [0.0, 1.0], [0.0, 0.0]])
    turning = np.array([[sideways[0], 0.0], [sideways[1], 0.0], [1.0, 0.0], [0.0, 0.0], [0.0, 1.0]])
    unit = _HOLD * np.array([[way, cross], [cross, speed]])
    forward: Array = model.acceleration_std**2 * (along @ unit @ along.T)
    angular: Array = model.angular_acceleration_std**2 * (turning @ unit @ turning.T)
    return forward + angular


def _white_acceleration(dt: float, lag: float | None) -> tuple[float, float, float]:
    """Variance of the way, its covariance with the speed, variance of the speed, per density."""
    if lag is None:
        return dt**3 / 3.0, dt**2 / 2.0, dt
    decay = exp(-dt / lag)
    speed = 0.5 * lag * (1.0 - decay * decay)
    return (
        lag * lag * (dt - 2.0 * lag * (1.0 - decay) + speed),
        0.5 * (lag * (1.0 - decay)) ** 2,
        speed,
    )
