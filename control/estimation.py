"""An extended Kalman filter per robot: corrected at capture time, rolled on to command time.

State: x, y, theta, v, omega, and the gains with which the robot answers commands. The mean
follows the unicycle exactly through every command sent; the covariance is propagated once per
interval between frames.
"""

from copy import copy
from dataclasses import dataclass
from functools import cache
from math import isfinite
from typing import Any

import numpy as np

from control.actuation import DriveGain
from control.errors import ControlError
from control.geometry import Pose2D, wrap_angle
from control.history import SentCommands as SentCommands
from control.kalman import GAIN_RANGE
from control.motion_model import Array, process_noise, transition
from control.motion_model import MotionModel as MotionModel
from control.motion_model import roll as roll
from control.unicycle import UnicycleState

_OBSERVED = np.eye(3, 7)  # a camera sees the pose alone


@dataclass(frozen=True, slots=True)
class Estimate:
    """What is believed of one robot at one time.

    Attributes:
        t: the time, on the capture clock [s].
        mean: (7,) x, y, theta (not wrapped), v, omega, gain of v, gain of omega
            [m, m, rad, m/s, rad/s, 1, 1]; read-only.
        covariance: (7, 7) of the mean, symmetric; read-only.
    """

    t: float
    mean: Array
    covariance: Array

    def __post_init__(self) -> None:
        self.mean.flags.writeable = False
        self.covariance.flags.writeable = False

    @property
    def state(self) -> UnicycleState:
        """Pose and velocities [m, m, rad, m/s, rad/s]."""
        return UnicycleState(*self.mean[:5].tolist())

    @property
    def gain(self) -> DriveGain:
        """Velocities the robot reaches per velocity commanded [1]."""
        return DriveGain(*self.mean[5:].tolist())


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
    """Estimate from a first measured pose: velocities 0 and gains 1, with the model's doubt.

    Args:
        pose: measured pose [m, m, rad].
        covariance: (3, 3) of the pose.
        t: capture time [s].
        model: motion model for the doubt of velocities and gains; the default one if None.

    Returns:
        The estimate at t.

    Raises:
        ControlError: if pose or covariance is not finite.
    """
    _require_measurement(pose, covariance)
    model = model or MotionModel()
    stds = (0.0, 0.0, 0.0, model.initial_v_std, model.initial_omega_std)
    full = np.diag(np.square((*stds, model.gain_std, model.gain_std)))
    full[:3, :3] = covariance
    return Estimate(t, np.array([pose.x, pose.y, pose.theta, 0.0, 0.0, 1.0, 1.0]), full)


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
    if not dt >= 0.0:
        raise ControlError(f"an estimate of {estimate.t:.4f} s cannot be taken back to {t:.4f} s")
    if dt == 0.0:
        return estimate
    old, gain = estimate.state, estimate.gain
    new = roll(old, estimate.t, t, sent, model, gain)
    f = transition(old, new, dt, model.lag, gain).matrix
    covariance = f @ estimate.covariance @ f.T + process_noise(old, new, dt, model).matrix
    mean = np.array([new.x, new.y, new.theta, new.v, new.omega, gain.v, gain.omega])
    return Estimate(t, mean, _symmetric(covariance))


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
    ekf = copy(_extended_kalman_filter())
    ekf.x, ekf.P, ekf.R = estimate.mean, estimate.covariance, covariance
    measured = np.array([pose.x, pose.y, pose.theta])
    ekf.update(measured, lambda _: _OBSERVED, lambda mean: mean[:3], residual=_residual)
    mean: Array = ekf.x
    mean[5:] = mean[5:].clip(*GAIN_RANGE)
    return Estimate(estimate.t, mean, _symmetric(ekf.P))


def load_filter() -> None:
    """Import the filter's library now (0.8 s), so that the first frame need not wait for it."""
    _extended_kalman_filter()


@cache
def _extended_kalman_filter() -> Any:
    """An empty filter to copy: making one takes a fifth of an update."""
    from filterpy.kalman import ExtendedKalmanFilter  # here, for it takes 0.8 s to import

    return ExtendedKalmanFilter(dim_x=7, dim_z=3)


def _residual(measured: Array, predicted: Array) -> Array:
    difference = measured - predicted
    difference[2] = wrap_angle(float(difference[2]))
    return difference


def _symmetric(matrix: Array) -> Array:
    half: Array = 0.5 * (matrix + matrix.T)
    return half


def _require_measurement(pose: Pose2D, covariance: Array) -> None:
    finite = isfinite(pose.x + pose.y + pose.theta) and isfinite(float(covariance.sum()))
    if covariance.shape != (3, 3) or not finite:
        raise ControlError(f"not a measured pose with a (3, 3) covariance: {pose}, {covariance}")
