"""What really happened in a mission, as arrays that can be asked."""

from math import inf

import numpy as np
from numpy.typing import NDArray

from benchmarks.faults.drive import Driven
from benchmarks.faults.promises import STILL
from benchmarks.faults.script import Kind
from control.command import RobotId
from control.unicycle import Twist
from datasets.bodies import pair_gaps, pair_indices
from datasets.scores import SETTLED_BEARING, SETTLED_DISTANCE, Motions, follower_errors

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

EVERY = 2  # of the looks at the world, errors are taken
STOP = Twist(0.0, 0.0)


class Evidence:
    """The true world of one mission.

    Attributes:
        times: of the looks at the world, shape (T,) [s].
        states: of the robots then, shape (T, R, 5).
        gaps: least distance of two bodies on the floor then, shape (T,) [m].
        base: every second of them, S in all, with the mission's clock.
        small: whether every follower is in its place then, shape (S,).
        errors: worst distance error of a follower then, shape (S,) [m].
    """

    def __init__(self, driven: Driven, timeout: float) -> None:
        """Put it in order.

        Args:
            driven: the mission.
            timeout: without a command for so long a robot stops itself [s].
        """
        self._driven, self._timeout, self._setup = driven, timeout, driven.made.setup
        self._ids = tuple(robot.id for robot in driven.made.scenario.robots)
        self.times = np.array(driven.watched.times)
        self.states = np.array(driven.watched.states)
        self.gaps = self._clearances(self._setup.tags.tags[0].side)
        self.base = self._motions()
        self.small, self.errors = self._in_place()
        self._told: dict[RobotId, list[tuple[float, Twist]]] = {robot: [] for robot in self._ids}
        for sent, robot, twist in sorted(driven.watched.told, key=lambda told: told[0]):
            self._told[robot].append((sent + self._setup.radio_delay, twist))

    def driven_until(self, robot: RobotId, begin: float, until: float) -> float:
        """Until when a robot's wheels were driven, by what reached them.

        Args:
            robot: the robot.
            begin: of the time in question [s].
            until: its end [s].

        Returns:
            The last such moment; the begin if there was none [s].
        """
        told, last = self._told[robot], begin
        for (t, twist), (following, _) in zip(told, [*told[1:], (inf, STOP)], strict=True):
            end = min(following, t + self._timeout)
            if twist != STOP and end > begin and t < until:
                last = max(last, end)
        return last

    def moves_until(self, robot: RobotId, begin: float, until: float) -> float:
        """Until when a robot moved.

        Args:
            robot: the robot.
            begin: of the time in question [s].
            until: its end [s].

        Returns:
            The last such moment; the begin if there was none [s].
        """
        inside = (self.times >= begin) & (self.times < until - 1e-9)
        moves = self.faster(robot, STILL) & inside
        return float(self.times[moves][-1]) if moves.any() else begin

    def faster(self, robot: RobotId, than: tuple[float, float]) -> Flags:
        """When a robot was faster than something.

        Args:
            robot: the robot.
            than: forward and angular speed, one of them is enough [m/s, rad/s].

        Returns:
            Shape (T,).
        """
        v, omega = self.states[:, self._ids.index(robot), 3:].T
        found: Flags = (np.abs(v) > than[0]) | (np.abs(omega) > than[1])
        return found

    def least_gap(self, begin: float, end: float) -> float:
        """Least distance of two bodies between two moments.

        Args:
            begin: the first [s].
            end: the last [s].

        Returns:
            The distance, infinite if nobody looked [m].
        """
        inside = (self.times >= begin) & (self.times <= end)
        return float(self.gaps[inside].min(initial=inf))

    def _taken(self) -> Flags:
        """Which robots are not on the floor, shape (T, R)."""
        away = np.zeros(self.states.shape[:2], bool)
        for fault in self._driven.script.faults:
            if fault.kind is Kind.TAKEN and fault.robot is not None:
                on = (self.times >= fault.begin) & (self.times < fault.end)
                away[on, self._ids.index(fault.robot)] = True
        return away

    def _clearances(self, side: float) -> Floats:
        """Least distance of two bodies on the floor, shape (T,) [m]."""
        count = len(self._ids)
        first, second = pair_indices(count)
        gaps = pair_gaps(self.states[:, :, :3], np.full(count, side))
        away = self._taken()
        gaps[away[:, first] | away[:, second]] = inf
        least: Floats = gaps.min(axis=1, initial=inf)
        return least

    def _motions(self) -> Motions:
        """What the robots did, with the mission's clock."""
        times, diary = self.times[::EVERY], self._driven.diary
        before = np.searchsorted(diary.times, times, side="right") - 1
        mission = times - np.array(diary.starts)[np.maximum(before, 0)]
        return Motions(self._ids, times, mission, self.states[::EVERY])

    def _in_place(self) -> tuple[Flags, Floats]:
        """Whether every follower is in its place, and the worst distance error, (T,) [m]."""
        offset, pairs = self._setup.follower.camera_offset, self._setup.formation.pairs
        errors = np.abs([follower_errors(self.base, pair, offset) for pair in pairs])
        small = (errors[..., 0] < SETTLED_DISTANCE) & ~(errors[..., 1] >= SETTLED_BEARING)
        return np.asarray(small.all(axis=0)), np.asarray(errors[..., 0].max(axis=0))
