"""How a robot is believed to move: the roll of its state and the Jacobian and noise of that roll.

Extended state: x, y, theta, v, omega and the two drive gains, (7,).
"""

from dataclasses import dataclass
from math import ceil, cos, exp, inf, sin

import numpy as np
from numpy.typing import NDArray

from control.actuation import NOMINAL_GAIN, DriveGain
from control.compilable import compilable
from control.errors import ControlError
from control.history import SentCommands
from control.unicycle import Twist, UnicycleState, advance_lagged, advance_pose
from control.value import value

Array = NDArray[np.float64]

_FINE = 0.01  # longest piece of a roll: its curve is laid along one arc [s]
_ROUNDING = 1e-9  # a piece longer than that by rounding is no reason for two [1]
_HOLD = 1.0 / 30.0  # for which an unknown acceleration keeps its value in MotionModel [s]

UNCOMMANDED = inf
"""Lag of a robot whose commands nobody knows: it keeps its velocities [s]."""


@value
@dataclass(frozen=True, slots=True)
class MotionModel:
    """How a robot is believed to move between frames.

    Attributes:
        lag: time constant with which it follows the commands sent to it, > 0; `UNCOMMANDED` if
            nobody knows them: it then keeps its velocities but for unknown accelerations [s].
        acceleration_std: unknown forward acceleration, standard deviation of a value that holds
            for 1/30 s [m/s^2].
        angular_acceleration_std: the same of the turning [rad/s^2].
        initial_v_std: doubt of the forward velocity, 0, at the first frame [m/s].
        initial_omega_std: doubt of the angular velocity, 0, at the first frame [rad/s].
        gain_std: doubt of the drive gains, 1, at the first frame; 0 keeps them at 1 [1].
        gain_drift: how the doubt of a gain grows with the way driven, or the angle turned, under
            it: deviation after 1 m, or 1 rad [1].

    Raises:
        ControlError: if the lag or a deviation of motion is not positive, or one of the gains is
            negative.
    """

    lag: float = 0.05
    acceleration_std: float = 2.0
    angular_acceleration_std: float = 5.0
    initial_v_std: float = 0.03
    initial_omega_std: float = 0.1
    gain_std: float = 0.15
    gain_drift: float = 0.04

    def __post_init__(self) -> None:
        accelerations = (self.acceleration_std, self.angular_acceleration_std)
        speeds = (self.initial_v_std, self.initial_omega_std)
        positive = min(*accelerations, *speeds, self.lag) > 0.0
        if not (positive and min(self.gain_std, self.gain_drift) >= 0.0):
            raise ControlError(f"a motion model needs a lag and deviations > 0, got {self}")


@value
@dataclass(frozen=True, slots=True)
class Transition:
    """Jacobian of a roll with respect to the extended state: what is not as in the identity.

    Attributes:
        x: change of x per theta, v, omega and the gains of v and omega.
        y: the same of y.
        theta: change of theta per omega and the gain of omega.
        v: change of v per v and the gain of v.
        omega: change of omega per omega and the gain of omega.
    """

    x: tuple[float, float, float, float, float]
    y: tuple[float, float, float, float, float]
    theta: tuple[float, float]
    v: tuple[float, float]
    omega: tuple[float, float]

    @property
    def matrix(self) -> Array:
        """(7, 7), upper triangular."""
        f = np.eye(7)
        f[0, 2:], f[1, 2:], f[2, 4::2] = self.x, self.y, self.theta
        f[3, 3::2], f[4, 4::2] = self.v, self.omega
        return f


@value
@dataclass(frozen=True, slots=True)
class ProcessNoise:
    """Covariance of what nobody knows in a roll; what is not given is 0.

    Attributes:
        x: covariances of x with x, y, theta, v, omega.
        y: of y with y, theta, v, omega.
        theta: of theta with theta, omega.
        speeds: variances of v and omega.
        gains: variances of the gains of v and omega.
    """

    x: tuple[float, float, float, float, float]
    y: tuple[float, float, float, float]
    theta: tuple[float, float]
    speeds: tuple[float, float]
    gains: tuple[float, float]

    @property
    def matrix(self) -> Array:
        """(7, 7), symmetric."""
        q = np.diag((self.x[0], self.y[0], self.theta[0], *self.speeds, *self.gains))
        q[0, 1:5], q[1, 2:5], q[2, 4] = self.x[1:], self.y[1:], self.theta[1]
        q[1:5, 0], q[2:5, 1], q[4, 2] = self.x[1:], self.y[1:], self.theta[1]
        return q


def roll(
    state: UnicycleState,
    t0: float,
    t1: float,
    sent: SentCommands,
    model: MotionModel,
    gain: DriveGain = NOMINAL_GAIN,
) -> UnicycleState:
    """Roll a state forward through every command in force on the way.

    Args:
        state: pose and velocities at t0.
        t0: start [s].
        t1: end; the state is returned as it is unless t1 > t0 [s].
        sent: commands sent to this robot.
        model: how it moves.
        gain: velocities it reaches per velocity commanded.

    Returns:
        Pose and velocities at t1; the heading is not wrapped.
    """
    if model.lag == UNCOMMANDED:
        return driven(state, state.twist, max(t1 - t0, 0.0), model.lag, gain)
    for dt, command in sent.between(t0, t1):
        state = driven(state, command, dt, model.lag, gain)
    return state


@compilable
def driven(
    state: UnicycleState, command: Twist, dt: float, lag: float, gain: DriveGain
) -> UnicycleState:
    """Drive under one command, in pieces short enough for arcs.

    Args:
        state: pose and velocities at the start.
        command: in force all the time [m/s, rad/s].
        dt: duration, >= 0 [s].
        lag: time constant of the motors; `UNCOMMANDED`: the robot coasts [s].
        gain: velocities it reaches per velocity commanded.

    Returns:
        Pose and velocities at the end; the heading is not wrapped.
    """
    if lag == UNCOMMANDED:
        pose = advance_pose(state.pose, state.twist, dt)
        return UnicycleState(pose.x, pose.y, pose.theta, state.v, state.omega)
    goal = Twist(gain.v * command.v, gain.omega * command.omega)
    pieces = ceil(dt / _FINE - _ROUNDING)
    for _ in range(pieces):
        state = advance_lagged(state, goal, dt / pieces, lag)
    return state


@compilable
def transition(
    old: UnicycleState, new: UnicycleState, dt: float, lag: float, gain: DriveGain
) -> Transition:
    """Jacobian of the roll from old to new with respect to the extended state.

    Args:
        old: state at the start.
        new: state at the end.
        dt: duration [s].
        lag: time constant of the motors; `UNCOMMANDED`: the robot coasts [s].
        gain: drive gains during the roll.

    Returns:
        Its entries.
    """
    commanded = lag != UNCOMMANDED
    decay = exp(-dt / lag)
    reach = lag * (1.0 - decay) if commanded else dt  # way per initial velocity
    way = turn = v = omega = 0.0  # per gain
    if commanded:
        way, turn = _way_and_turn(old, new)
        way, turn = (way - reach * old.v) / gain.v, (turn - reach * old.omega) / gain.omega
        v = (new.v - decay * old.v) / gain.v  # what the commands gave
        omega = (new.omega - decay * old.omega) / gain.omega
    (along_x, along_y), (aside_x, aside_y) = _per_way(old, new), _per_turn(old, new)
    return Transition(
        x=(old.y - new.y, reach * along_x, reach * aside_x, way * along_x, turn * aside_x),
        y=(new.x - old.x, reach * along_y, reach * aside_y, way * along_y, turn * aside_y),
        theta=(reach, turn),
        v=(decay, v),
        omega=(decay, omega),
    )


@compilable
def process_noise(
    old: UnicycleState, new: UnicycleState, dt: float, model: MotionModel
) -> ProcessNoise:
    """Covariance that unknown accelerations and drifting gains add during the roll.

    Args:
        old: state at the start.
        new: state at the end.
        dt: duration [s].
        model: how the robot moves.

    Returns:
        Its entries.
    """
    way, cross, speed = _white_acceleration(dt, model.lag)
    forward = _HOLD * model.acceleration_std**2
    turning = _HOLD * model.angular_acceleration_std**2
    fw, fc, fs = forward * way, forward * cross, forward * speed
    tw, tc, ts = turning * way, turning * cross, turning * speed
    (a, b), (c, d) = _per_way(old, new), _per_turn(old, new)
    way_driven, turned = _way_and_turn(old, new)
    drift = model.gain_drift**2
    return ProcessNoise(
        x=(fw * a * a + tw * c * c, fw * a * b + tw * c * d, tw * c, fc * a, tc * c),
        y=(fw * b * b + tw * d * d, tw * d, fc * b, tc * d),
        theta=(tw, tc),
        speeds=(fs, ts),
        gains=(drift * abs(way_driven), drift * abs(turned)),
    )


@compilable
def _way_and_turn(old: UnicycleState, new: UnicycleState) -> tuple[float, float]:
    """Way [m] and turn [rad] from old to new."""
    middle = 0.5 * (old.theta + new.theta)
    way = (new.x - old.x) * cos(middle) + (new.y - old.y) * sin(middle)
    return way, new.theta - old.theta


@compilable
def _per_way(old: UnicycleState, new: UnicycleState) -> tuple[float, float]:
    """Change of the end by a little more way [1]."""
    middle = 0.5 * (old.theta + new.theta)
    return cos(middle), sin(middle)


@compilable
def _per_turn(old: UnicycleState, new: UnicycleState) -> tuple[float, float]:
    """Change of the end by a little more turn [m/rad].

    Turning evenly on the way, the robot ends beside its end by half the turn times the way.
    """
    return -0.5 * (new.y - old.y), 0.5 * (new.x - old.x)


@compilable
def _white_acceleration(dt: float, lag: float) -> tuple[float, float, float]:
    """Variance of the way, its covariance with the speed, variance of the speed, per density."""
    if lag == UNCOMMANDED:
        return dt**3 / 3.0, dt**2 / 2.0, dt
    decay = exp(-dt / lag)
    reach = lag * (1.0 - decay)
    speed = 0.5 * lag * (1.0 - decay * decay)
    return lag * lag * (dt - 2.0 * reach + speed), 0.5 * reach * reach, speed
