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
from datasets.simulation.inputs import Field, Floats, Integers


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
def drive_until(
    plants: Plants, field: Field, period: float, delay: float, sent: Floats, tick: int
) -> None:
    """Let all robots drive until a tick; pictures that fall due on the way are taken.

    Args:
        plants: the robots.
        field: their constants.
        period: between two ticks [s].
        delay: from a tick to the arrival of its commands [s].
        sent: (T, R, 2) commands of all ticks before this one.
        tick: number of the tick.
    """
    t = tick * period
    for robot in range(len(plants.legs)):
        leg, (grid, command, picture) = plants.legs[robot], plants.next[robot]
        while True:
            while command < tick and plants.lost[command, robot]:
                command += 1
            due, arrival = grid * GRID, command * period + delay if command < tick else inf
            begin = due if abs(arrival - due) < SLACK else min(arrival, due)
            until = min(begin, t)
            while picture < len(plants.taken) and plants.taken[picture] <= until:
                _take_picture(plants.poses[picture, robot], leg.at(plants.taken[picture]))
                picture += 1
            if begin > t:
                break
            if arrival < begin + SLACK:
                plants.drive[robot] = sent[command, robot]
                command += 1
            grid += begin == due
            leg = _next_leg(leg, begin, field.plants[robot], plants.drive[robot], plants.tones[robot])
        plants.legs[robot] = leg
        plants.next[robot] = grid, command, picture


@compilable
def _take_picture(pose: Floats, motion: Motion) -> None:
    pose[0], pose[1], pose[2] = motion[0], motion[1], motion[2]


@compilable
def _next_leg(leg: Leg, t: float, plant: Floats, drive: Floats, tones: Floats) -> Leg:
    """A step that begins now, under the present drive and disturbance."""
    motion = leg.at(t)
    if np.isnan(drive[0]):  # not commanded yet: the motors keep what they do
        return Leg(t, motion, leg.goal_v, leg.goal_omega, leg.lag)
    lag, mass, inertia, v_most, omega_most, v_push, omega_push = plant
    wanted = SpeedLimits(v_most, omega_most).saturate(Twist(drive[0], drive[1]))
    goal_v, goal_omega = (1.0 + mass) * wanted.v, (1.0 + inertia) * wanted.omega
    if v_push > 0.0 or omega_push > 0.0:
        goal_v += lag * v_push * wave(tones[0], t)
        goal_omega += lag * omega_push * wave(tones[1], t)
    return Leg(t, motion, goal_v, goal_omega, lag)
