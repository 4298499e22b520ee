"""The host's filters in one run: corrected at capture time, rolled on through the commands sent."""

from typing import NamedTuple

import numpy as np

from control.actuation import DriveGain
from control.compilable import compilable
from control.kalman import correct_by_pose, propagate
from control.motion_model import MotionModel, driven, process_noise, transition
from control.unicycle import Twist, UnicycleState
from datasets.simulation.inputs import Floats, Host


class Filters(NamedTuple):
    """What the host believes of the robots.

    Attributes:
        means: (R, 7) estimates of states and drive gains.
        covariance: (R, 7, 7) of them.
        ahead: (R, 5) every robot's state, rolled forward.
        room: (7, 3) for `kalman.correct_by_pose`.
    """

    means: Floats
    covariance: Floats
    ahead: Floats
    room: Floats


@compilable
def nothing_seen(count: int) -> Filters:
    """Filters before the first frame.

    Args:
        count: number of robots.

    Returns:
        Filters that know nothing.
    """
    means = np.zeros((count, 7))
    means[:, 5:] = 1.0
    return Filters(means, np.zeros((count, 7, 7)), np.zeros((count, 5)), np.empty((7, 3)))


@compilable
def state_of(table: Floats, robot: int) -> UnicycleState:
    """A robot's state in a table.

    Args:
        table: (R, 5 or more) x, y, theta, v, omega.
        robot: number of the robot.

    Returns:
        Pose and velocities.
    """
    return UnicycleState(
        table[robot, 0], table[robot, 1], table[robot, 2], table[robot, 3], table[robot, 4]
    )


@compilable
def gain_of(means: Floats, robot: int) -> DriveGain:
    """A robot's drive gains.

    Args:
        means: (R, 7) as in `Filters`.
        robot: number of the robot.

    Returns:
        Estimates of both.
    """
    return DriveGain(means[robot, 5], means[robot, 6])


@compilable
def see(
    filters: Filters, host: Host, noise: Floats, measured: Floats, t0: float, t1: float,
    sent: Floats, ticks: tuple[int, int],
) -> None:  # fmt: skip
    """Correct all filters by a frame, as `estimation.predict` and `estimation.correct`.

    Args:
        filters: of all robots.
        host: motion models.
        noise: (2, 3, 3) covariance of a first measured pose, and of all others.
        measured: (R, 3) poses [m, m, rad].
        t0: the stamp of the frame before, NaN for the first [s].
        t1: the frame's stamp [s].
        sent: (T, R, 2) commands.
        ticks: first tick with commands, and the present one.
    """
    model = host.motion if ticks[0] < ticks[1] else host.free_motion
    means, ahead = filters.means, filters.ahead
    ahead[:] = means[:, :5]
    roll_ahead(ahead, means, host, t0, t1, sent, ticks)
    for robot in range(len(measured)):
        covariance = filters.covariance[robot]
        if np.isnan(t0):
            _begin(covariance, host.free_motion, noise[0])
            means[robot, :3] = measured[robot]
        else:
            old, new, gain = state_of(means, robot), state_of(ahead, robot), gain_of(means, robot)
            f = transition(old, new, t1 - t0, model.lag, gain)
            propagate(covariance, f, process_noise(old, new, t1 - t0, model))
            state, gain = correct_by_pose(
                new, gain, covariance, measured[robot], noise[1], filters.room
            )
            _put(means, robot, state)
            means[robot, 5], means[robot, 6] = gain.v, gain.omega
    ahead[:] = means[:, :5]


@compilable
def roll_ahead(
    ahead: Floats, means: Floats, host: Host, t0: float, t1: float, sent: Floats,
    ticks: tuple[int, int],
) -> None:  # fmt: skip
    """`motion_model.roll` of all robots through a table of commands.

    Args:
        ahead: (R, 5) states at t0, replaced by those at t1.
        means: (R, 7) as in `Filters`.
        host: period, delay, motion models.
        t0: start [s].
        t1: end; nothing changes unless t1 > t0 [s].
        sent: (T, R, 2) commands, by the tick that sent them.
        ticks: first tick with commands, and the one after the last that has sent some.
    """
    first, end = ticks
    number = end - 1
    while number >= first and number * host.period + host.delay > t0:
        number -= 1
    while t0 < t1:
        until, lag = t1, host.motion.lag
        if first >= end:
            lag = host.free_motion.lag
        elif number + 1 < end:
            until = min((number + 1) * host.period + host.delay, t1)
        for robot in range(len(ahead)):
            command = Twist(0.0, 0.0)
            if first <= number < end:
                command = Twist(sent[number, robot, 0], sent[number, robot, 1])
            state, gain = state_of(ahead, robot), gain_of(means, robot)
            _put(ahead, robot, driven(state, command, until - t0, lag, gain))
        t0, number = until, number + 1


@compilable
def _put(table: Floats, robot: int, state: UnicycleState) -> None:
    table[robot, 0], table[robot, 1], table[robot, 2] = state.x, state.y, state.theta
    table[robot, 3], table[robot, 4] = state.v, state.omega


@compilable
def _begin(covariance: Floats, model: MotionModel, noise: Floats) -> None:
    """As `estimation.initial_estimate`: the model's doubt of velocities and gains."""
    covariance[:3, :3] = noise
    covariance[3, 3], covariance[4, 4] = model.initial_v_std**2, model.initial_omega_std**2
    covariance[5, 5] = covariance[6, 6] = model.gain_std**2
