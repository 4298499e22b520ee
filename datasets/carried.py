"""A robot that someone carries along a way: it obeys nobody, and its motion is known exactly."""

from dataclasses import dataclass

import numpy as np

from control.plan import PlannedPath
from control.time_law import TimeLaw, ramps
from control.unicycle import UnicycleState

_MOST_OF_IT = 0.45  # of the time that speeding up may take, and slowing down again


@dataclass(frozen=True, slots=True)
class CarriedWay:
    """From a standstill to a standstill along a path.

    Attributes:
        path: the arcs and lines, driven at 1 m/s: its time is the way along it [m].
        speed: greatest [m/s].
        law: how far it has come; the way is its S times the speed.
        begins: when the carrying begins [s].
    """

    path: PlannedPath
    speed: float
    law: TimeLaw
    begins: float

    def at(self, t: float) -> UnicycleState:
        """Where it is at a time.

        Args:
            t: of the world [s].

        Returns:
            Its state; the heading is not wrapped.
        """
        passed, pace, _ = self.law.at(np.array([t - self.begins]))[:, 0].tolist()
        place, v = self.path.at(self.speed * passed).state, self.speed * pace
        return UnicycleState(place.x, place.y, place.theta, v, v * place.omega)


def carried_way(path: PlannedPath, speed: float, ramp: float, begins: float) -> CarriedWay:
    """A way with smooth ramps.

    Args:
        path: the arcs and lines, at 1 m/s.
        speed: greatest, > 0 [m/s].
        ramp: how long speeding up and slowing down take, > 0; shorter where the way is [s].
        begins: when [s].

    Returns:
        The way.
    """
    cruise = sum(segment.length for segment in path.segments) / speed
    ramp = min(ramp, _MOST_OF_IT * cruise)
    return CarriedWay(path, speed, ramps(cruise + ramp, ramp, 0.0, 0.0, 0.0), begins)
