"""Simulated robots under model (3): unicycles whose motors follow commands with a lag.

    v' = ((1 + eps) c_v - v) / lag + pi_v,   omega' = ((1 + eps') c_omega - omega) / lag + pi_omega

Velocities and headings are exact; positions are integrated by Gauss's two-point rule over at most
`GRID` seconds, which errs by less than 1e-9 m a second. Steps end on a fixed grid and at the
arrivals of commands, so the motion does not depend on how often the world is advanced.
"""

from bisect import insort
from collections import deque
from dataclasses import dataclass
from math import inf, isfinite

import numpy as np

from control.command import RobotId
from control.geometry import Pose2D
from control.unicycle import SpeedLimits, Twist, UnicycleState
from datasets.bodies import pair_gaps
from datasets.carried import CarriedWay
from datasets.cycle import RobotState
from datasets.errors import SimulationError
from datasets.plant import GRID, SLACK, Motion, draw_tones, motion_after, wave

MEMORY = 1.0  # how far back `states` reaches [s]


@dataclass(frozen=True, slots=True)
class Disturbance:
    """Bounds of the disturbance pi_i of (3), a seeded sum of slow sinusoids (0.2 to 3 Hz).

    Attributes:
        v: greatest disturbance of the forward acceleration, >= 0 [m/s^2].
        omega: greatest disturbance of the angular acceleration, >= 0 [rad/s^2].
    """

    v: float = 0.0
    omega: float = 0.0


_FAST = SpeedLimits(1.5, 15.0)
_CALM = Disturbance()
_STANDSTILL = Twist(0.0, 0.0)


@dataclass(frozen=True, slots=True)
class RobotPlant:
    """A robot as it really is, model (3).

    Attributes:
        robot_id: whose plant it is.
        start: state at t = 0; its velocities last until the first command arrives.
        lag: time constant of the motors, >= 0 [s].
        mass_error: eps, relative error of the forward velocity's gain.
        inertia_error: eps', relative error of the angular velocity's gain.
        side: of the square body, > 0 [m].
        track_width: between the wheels, for those who send wheel speeds [m].
        limits: what the wheels can do; commands are clipped to it.
        disturbance: bounds of pi_i.
        carried: the way along which someone carries it, whatever it is told; None: nobody does.
        timeout: without a command for so long it stops itself, > 0; infinite: it drives on [s].

    Raises:
        SimulationError: if the lag is negative, the side or the timeout is not positive or a number
            not finite.
    """

    robot_id: RobotId
    start: UnicycleState
    lag: float = 0.05
    mass_error: float = 0.0
    inertia_error: float = 0.0
    side: float = 0.075
    track_width: float = 0.068
    limits: SpeedLimits = _FAST
    disturbance: Disturbance = _CALM
    carried: CarriedWay | None = None
    timeout: float = inf

    def __post_init__(self) -> None:
        s = self.start
        numbers = (s.x, s.y, s.theta, s.v, s.omega, self.mass_error, self.inertia_error)
        sizes = 0.0 <= self.lag < 1e3 and self.side > 0.0 and self.timeout > 0.0
        if not (all(map(isfinite, numbers)) and sizes):
            raise SimulationError(
                f"robot {self.robot_id}: start {s}, lag {self.lag} s, side {self.side} m, "
                f"errors {self.mass_error}, {self.inertia_error}, timeout {self.timeout} s"
            )


class World:
    """The robots of a field, all on one clock that begins at 0."""

    def __init__(self, plants: tuple[RobotPlant, ...], seed: int = 0) -> None:
        """Put the robots on the floor.

        Args:
            plants: at least one, no id twice.
            seed: of the disturbances, >= 0.

        Raises:
            SimulationError: if there is no plant or an id comes twice.
        """
        ids = [plant.robot_id for plant in plants]
        if not ids or len(set(ids)) != len(ids):
            raise SimulationError(f"a world needs robots, no id twice, got {ids}")
        self._robots = {
            plant.robot_id: _Robot(plant, np.random.default_rng((seed, index)))
            for index, plant in enumerate(plants)
        }
        self._sides = np.array([plant.side for plant in plants])
        self._now = 0.0

    @property
    def t(self) -> float:
        """Present time of the world [s]."""
        return self._now

    @property
    def plants(self) -> tuple[RobotPlant, ...]:
        """The robots as they really are."""
        return tuple(robot.plant for robot in self._robots.values())

    def command(self, robot_id: RobotId, twist: Twist, t_arrival: float) -> None:
        """Let a command reach a robot; it holds until the next one, or the robot's own timeout.

        Args:
            robot_id: who is to obey.
            twist: commanded velocities; clipped to the plant's limits [m/s, rad/s].
            t_arrival: when it reaches the wheels; not before the world's time [s].

        Raises:
            SimulationError: if nobody has that id or a number is not finite.
        """
        robot = self._robot(robot_id)
        if not (isfinite(twist.v) and isfinite(twist.omega) and isfinite(t_arrival)):
            raise SimulationError(f"robot {robot_id}: command {twist} at {t_arrival} s")
        robot.take(twist, max(t_arrival, self._now))

    def place(self, robot_id: RobotId, pose: Pose2D) -> None:
        """Let somebody put a robot down somewhere else, at rest, now.

        Args:
            robot_id: who is moved; it still obeys the last command.
            pose: where it stands then [m, m, rad].

        Raises:
            SimulationError: if nobody has that id, or it is carried along a way.
        """
        robot = self._robot(robot_id)
        if robot.plant.carried:
            raise SimulationError(f"robot {robot_id} is carried along a way of its own")
        robot.place(self._now, pose)

    def advance(self, t: float) -> None:
        """Let time pass.

        Args:
            t: new time of the world; earlier times change nothing [s].
        """
        self._now = max(self._now, t)
        for robot in self._robots.values():
            robot.advance(self._now)

    def states(self, t: float) -> tuple[RobotState, ...]:
        """Where the robots were a moment ago.

        Args:
            t: at most the world's time and at most `MEMORY` before it [s].

        Returns:
            True states at t, in the order of the plants; headings are not wrapped.

        Raises:
            SimulationError: if the world does not know the states at t.
        """
        if not max(0.0, self._now - MEMORY) - SLACK <= t <= self._now + SLACK:
            raise SimulationError(f"asked for the states at {t} s, the world is at {self._now} s")
        return tuple(
            RobotState(robot_id, UnicycleState(*robot.at(t)))
            for robot_id, robot in self._robots.items()
        )

    def truth(self) -> tuple[RobotState, ...]:
        """Where the robots are now.

        Returns:
            True states at the world's time, in the order of the plants.
        """
        return self.states(self._now)

    def clearance(self) -> float:
        """Least distance between two bodies now.

        Returns:
            The distance; negative if bodies overlap, infinite with one robot [m].
        """
        return float(self._gaps().min(initial=np.inf))

    def _robot(self, robot_id: RobotId) -> "_Robot":
        if robot_id not in self._robots:
            raise SimulationError(f"no robot {robot_id} among {list(self._robots)}")
        return self._robots[robot_id]

    def _gaps(self) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        """Distances of all pairs of bodies now."""
        poses = np.array([robot.at(self._now)[:3] for robot in self._robots.values()])
        return pair_gaps(poses, self._sides)


@dataclass(slots=True)  # thousands are made: a frozen one costs twice as much
class _Leg:
    """A step with constant drive: where it began, and the velocities it tends to."""

    t: float
    motion: Motion
    goal_v: float
    goal_omega: float
    lag: float

    def at(self, t: float) -> Motion:
        """Motion at t >= self.t."""
        return motion_after(self.motion, self.goal_v, self.goal_omega, self.lag, t - self.t)


class _Robot:
    """One moving robot: its legs so far, and the commands on their way."""

    def __init__(self, plant: RobotPlant, rng: np.random.Generator) -> None:
        self.plant = plant
        self._drive: Twist | None = None
        self._expiry = inf  # when it stops itself
        self._pending: list[tuple[float, int, Twist]] = []
        self._taken = 0
        self._grid = 1  # number of the next grid point
        self._tones = draw_tones(rng)
        s = plant.start
        self._legs: deque[_Leg] = deque()
        self._begin_leg(0.0, (s.x, s.y, s.theta, s.v, s.omega))

    def take(self, twist: Twist, t_arrival: float) -> None:
        """Keep a command until its arrival; of two with the same arrival the later one counts."""
        insort(self._pending, (t_arrival, self._taken, self.plant.limits.saturate(twist)))
        self._taken += 1

    def advance(self, t: float) -> None:
        """Make all legs that begin by t."""
        while True:
            due = self._grid * GRID
            arrival = self._pending[0][0] if self._pending else inf
            event = min(arrival, self._expiry)
            begin = due if abs(event - due) < SLACK else min(event, due)
            if begin > t:
                break
            if arrival < begin + SLACK:
                self._obey(self._pending.pop(0)[2], arrival)
            elif self._expiry < begin + SLACK:
                self._drive, self._expiry = _STANDSTILL, inf
            if begin == due:
                self._grid += 1
            self._begin_leg(begin, self._legs[-1].at(begin))
        while len(self._legs) > 2 and self._legs[1].t < t - MEMORY - GRID:
            self._legs.popleft()

    def at(self, t: float) -> Motion:
        """Motion at a time the memory reaches."""
        if self.plant.carried:
            s = self.plant.carried.at(t)
            return s.x, s.y, s.theta, s.v, s.omega
        leg = next((leg for leg in reversed(self._legs) if leg.t <= t), self._legs[0])
        return leg.at(t)

    def place(self, t: float, pose: Pose2D) -> None:
        """Begin anew, at rest, where somebody has put it."""
        self._begin_leg(t, (pose.x, pose.y, pose.theta, 0.0, 0.0))

    def _obey(self, twist: Twist, arrival: float) -> None:
        """Drive as told; the watch over silence begins again."""
        moves = twist != _STANDSTILL
        self._drive, self._expiry = twist, arrival + self.plant.timeout if moves else inf

    def _begin_leg(self, t: float, motion: Motion) -> None:
        """Start a step under the present drive and disturbance."""
        plant, drive = self.plant, self._drive
        if drive is None:  # not commanded yet: the motors keep what they do
            self._legs.append(_Leg(t, motion, plant.start.v, plant.start.omega, plant.lag))
            return
        push_v, push_omega = self._disturbance(t)
        goal_v = (1.0 + plant.mass_error) * drive.v + plant.lag * push_v
        goal_omega = (1.0 + plant.inertia_error) * drive.omega + plant.lag * push_omega
        self._legs.append(_Leg(t, motion, goal_v, goal_omega, plant.lag))

    def _disturbance(self, t: float) -> tuple[float, float]:
        """pi_i at a time, bounded by construction."""
        bound = self.plant.disturbance
        if not (bound.v or bound.omega):
            return 0.0, 0.0
        return bound.v * wave(self._tones[0], t), bound.omega * wave(self._tones[1], t)
