"""The world outside of the program: it is watched all the time, and people lay hands on it."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from math import cos, pi, sin

import numpy as np
from numpy.typing import NDArray

from benchmarks.faults.script import OF_ROBOTS, UNHEARD, Kind, Script
from control.command import RobotId
from control.geometry import Pose2D
from control.unicycle import Twist, UnicycleState, advance_pose
from datasets.bodies import square_gaps
from datasets.cycle import RobotState
from datasets.world import RobotPlant, World

Floats = NDArray[np.float64]

STEP = 0.01  # between two looks at the world [s]
NEAR, TURN = 0.10, 0.5  # a robot is put down so far from where it was, at most [m, rad]
FREE = 0.12  # from other bodies, and from where they will be soon [m]
SOON = (0.0, 0.2, 0.4, 0.6)  # [s]
TRIES = 500


@dataclass(slots=True)
class Watched:
    """What really happened.

    Attributes:
        times: when the world was looked at [s].
        states: x, y, theta, v, omega of every robot then.
        told: what reached the wheels: when it was sent [s], whose, what.
    """

    times: list[float] = field(default_factory=list)
    states: list[list[tuple[float, ...]]] = field(default_factory=list)
    told: list[tuple[float, RobotId, Twist]] = field(default_factory=list)


class Outside(World):
    """Robots that are watched, taken away and put back; radio waves that do not reach them."""

    def __init__(
        self,
        plants: tuple[RobotPlant, ...],
        script: Script,
        room: tuple[Pose2D, Pose2D],
        delay: float,
        seed: int,
    ) -> None:
        """Put the robots on the floor.

        Args:
            plants: the robots.
            script: what goes wrong.
            room: two opposite corners of where robots may be put down [m].
            delay: of the radio [s].
            seed: of disturbances, and of where robots are put down.
        """
        super().__init__(plants, seed)
        self.watched = Watched()
        self._script, self._room, self._delay = script, room, delay
        self._rng = np.random.default_rng((seed, 7))
        self._away = [
            (fault.end, fault.robot)
            for fault in script.faults
            if fault.kind is Kind.TAKEN and fault.robot is not None
        ]

    def advance(self, t: float) -> None:
        """Let time pass, and look at the world meanwhile.

        Args:
            t: new time of the world [s].
        """
        while (due := len(self.watched.times) * STEP) <= t:
            super().advance(due)
            if self._away and self._away[0][0] <= due:
                self._put_down(self._away.pop(0)[1])
            self.watched.times.append(due)
            self.watched.states.append([_numbers(robot) for robot in super().states(due)])
        super().advance(t)

    def states(self, t: float) -> tuple[RobotState, ...]:
        """Where the robots were that can be seen: those that nobody covers or has in the hand.

        Args:
            t: at most the world's time and at most `MEMORY` before it [s].

        Returns:
            True states at t.
        """
        seen = super().states(t)
        return tuple(r for r in seen if self._script.on(OF_ROBOTS, t, r.robot_id) is None)

    def command(self, robot_id: RobotId, twist: Twist, t_arrival: float) -> None:
        """Let a command reach a robot, if its link is up and it listens.

        Args:
            robot_id: who is to obey.
            twist: commanded velocities [m/s, rad/s].
            t_arrival: when it reaches the wheels [s].
        """
        sent = t_arrival - self._delay
        if self._script.on(UNHEARD, sent, robot_id) is None:
            self.watched.told.append((sent, robot_id, twist))
            super().command(robot_id, twist, t_arrival)

    def _put_down(self, robot_id: RobotId) -> None:
        """Somebody who minds the others puts the robot down near where it was."""
        robots = {r.robot_id: r.state for r in super().states(self.t)}
        own = robots.pop(robot_id)
        for _ in range(TRIES):
            away, way, turn = self._rng.uniform((0.0, -pi, -TURN), (NEAR, pi, TURN)).tolist()
            place = Pose2D(own.x + away * cos(way), own.y + away * sin(way), own.theta + turn)
            if self._is_free(place, robots.values()):
                return self.place(robot_id, place)
        raise RuntimeError(f"no free place for robot {robot_id} at {self.t:.2f} s")

    def _is_free(self, place: Pose2D, others: Iterable[UnicycleState]) -> bool:
        low, high = self._room
        if not (low.x < place.x < high.x and low.y < place.y < high.y):
            return False
        side = self.plants[0].side
        coming = [advance_pose(other.pose, other.twist, dt) for other in others for dt in SOON]
        there = np.array([(pose.x, pose.y, pose.theta) for pose in coming])
        here = np.broadcast_to((place.x, place.y, place.theta), there.shape)
        return bool((square_gaps(here, there, np.array((side, side))) > FREE).all())


def _numbers(robot: RobotState) -> tuple[float, ...]:
    s = robot.state
    return s.x, s.y, s.theta, s.v, s.omega
