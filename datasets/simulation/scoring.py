"""`datasets/scores.py` as machine code, for batches of runs."""

from math import cos, hypot, inf, nan, sin, sqrt

import numpy as np

from control.compilable import compilable
from control.geometry import Pose2D, wrap_angle
from control.relative import relative_state
from datasets.scores import LAST_SHARE, SETTLED_BEARING, SETTLED_DISTANCE
from datasets.simulation.inputs import Chance, Figures, Floats, Goals, Integers, Trace
from vision.compiled import compiled


@compiled
def score_batch(goals: Goals, chance: Chance, trace: Trace, figures: Figures) -> None:
    """Score N runs.

    Args:
        goals: what they are judged by.
        chance: says when the missions began and the runs ended.
        trace: what the runs were.
        figures: filled.
    """
    for run in range(len(chance.ticks)):
        _score(goals, chance, trace, figures, run)


@compilable
def _score(goals: Goals, chance: Chance, trace: Trace, figures: Figures, run: int) -> None:
    count = chance.ticks[run, 2]
    states, mission = trace.states[run, :count], chance.mission[run, :count]
    for robot in range(1, states.shape[1]):
        _follower(goals, states, mission, robot, figures.followers[run, robot])
    figures.leader[run] = _leader(goals, states, mission)
    figures.clearance[run] = _clearance(states, goals.side)


@compilable
def _follower(goals: Goals, states: Floats, mission: Integers, robot: int, figures: Floats) -> None:
    """Fill in the seven figures of a follower."""
    end = (len(mission) - 1) * goals.period
    late = end - LAST_SHARE * end
    squares, most, count = np.zeros(2), np.full(2, nan), 0
    speeds = np.zeros(2)
    for tick in range(len(mission)):
        if mission[tick] < 0:
            continue
        for index in range(2):
            speeds[index] = max(speeds[index], abs(states[tick, robot, 3 + index]))
        if tick * goals.period >= late:
            error = _error(goals, states[tick], mission[tick], robot)
            count += 1
            for index in range(2):
                squares[index] += error[index] ** 2
                most[index] = np.fmax(most[index], error[index])
    for index in range(2):
        figures[2 * index] = sqrt(squares[index] / count) if count > 0 else nan
        figures[2 * index + 1] = most[index]
        figures[5 + index] = speeds[index] if mission[-1] >= 0 else nan
    figures[4] = _settled_at(goals, states, mission, robot)


@compilable
def _settled_at(goals: Goals, states: Floats, mission: Integers, robot: int) -> float:
    """Since when a follower's errors have been small, looking back from the shape's change."""
    settled = nan
    for tick in range(len(mission) - 1, -1, -1):
        t = mission[tick] * goals.period
        if mission[tick] >= 0 and t < goals.settles_by[robot]:
            error = _error(goals, states[tick], mission[tick], robot)
            if error[0] >= SETTLED_DISTANCE or error[1] >= SETTLED_BEARING:
                break
            settled = t
    return settled


@compilable
def _error(goals: Goals, states: Floats, mission: int, robot: int) -> tuple[float, float]:
    """Magnitudes of a follower's errors: of the worse distance, and of the bearing if wanted."""
    own, distance, bearing = _pose(states[robot]), 0.0, nan
    for which in range(2):
        leader = goals.leaders[robot, which]
        if leader >= 0:
            seen = relative_state(_pose(states[leader]), own, goals.camera_offset)
            wanted = goals.wanted[mission, robot, which]
            distance = max(distance, abs(wanted[0] - seen.distance))
            bearing = abs(wrap_angle(wanted[1] - seen.bearing))
    return distance, bearing


@compilable
def _pose(state: Floats) -> Pose2D:
    return Pose2D(state[0], state[1], state[2])


@compilable
def _leader(goals: Goals, states: Floats, mission: Integers) -> float:
    """rms of the leader's distance to its plan."""
    total, count = 0.0, 0
    for tick in range(len(mission)):
        if mission[tick] >= 0:
            x, y = goals.planned[mission[tick]]
            total += (states[tick, 0, 0] - x) ** 2 + (states[tick, 0, 1] - y) ** 2
            count += 1
    return sqrt(total / count) if count > 0 else nan


@compilable
def _clearance(states: Floats, side: float) -> float:
    """Least distance between two bodies; most pairs are too far apart to matter."""
    least, count, diagonal = inf, states.shape[1], sqrt(2.0) * side
    for tick in range(len(states)):
        for one in range(count):
            for other in range(one + 1, count):
                a, b = states[tick, one], states[tick, other]
                if (b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2 < (least + diagonal) ** 2:
                    least = min(least, _gap(a, b, side))
    return least


@compilable
def _gap(a: Floats, b: Floats, side: float) -> float:
    """`bodies.square_gaps` of two bodies of the same side."""
    gap, reach = _seen_from(a, b, side)
    other_gap, other_reach = _seen_from(b, a, side)
    separation = max(gap, other_gap)
    return min(reach, other_reach) if separation > 0.0 else separation


@compilable
def _seen_from(frame: Floats, body: Floats, side: float) -> tuple[float, float]:
    """Largest gap along the axes of a body's box, and the other's corners' least distance to it."""
    half, turn = 0.5 * side, body[2] - frame[2]
    c, s = half * cos(turn), half * sin(turn)
    cf, sf = cos(frame[2]), sin(frame[2])
    dx, dy = body[0] - frame[0], body[1] - frame[1]
    x, y = cf * dx + sf * dy, cf * dy - sf * dx
    spread, reach = abs(c) + abs(s), inf
    for u, v in ((1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)):
        px, py = abs(x + u * c - v * s) - half, abs(y + u * s + v * c) - half
        reach = min(reach, hypot(max(px, 0.0), max(py, 0.0)))
    gap = max(abs(x), abs(y)) - spread - half
    return gap, reach
