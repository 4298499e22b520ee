"""What a robot's drive really does, fitted to the poses seen while it obeyed known commands.

The model is that of the filter (`control.motion_model`): velocities follow `gain * command` with a
first-order lag, the wheels roll without slip, and all of it happens `delay` after the sending. The
commands are integrated as they are, constant from one sending to the next, so that the delay is
found far below the time between two frames.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import cos, sin, sqrt

import numpy as np
import scipy
from numpy.typing import NDArray

from control.actuation import DriveGain
from control.errors import ControlError
from control.geometry import Pose2D, wrap_angle
from control.history import SentCommands
from control.motion_model import MotionModel, roll
from control.unicycle import UnicycleState

Floats = NDArray[np.float64]
Drives = Callable[[float, float, float, float], Floats]

FEWEST = 20
"""Poses without which nothing is fitted."""

_NAMES = ("forward gain", "turning gain", "lag", "delay")
_DRIVE = slice(6, 10)  # these among the parameters; before them: start and mount of the tag
_LOW = (-np.inf,) * 6 + (0.05, 0.05, 1e-3, -0.5)
_HIGH = (np.inf,) * 6 + (20.0, 20.0, 1.0, 1.0)
_SCALE = (0.01, 0.01, 0.1, 0.005, 0.005, 0.05, 0.1, 0.1, 0.02, 0.02)
_GUESS = (0.0, 0.0, 0.0, 1.0, 1.0, 0.06, 0.03)  # mount, gains, lag, delay
_OUTLIER = 4.0  # standard deviations from which a pose counts less
_ALIKE = 12  # frames over which errors of poses resemble each other
_AGAIN = 8  # drives that are asked for again while other parameters change
_HARDLY = 0.06  # gains as small as this are no gains
_VAGUE = (0.1, 0.1, 0.05, 0.05)  # standard errors with which nothing is known [1, 1, s, s]


@dataclass(frozen=True, slots=True)
class SeenPose:
    """Where a tag was seen.

    Attributes:
        t: capture time, on the clock of the commands [s].
        pose: of the tag on the floor [m, m, rad].
        covariance: of the pose, shape (3, 3) [m^2, m rad, rad^2].
    """

    t: float
    pose: Pose2D
    covariance: Floats


@dataclass(frozen=True, slots=True)
class DriveFit:
    """What was found of one robot.

    Attributes:
        gain: velocities it reaches per velocity commanded.
        lag: time constant of its motors [s].
        delay: from sending a command to its effect in the pictures, on their clock [s].
        mount: the tag in the robot's frame, whose origin is the middle of the axle [m, m, rad].
        covariance: of forward gain, turning gain, lag and delay, shape (4, 4) [1, 1, s, s].
        position_rms: of what the model leaves unexplained [m].
        heading_rms: the same of headings [rad].
        poses: how many were used.
    """

    gain: DriveGain
    lag: float
    delay: float
    mount: Pose2D
    covariance: Floats
    position_rms: float
    heading_rms: float
    poses: int

    @property
    def std(self) -> tuple[float, ...]:
        """Standard errors of forward gain, turning gain, lag and delay [1, 1, s, s]."""
        return tuple(np.sqrt(np.diag(self.covariance)).tolist())


def fit_drive(sent: SentCommands, seen: Sequence[SeenPose]) -> DriveFit:
    """Fit gains, lag and delay to a drive that began at rest.

    Args:
        sent: all commands of the drive, by the time of their sending.
        seen: poses before, during and after it, ascending in time.

    Returns:
        The fit.

    Raises:
        ControlError: if there are too few poses, or what was driven does not tell all of it.
    """
    if len(seen) < FEWEST or not sent.times:
        raise ControlError(f"{len(seen)} poses, {FEWEST} needed, and {len(sent.times)} commands")
    times = np.array([pose.t for pose in seen])
    poses = np.array([(p.pose.x, p.pose.y, p.pose.theta) for p in seen])
    whitening = np.array([np.linalg.inv(np.linalg.cholesky(p.covariance)) for p in seen])
    drives = _drives(sent, times)

    def _residuals(parameters: Floats) -> Floats:
        errors = _errors(parameters, drives, poses)
        whitened: Floats = np.einsum("kij,kj->ki", whitening, errors)
        return whitened.ravel()

    result = scipy.optimize.least_squares(
        _residuals, (*poses[0], *_GUESS), bounds=(_LOW, _HIGH), x_scale=_SCALE,
        loss="soft_l1", f_scale=_OUTLIER,
    )  # fmt: skip
    _require_told(result)
    return _as_fit(result.x, _covariance(result), _errors(result.x, drives, poses))


def driven_poses(
    start: Pose2D, fit: DriveFit, sent: SentCommands, times: Sequence[float]
) -> Floats:
    """Where the tag of a robot is seen that starts from rest.

    Args:
        start: of the robot, not of its tag [m, m, rad].
        fit: how it drives.
        sent: commands by the time of their sending.
        times: ascending [s].

    Returns:
        Poses of the tag, shape (N, 3), headings not wrapped [m, m, rad].
    """
    m, gain = fit.mount, fit.gain
    parameters = (start.x, start.y, start.theta, m.x, m.y, m.theta, gain.v, gain.omega)
    drives = _drives(sent, np.array(times))
    return _tag_poses(np.array((*parameters, fit.lag, fit.delay)), drives)


def _errors(parameters: Floats, drives: Drives, poses: Floats) -> Floats:
    """Seen less modelled, (N, 3), headings wrapped."""
    errors = poses - _tag_poses(parameters, drives)
    errors[:, 2] = np.mod(errors[:, 2] + np.pi, 2.0 * np.pi) - np.pi
    return errors


def _tag_poses(parameters: Floats, drives: Drives) -> Floats:
    """The drive under parameters: start, mount, gains, lag, delay."""
    x, y, theta, mx, my, turned = parameters[:6].tolist()
    gain_v, gain_omega, lag, delay = parameters[_DRIVE].tolist()
    along, left, heading = drives(gain_v, gain_omega, lag, delay).T
    c, s = np.cos(heading), np.sin(heading)
    along, left = along + c * mx - s * my, left + s * mx + c * my
    c, s = cos(theta), sin(theta)
    return np.column_stack(
        (x + c * along - s * left, y + s * along + c * left, theta + heading + turned)
    )


def _drives(sent: SentCommands, times: Floats) -> Drives:
    """Poses (N, 3) from rest at the origin, by gains, lag and delay; start and mount are cheap."""

    @lru_cache(_AGAIN)
    def _driven(gain_v: float, gain_omega: float, lag: float, delay: float) -> Floats:
        model, gain = MotionModel(lag), DriveGain(gain_v, gain_omega)
        state, t = UnicycleState(0.0, 0.0, 0.0, 0.0, 0.0), sent.times[0]
        poses = []
        for end in (times - delay).tolist():
            state, t = roll(state, t, end, sent, model, gain), max(t, end)
            poses.append((state.x, state.y, state.theta))
        return np.array(poses)

    return _driven


def _require_told(result: "scipy.optimize.OptimizeResult") -> None:
    """Refuse what was driven if it does not tell the whole drive."""
    if min(result.x[_DRIVE][:2]) < _HARDLY:
        raise ControlError("it hardly moved when told to")
    doubt = np.diag(1e-6 / np.square(_SCALE))  # what nothing depends on gets an error, too
    spreads = np.sqrt(np.diag(np.linalg.inv(result.jac.T @ result.jac + doubt)))[_DRIVE]
    vague = [n for n, s, most in zip(_NAMES, spreads, _VAGUE, strict=True) if not s < most]
    if vague:
        raise ControlError(f"what was driven does not tell its {', '.join(vague)}")


def _covariance(result: "scipy.optimize.OptimizeResult") -> Floats:
    """Of the drive's parameters; errors of poses in a row are not independent (Newey, West)."""
    jacobian: Floats = result.jac
    bread = np.linalg.inv(jacobian.T @ jacobian)
    scores = (jacobian * result.fun[:, None]).reshape(-1, 3, result.x.size).sum(axis=1)
    meat = scores.T @ scores
    for apart in range(1, _ALIKE):
        cross = scores[apart:].T @ scores[:-apart]
        meat += (1.0 - apart / _ALIKE) * (cross + cross.T)
    covariance: Floats = (bread @ meat @ bread)[_DRIVE, _DRIVE]
    return covariance


def _as_fit(parameters: Floats, covariance: Floats, errors: Floats) -> DriveFit:
    """The parameters by their names."""
    mx, my, turned, gain_v, gain_omega, lag, delay = parameters[3:].tolist()
    position, heading = (errors[:, :2] ** 2).sum(axis=1), errors[:, 2] ** 2
    return DriveFit(
        DriveGain(gain_v, gain_omega), lag, delay, Pose2D(mx, my, wrap_angle(turned)), covariance,
        sqrt(position.mean()), sqrt(heading.mean()), len(errors),
    )  # fmt: skip
