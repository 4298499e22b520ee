"""The robots of one run: model (3), leg by leg, and what the camera measures of them on the way."""

from dataclasses import dataclass
from math import inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from control.compilable import compilable
from control.unicycle import SpeedLimits, Twist
from control.value import value
from datasets.plant import GRID, SLACK, Motion, motion_after, wave
from datasets.simulation.inputs import Field, Floats, Host, Integers


@value
@dataclass(frozen=True, slots=True)
class Leg:
    """A step with constant drive.

    Attributes:
        t: when it began [s].
        motion: there.
        goal_v: forward velocity it tends to [m/s].
        goal_omega: angular velocity it tends to [rad/s].
        lag: time constant of the motors [s].
    """

    t: float
    motion: Motion
    goal_v: float
    goal_omega: float
    lag: float

    def at(self, t: float) -> Motion:
        """Motion on this leg.

        Args:
            t: time [s].

        Returns:
            x, y, theta, v, omega.
        """
        return motion_after(self.motion, self.goal_v, self.goal_omega, self.lag, t - self.t)


class Plants(NamedTuple):
    """The robots of one run as they really are.

    Attributes:
        legs: the present leg of every robot.
        next: (R, 3) numbers of the next grid point, command and picture of every robot.
        drive: (R, 2) the command that every robot obeys; NaN before the first.
        poses: (F, R, 3) where robots are in every picture.
        tones: (R, 2, TONES, 2) of the disturbances.
        lost: (T, R) commands that never arrive.
        taken: (F,) when the pictures are taken [s].
    """

    legs: list[Leg]
    next: Integers
    drive: Floats
    poses: Floats
    tones: Floats
    lost: NDArray[np.bool_]
    taken: Floats


@compilable
def place(
    field: Field, tones: Floats, lost: NDArray[np.bool_], taken: Floats, first_command: int
) -> Plants:
    """Put the robots on the floor.

    Args:
        field: starts and plants.
        tones: (R, 2, TONES, 2) of the disturbances.
        lost: (T, R) commands that never arrive.
        taken: (F,) when the pictures are taken, ascending [s].
        first_command: first tick with commands.

    Returns:
        The robots at t = 0.
    """
    count = len(field.starts)
    legs = []
    for robot in range(count):
        x, y, theta, v, omega = field.starts[robot]
        legs.append(Leg(0.0, (x, y, theta, v, omega), v, omega, field.plants[robot, 0]))
    following = np.empty((count, 3), np.int64)
    for robot in range(count):
        following[robot, 0], following[robot, 1], following[robot, 2] = 1, first_command, 0
    drive = np.full((count, 2), np.nan)
    return Plants(legs, following, drive, np.empty((len(taken), count, 3)), tones, lost, taken)


@compilable
def drive_until(plants: Plants, field: Field, host: Host, sent: Floats, tick: int) -> None:
    """Let all robots drive until a tick; pictures that fall due on the way are taken.

    Args:
        plants: the robots.
        field: their constants.
        host: period and delay.
        sent: (T, R, 2) commands of all ticks before this one.
        tick: number of the tick.
    """
    t = tick * host.period
    for robot in range(len(plants.legs)):
        while True:
            due = plants.next[robot, 0] * GRID
            arrival = _arrival(plants, host, robot, tick)
            begin = due if abs(arrival - due) < SLACK else min(arrival, due)
            _take_pictures(plants, robot, min(begin, t))
            if begin > t:
                break
            if arrival < begin + SLACK:
                command = sent[plants.next[robot, 1], robot]
                plants.drive[robot, 0], plants.drive[robot, 1] = command[0], command[1]
                plants.next[robot, 1] += 1
            if begin == due:
                plants.next[robot, 0] += 1
            plants.legs[robot] = _leg(plants, field, robot, begin)


@compilable
def _arrival(plants: Plants, host: Host, robot: int, tick: int) -> float:
    """When the next command of those sent before a tick arrives; inf without one."""
    while plants.next[robot, 1] < tick and plants.lost[plants.next[robot, 1], robot]:
        plants.next[robot, 1] += 1
    number = plants.next[robot, 1]
    return number * host.period + host.delay if number < tick else inf


@compilable
def _take_pictures(plants: Plants, robot: int, until: float) -> None:
    """Note where a robot is in the pictures that its present leg reaches."""
    leg, number = plants.legs[robot], plants.next[robot, 2]
    while number < len(plants.taken) and plants.taken[number] <= until:
        x, y, theta, _, _ = leg.at(plants.taken[number])
        pose = plants.poses[number, robot]
        pose[0], pose[1], pose[2] = x, y, theta
        number += 1
    plants.next[robot, 2] = number


@compilable
def _leg(plants: Plants, field: Field, robot: int, t: float) -> Leg:
    """A step that begins now, under the present drive and disturbance."""
    motion = plants.legs[robot].at(t)
    lag, mass, inertia, v_most, omega_most, v_push, omega_push = field.plants[robot]
    if np.isnan(plants.drive[robot, 0]):  # not commanded yet: the motors keep what they do
        start = field.starts[robot]
        return Leg(t, motion, start[3], start[4], lag)
    wanted = Twist(plants.drive[robot, 0], plants.drive[robot, 1])
    drive = SpeedLimits(v_most, omega_most).saturate(wanted)
    goal_v, goal_omega = (1.0 + mass) * drive.v, (1.0 + inertia) * drive.omega
    if v_push > 0.0 or omega_push > 0.0:
        goal_v += lag * v_push * wave(plants.tones[robot, 0], t)
        goal_omega += lag * omega_push * wave(plants.tones[robot, 1], t)
    return Leg(t, motion, goal_v, goal_omega, lag)
