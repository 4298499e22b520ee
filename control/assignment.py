"""Which robot takes which place: the shortest ways, on which no two robots meet.

Robots stand at p_i, their places are q_i. The assignment makes the sum of |p_i - q_i|^2 least.
Were the places of two robots exchanged, the sum would grow by 2 (p_i - p_j).(q_i - q_j), which is
therefore >= 0. Driven straight and in the same time, with the share s of the way behind them, the
two are (1 - s)(p_i - p_j) + s (q_i - q_j) apart, of squared length

    (1 - s)^2 |p_i - p_j|^2 + s^2 |q_i - q_j|^2 + 2 s (1 - s) (p_i - p_j).(q_i - q_j)

and without the last term this is at least A B / (A + B), A = |p_i - p_j|^2, B = |q_i - q_j|^2:
they never meet, and of the least gap at start or end 1/sqrt(2) remains. Source: M. Turpin,
N. Michael, V. Kumar, "CAPT: Concurrent assignment and planning of trajectories for multiple
robots", Int. J. Robotics Research, 2014. Two ways may still lead over the same spot of the
floor; the robots are there at different times. This is a law of straight ways: where errors of
distance and bearing fade as in (23), real ones bend about the leader.
"""

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np
import scipy
from numpy.typing import NDArray

from control.actuation import require_finite
from control.command import RobotId
from control.errors import ControlError
from control.geometry import Pose2D
from control.relative import Vector2, relative_state
from control.shapes import Places, place_of

_TIE = 1e-9  # sums of squares that differ by less are equal [m^2]
_NOBODY: Mapping[RobotId, int] = MappingProxyType({})


def positions_about(
    leader: Pose2D, followers: Mapping[RobotId, Pose2D], camera_offset: float
) -> dict[RobotId, Vector2]:
    """Where followers are, as places are given.

    Args:
        leader: pose of the formation's leader on the floor [m, m, rad].
        followers: poses on the floor [m, m, rad].
        camera_offset: from a follower's axle forward to its camera point, d [m].

    Returns:
        Their camera points in the leader's frame [m, m].
    """
    seen = {k: relative_state(leader, pose, camera_offset) for k, pose in followers.items()}
    return {k: place_of((state.distance, state.bearing)) for k, state in seen.items()}


def assigned(
    positions: Mapping[RobotId, Vector2],
    places: Places,
    bound: Mapping[RobotId, int] = _NOBODY,
) -> tuple[RobotId, ...]:
    """The robot of each place, with the least sum of squared ways.

    Of several best assignments the one is taken in which the first robot has the first place it
    can have, then the second, and so on; numbers come before names. The order in which the robots
    are given does not matter.

    Args:
        positions: camera points of the free robots in the leader's frame; those of bound robots
            are not used [m, m].
        places: (N, 2) [m, m].
        bound: index of the place of each robot that has one already.

    Returns:
        (N,) robots in the order of the places.

    Raises:
        ControlError: if there are not as many robots as places, a bound place does not exist or
            is taken twice, or a number is not finite.
    """
    free = sorted(positions.keys() - bound.keys(), key=lambda k: (isinstance(k, str), k))
    taken = {place: robot for robot, place in bound.items()}
    _require_room(len(free), bound, len(places))
    open_places = [k for k in range(len(places)) if k not in taken]
    starts = [positions[robot] for robot in free]
    require_finite("positions and places", *(x for point in (*starts, *places) for x in point))
    chosen = _first_best(_squares(starts, [places[k] for k in open_places]))
    taken |= {open_places[j]: robot for robot, j in zip(free, chosen, strict=True)}
    return tuple(taken[k] for k in range(len(places)))


def rearranged(before: Places, after: Places) -> Places:
    """The places of a next shape, each at the index of the robot that drives to it.

    Args:
        before: (N, 2) places that the robots have [m, m].
        after: (N, 2) places of the next shape, in any order [m, m].

    Returns:
        (N, 2) the places of ``after``, the k-th for the robot at the k-th of ``before``.

    Raises:
        ControlError: if there are not as many places after as before.
    """
    robots = assigned(dict(enumerate(before)), after)
    return tuple(after[robots.index(k)] for k in range(len(before)))


def crossings(starts: Sequence[Vector2], ends: Sequence[Vector2]) -> int:
    """How many pairs of robots pass each other on straight ways driven in the same time.

    Two robots pass each other if the direction from one to the other turns by more than a
    quarter turn: (p_i - p_j).(q_i - q_j) < 0. All pairs that meet do.

    Args:
        starts: (N, 2) where they start [m, m].
        ends: (N, 2) where they end [m, m].

    Returns:
        The number of such pairs.

    Raises:
        ControlError: if there are not as many ends as starts.
    """
    if len(starts) != len(ends):
        raise ControlError(f"ways need as many ends as starts, got {len(ends)} and {len(starts)}")
    p, q = np.reshape(starts, (-1, 2)), np.reshape(ends, (-1, 2))
    products = np.einsum("ijc,ijc->ij", p[:, None] - p, q[:, None] - q)
    return int(np.count_nonzero(np.triu(products < -_TIE)))


def _require_room(free: int, bound: Mapping[RobotId, int], places: int) -> None:
    taken = list(bound.values())
    wrong = [k for k in taken if not 0 <= k < places]
    if wrong:
        raise ControlError(f"robots are bound to places {wrong}, there are 0 to {places - 1}")
    twice = sorted({k for k in taken if taken.count(k) > 1})
    if twice:
        raise ControlError(f"places bound to more than one robot: {twice}")
    if free + len(bound) != places:
        raise ControlError(
            f"{places} places for {free + len(bound)} followers, {len(bound)} of them bound: "
            "give as many places as followers"
        )


def _squares(starts: Sequence[Vector2], ends: Sequence[Vector2]) -> NDArray[np.float64]:
    """Squared distances, one row per start [m^2]."""
    p, q = np.reshape(starts, (-1, 2)), np.reshape(ends, (-1, 2))
    squares: NDArray[np.float64] = np.square(p[:, None] - q).sum(axis=2)
    return squares


def _first_best(costs: NDArray[np.float64]) -> list[int]:
    """Columns of the rows with the least sum; of equal ones the first in lexical order."""
    columns = scipy.optimize.linear_sum_assignment(costs)[1]
    least = costs[np.arange(len(costs)), columns].sum()
    best: list[int] = columns.tolist()
    spent = 0.0
    for i in range(len(best)):
        for j in sorted(k for k in best[i + 1 :] if k < best[i]):
            others = [k for k in best[i:] if k != j]
            rest = costs[i + 1 :, others]
            order = scipy.optimize.linear_sum_assignment(rest)[1]
            if spent + costs[i, j] + rest[range(len(order)), order].sum() <= least + _TIE:
                best[i:] = [j, *(others[k] for k in order)]
                break
        spent += costs[i, best[i]]
    return best
