"""The host's filters in one run: corrected at capture time, rolled on through the commands sent."""

from typing import NamedTuple

import numpy as np

from control.actuation import DriveGain
from control.compilable import compilable
from control.geometry import wrap_angle
from control.kalman import correct_by_pose, propagate
from control.motion_model import UNCOMMANDED, driven, process_noise, transition
from control.unicycle import Twist, UnicycleState
from datasets.simulation.inputs import Field, Floats, Host


class Filters(NamedTuple):
    """What the host believes of the robots.

    Attributes:
        times: (2,) of the estimates (NaN before the first frame), and of `ahead` [s].
        mean: (R, 7) as in `control/estimation.py`.
        covariance: (R, 7, 7).
        ahead: every robot's state, rolled forward.
    """

    times: Floats
    mean: Floats
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
    ahead = [UnicycleState(0.0, 0.0, 0.0, 0.0, 0.0) for _ in range(count)]
    return Filters(np.full(2, np.nan), np.empty((count, 7)), np.empty((count, 7, 7)), ahead)


@compilable
def see(
    filters: Filters, host: Host, field: Field, measured: Floats, t: float, sent: Floats,
    ticks: tuple[int, int],
) -> None:  # fmt: skip
    """Correct all filters by a frame.

    Args:
        filters: of all robots.
        host: motion models.
        field: what the host thinks of measured poses.
        measured: (R, 3) poses [m, m, rad].
        t: the frame's stamp [s].
        sent: (T, R, 2) commands.
        ticks: first tick with commands, and the present one.
    """
    for robot in range(len(measured)):
        if np.isnan(filters.times[0]):
            _begin(filters, host, field, measured[robot], robot)
        else:
            _correct(filters, host, field, measured[robot], robot, t, sent, ticks)
        m = filters.mean[robot]
        filters.ahead[robot] = UnicycleState(m[0], m[1], m[2], m[3], m[4])
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
    for robot in range(len(filters.ahead)):
        gain = gain_of(filters, robot)
        state, t0 = filters.ahead[robot], filters.times[1]
        filters.ahead[robot] = roll_through(state, t0, t, sent[:, robot], ticks, host, gain)
    filters.times[1] = t


@compilable
def gain_of(filters: Filters, robot: int) -> DriveGain:
    """What is believed of a robot's drive gains.

    Args:
        filters: of all robots.
        robot: its number.

    Returns:
        The gains [1].
    """
    return DriveGain(filters.mean[robot, 5], filters.mean[robot, 6])


@compilable
def roll_through(
    state: UnicycleState, t0: float, t1: float, sent: Floats, ticks: tuple[int, int], host: Host,
    gain: DriveGain,
) -> UnicycleState:  # fmt: skip
    """`motion_model.roll` through a table of commands instead of `SentCommands`.

    Args:
        state: pose and velocities at t0.
        t0: start [s].
        t1: end; the state is returned as it is unless t1 > t0 [s].
        sent: (T, 2) commands of this robot, by the tick that sent them.
        ticks: first tick with commands, and the one after the last that has sent one.
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
        command = Twist(sent[number, 0], sent[number, 1]) if number >= first else standstill
        state = driven(state, command, until - t0, host.motion.lag, gain)
        t0, number = until, number + 1
    return state


@compilable
def _begin(filters: Filters, host: Host, field: Field, pose: Floats, robot: int) -> None:
    """As `estimation.initial_estimate`: velocities 0 and gains 1, with the model's doubt."""
    model, mean = host.free_motion, filters.mean[robot]
    mean[:3], mean[3:5], mean[5:] = pose, 0.0, 1.0
    filters.covariance[robot] = 0.0
    filters.covariance[robot, :3, :3] = field.pose_noise[0]
    stds = model.initial_v_std, model.initial_omega_std, model.gain_std, model.gain_std
    for index in range(4):
        filters.covariance[robot, 3 + index, 3 + index] = stds[index] ** 2


@compilable
def _correct(
    filters: Filters, host: Host, field: Field, pose: Floats, robot: int, t: float, sent: Floats,
    ticks: tuple[int, int],
) -> None:  # fmt: skip
    """As `estimation.predict` and `estimation.correct`."""
    model = host.motion if ticks[0] < ticks[1] else host.free_motion
    m, t0, gain = filters.mean[robot], filters.times[0], gain_of(filters, robot)
    old = UnicycleState(m[0], m[1], m[2], m[3], m[4])
    new = roll_through(old, t0, t, sent[:, robot], ticks, host, gain)
    f = transition(old, new, t - t0, model.lag, gain)
    noise = process_noise(old, new, t - t0, model)
    covariance = propagate(filters.covariance[robot], f, noise)
    m[0], m[1], m[2], m[3], m[4] = new.x, new.y, new.theta, new.v, new.omega
    mean, covariance = correct_by_pose(m, covariance, pose, field.pose_noise[1])
    filters.mean[robot], filters.covariance[robot] = mean, covariance
