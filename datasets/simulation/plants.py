"""The robots of one run: model (3), leg by leg, and where they are in every picture."""

from dataclasses import dataclass
from math import inf

import numpy as np

from control.compilable import compilable
from control.unicycle import SpeedLimits, Twist
from control.value import value
from datasets.plant import GRID, SLACK, Motion, motion_after, wave
from datasets.simulation.inputs import Chance, Floats, Host


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


@value
@dataclass(frozen=True, slots=True)
class Vehicle:
    """A robot on its way.

    Attributes:
        plant: as it really is.
        leg: the present one.
        drive: the command that it obeys, as it was sent; NaN before the first.
        grid: number of the next grid point.
        command: tick of the next command.
        picture: number of the next picture.
    """

    plant: Plant
    leg: Leg
    drive: Twist
    grid: int
    command: int
    picture: int


@compilable
def place(starts: Floats, plants: Floats, first_command: int) -> list[Vehicle]:
    """Put the robots on the floor.

    Args:
        starts: (R, 5) as in `Field`.
        plants: (R, 7) as in `Field`.
        first_command: first tick with commands.

    Returns:
        The robots at t = 0.
    """
    vehicles = []
    for robot in range(len(starts)):
        lag, mass, inertia, v_most, omega_most, v_push, omega_push = plants[robot]
        limits = SpeedLimits(v_most, omega_most)
        plant = Plant(lag, mass, inertia, limits, v_push, omega_push)
        x, y, theta, v, omega = starts[robot]
        leg = Leg(0.0, (x, y, theta, v, omega), v, omega, lag)
        vehicles.append(Vehicle(plant, leg, Twist(np.nan, np.nan), 1, first_command, 0))
    return vehicles


@compilable
def drive_until(
    vehicles: list[Vehicle], tick: int, host: Host, chance: Chance, sent: Floats, poses: Floats
) -> None:
    """Let all robots drive until a tick; pictures that fall due on the way are taken.

    Args:
        vehicles: the robots, replaced by themselves at the tick.
        tick: number of the tick.
        host: period and delay.
        chance: what happens to the run.
        sent: (T, R, 2) commands of all ticks before this one.
        poses: (F, R, 3) filled with where robots are measured in every picture.
    """
    t, lost, taken = tick * host.period, chance.lost, chance.taken
    noise, tones = chance.noise, chance.tones
    for robot in range(len(vehicles)):
        vehicle = vehicles[robot]
        plant, leg, drive = vehicle.plant, vehicle.leg, vehicle.drive
        grid, command, picture = vehicle.grid, vehicle.command, vehicle.picture
        while True:
            while command < tick and lost[command, robot]:
                command += 1
            due = grid * GRID
            arrival = command * host.period + host.delay if command < tick else inf
            begin = due if abs(arrival - due) < SLACK else min(arrival, due)
            while picture < len(taken) and taken[picture] <= min(begin, t):
                motion = leg.at(taken[picture])
                for axis in range(3):
                    poses[picture, robot, axis] = motion[axis] + noise[picture, robot, axis]
                picture += 1
            if begin > t:
                break
            if arrival < begin + SLACK:
                drive = Twist(sent[command, robot, 0], sent[command, robot, 1])
                command += 1
            grid += begin == due
            push = 0.0, 0.0
            if plant.push_v > 0.0 or plant.push_omega > 0.0:
                push = wave(tones[robot, 0], begin), wave(tones[robot, 1], begin)
            leg = _next_leg(leg, begin, plant, drive, push)
        vehicles[robot] = Vehicle(plant, leg, drive, grid, command, picture)


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
