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
        times: (2,) of the estimates (NaN before the first frame), and of `ahead` [s].
        states: estimates of poses and velocities.
        gains: estimates of the drive gains.
        covariance: (R, 7, 7) of both.
        ahead: every robot's state, rolled forward.
    """

    times: Floats
    states: list[UnicycleState]
    gains: list[DriveGain]
    covariance: Floats
    ahead: list[UnicycleState]


@compilable
def nothing_seen(count: int) -> Filters:
    """Filters before the first frame.

    Args:
        count: number of robots.

    Returns:
        Filters that know nothing.
    """
    states = [UnicycleState(0.0, 0.0, 0.0, 0.0, 0.0) for _ in range(count)]
    gains = [DriveGain(1.0, 1.0) for _ in range(count)]
    return Filters(np.full(2, np.nan), states, gains, np.zeros((count, 7, 7)), states.copy())


@compilable
def see(
    filters: Filters, host: Host, noise: Floats, measured: Floats, t: float, sent: Floats,
    ticks: tuple[int, int],
) -> None:  # fmt: skip
    """Correct all filters by a frame.

    Args:
        filters: of all robots.
        host: motion models.
        noise: (2, 3, 3) covariance of a first measured pose, and of all others.
        measured: (R, 3) poses [m, m, rad].
        t: the frame's stamp [s].
        sent: (T, R, 2) commands.
        ticks: first tick with commands, and the present one.
    """
    first, t0 = np.isnan(filters.times[0]), filters.times[0]
    model = host.motion if ticks[0] < ticks[1] else host.free_motion
    for robot in range(len(measured)):
        if first:
            _begin(filters.covariance[robot], host.free_motion, noise[0])
            x, y, theta = measured[robot]
            filters.states[robot] = UnicycleState(x, y, theta, 0.0, 0.0)
        else:
            old, gain = filters.states[robot], filters.gains[robot]
            new = roll_through(old, t0, t, sent, robot, ticks, host, gain)
            filters.states[robot], filters.gains[robot] = _corrected(
                filters.covariance[robot], old, new, gain, t - t0, model, measured[robot], noise[1]
            )
        filters.ahead[robot] = filters.states[robot]
    filters.times[0] = filters.times[1] = t


@compilable
def roll_ahead(
    filters: Filters, host: Host, t: float, sent: Floats, ticks: tuple[int, int]
) -> None:
    """Roll all states forward to the moment when the next commands take effect.

    Args:
        filters: of all robots.
        host: motion models.
        t: that moment [s].
        sent: (T, R, 2) commands.
        ticks: first tick with commands, and the present one.
    """
    t0, ahead = filters.times[1], filters.ahead
    for robot in range(len(ahead)):
        ahead[robot] = roll_through(
            ahead[robot], t0, t, sent, robot, ticks, host, filters.gains[robot]
        )
    filters.times[1] = t


@compilable
def roll_through(
    state: UnicycleState, t0: float, t1: float, sent: Floats, robot: int, ticks: tuple[int, int],
    host: Host, gain: DriveGain,
) -> UnicycleState:  # fmt: skip
    """`motion_model.roll` through a table of commands instead of `SentCommands`.

    Args:
        state: pose and velocities at t0.
        t0: start [s].
        t1: end; the state is returned as it is unless t1 > t0 [s].
        sent: (T, R, 2) commands, by the tick that sent them.
        robot: whose.
        ticks: first tick with commands, and the one after the last that has sent some.
        host: period, delay, motion models.
        gain: velocities it reaches per velocity commanded.

    Returns:
        Pose and velocities at t1.
    """
    first, end = ticks
    standstill = Twist(0.0, 0.0)
    if first >= end:
        return driven(state, standstill, max(t1 - t0, 0.0), host.free_motion.lag, gain)
    number = end - 1
    while number >= first and number * host.period + host.delay > t0:
        number -= 1
    while t0 < t1:
        until = (number + 1) * host.period + host.delay if number + 1 < end else t1
        until = min(until, t1)
        given = number >= first
        command = Twist(sent[number, robot, 0], sent[number, robot, 1]) if given else standstill
        state = driven(state, command, until - t0, host.motion.lag, gain)
        t0, number = until, number + 1
    return state


@compilable
def _begin(covariance: Floats, model: MotionModel, noise: Floats) -> None:
    """As `estimation.initial_estimate`: the model's doubt of velocities and gains."""
    covariance[:3, :3] = noise
    covariance[3, 3], covariance[4, 4] = model.initial_v_std**2, model.initial_omega_std**2
    covariance[5, 5] = covariance[6, 6] = model.gain_std**2


@compilable
def _corrected(
    covariance: Floats, old: UnicycleState, new: UnicycleState, gain: DriveGain, dt: float,
    model: MotionModel, pose: Floats, noise: Floats,
) -> tuple[UnicycleState, DriveGain]:  # fmt: skip
    """As `estimation.predict` and `estimation.correct`; the covariance (7, 7) is written over."""
    f = transition(old, new, dt, model.lag, gain)
    before = propagate(covariance, f, process_noise(old, new, dt, model))
    mean = np.array((new.x, new.y, new.theta, new.v, new.omega, gain.v, gain.omega))
    m, covariance[:] = correct_by_pose(mean, before, pose, noise)
    return UnicycleState(m[0], m[1], m[2], m[3], m[4]), DriveGain(m[5], m[6])
