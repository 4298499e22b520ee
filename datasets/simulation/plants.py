"""The robots of one run: model (3), leg by leg, and where they are in every picture."""

from dataclasses import dataclass
from math import inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from control.compilable import compilable
from control.unicycle import SpeedLimits, Twist
from control.value import value
from datasets.plant import GRID, SLACK, Motion, motion_after, wave
from datasets.simulation.inputs import Floats, Integers


@value
@dataclass(frozen=True, slots=True)
class Plant:
    """A robot as it really is.

    Attributes:
        lag: time constant of the motors [s].
        mass_error: eps of (5).
        inertia_error: eps' of (5).
        limits: greatest speeds.
        push_v: bound of the forward disturbance [m/s^2].
        push_omega: bound of the angular disturbance [rad/s^2].
    """

    lag: float
    mass_error: float
    inertia_error: float
    limits: SpeedLimits
    push_v: float
    push_omega: float


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
    """The robots of one run.

    Attributes:
        kinds: every robot as it really is.
        legs: the present leg of every robot.
        drives: the command that every robot obeys, as it was sent.
        next: (R, 3) numbers of the next grid point, command and picture of every robot.
        poses: (F, R, 3) where robots are in every picture.
    """

    kinds: list[Plant]
    legs: list[Leg]
    drives: list[Twist]
    next: Integers
    poses: Floats


@compilable
def place(starts: Floats, plants: Floats, pictures: int, first_command: int) -> Plants:
    """Put the robots on the floor.

    Args:
        starts: (R, 5) as in `Field`.
        plants: (R, 7) as in `Field`.
        pictures: how many will be taken.
        first_command: first tick with commands.

    Returns:
        The robots at t = 0.
    """
    count, kinds, legs = len(starts), [], []
    following = np.empty((count, 3), np.int64)
    for robot in range(count):
        lag, mass, inertia, v_most, omega_most, v_push, omega_push = plants[robot]
        limits = SpeedLimits(v_most, omega_most)
        kinds.append(Plant(lag, mass, inertia, limits, v_push, omega_push))
        x, y, theta, v, omega = starts[robot]
        legs.append(Leg(0.0, (x, y, theta, v, omega), v, omega, lag))
        following[robot, 0], following[robot, 1], following[robot, 2] = 1, first_command, 0
    drives = [Twist(np.nan, np.nan) for _ in range(count)]
    return Plants(kinds, legs, drives, following, np.empty((pictures, count, 3)))


@compilable
def drive_until(
    plants: Plants, tick: int, period: float, delay: float, sent: Floats,
    lost: NDArray[np.bool_], taken: Floats, tones: Floats,
) -> None:  # fmt: skip
    """Let all robots drive until a tick; pictures that fall due on the way are taken.

    Args:
        plants: the robots.
        tick: number of the tick.
        period: between two ticks [s].
        delay: from a tick to the arrival of its commands [s].
        sent: (T, R, 2) commands of all ticks before this one.
        lost: (T, R) commands that never arrive.
        taken: (F,) when the pictures are taken, ascending [s].
        tones: (R, 2, TONES, 2) of the disturbances.
    """
    t, following = tick * period, plants.next
    for robot in range(len(plants.legs)):
        leg, kind, drive = plants.legs[robot], plants.kinds[robot], plants.drives[robot]
        while True:
            while following[robot, 1] < tick and lost[following[robot, 1], robot]:
                following[robot, 1] += 1
            command, picture, due = (
                following[robot, 1],
                following[robot, 2],
                following[robot, 0] * GRID,
            )
            arrival = command * period + delay if command < tick else inf
            begin = due if abs(arrival - due) < SLACK else min(arrival, due)
            while picture < len(taken) and taken[picture] <= min(begin, t):
                motion = leg.at(taken[picture])
                for axis in range(3):
                    plants.poses[picture, robot, axis] = motion[axis]
                picture += 1
            following[robot, 2] = picture
            if begin > t:
                break
            if arrival < begin + SLACK:
                drive = Twist(sent[command, robot, 0], sent[command, robot, 1])
                following[robot, 1] += 1
            following[robot, 0] += begin == due
            push = 0.0, 0.0
            if kind.push_v > 0.0 or kind.push_omega > 0.0:
                push = wave(tones[robot, 0], begin), wave(tones[robot, 1], begin)
            leg = _next_leg(leg, begin, kind, drive, push)
        plants.legs[robot], plants.drives[robot] = leg, drive


@compilable
def _next_leg(leg: Leg, t: float, plant: Plant, drive: Twist, push: tuple[float, float]) -> Leg:
    """A step that begins now, under the present drive and disturbance."""
    motion = leg.at(t)
    if np.isnan(drive.v):  # not commanded yet: the motors keep what they do
        return Leg(t, motion, leg.goal_v, leg.goal_omega, leg.lag)
    wanted, lag = plant.limits.saturate(drive), plant.lag
    goal_v = (1.0 + plant.mass_error) * wanted.v + lag * (plant.push_v * push[0])
    goal_omega = (1.0 + plant.inertia_error) * wanted.omega + lag * (plant.push_omega * push[1])
    return Leg(t, motion, goal_v, goal_omega, lag)
