"""What a batch of runs is made of: constants, tables, and all that chance decides."""

from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from control.compilable import compilable
from control.follower import FollowerModel, SlidingGains
from control.leader import LeaderGains
from control.motion_model import MotionModel
from control.safety import Arena, Clearance
from control.value import value

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

MOST_GAINS = 8
"""So many followers' laws or gains may differ from each other in a run."""

Gains: TypeAlias = tuple[
    SlidingGains, SlidingGains, SlidingGains, SlidingGains,
    SlidingGains, SlidingGains, SlidingGains, SlidingGains,
]  # fmt: skip


@value
@dataclass(frozen=True, slots=True)
class Host:
    """What the host knows and wants, the same in all runs of a batch.

    Attributes:
        period: between two ticks [s].
        delay: from sending a command to its effect [s].
        follower: geometry and motors.
        leader: gains of the leader's law.
        motion: model of a robot that obeys the commands sent.
        free_motion: model of a robot nobody has commanded yet.
        clearance: how far bodies are kept apart.
        arena: what no body may leave.
    """

    period: float
    delay: float
    follower: FollowerModel
    leader: LeaderGains
    motion: MotionModel
    free_motion: MotionModel
    clearance: Clearance
    arena: Arena


class Field(NamedTuple):
    """Robots and references, the same in all runs of a batch; robot 0 is the formation's leader.

    Attributes:
        starts: (R, 5) x, y, theta, v, omega at t = 0.
        plants: (R, 7) motor lag, errors of mass and inertia, greatest speeds v and omega, bounds
            of the disturbances of v and omega.
        leaders: (R, 2) whom a robot follows, lower numbers than its own; -1 for none.
        gains: (R,) which of `Host.gains` is a robot's.
        told: (R,) whether a robot is told what acceleration its leader is commanded.
        freedoms: (R,) how easily a robot gives way to others; 0: bodies are not kept apart.
        planned: (M, 7) wanted x, y, theta, v, omega, v', omega' of the leader, by the tick of the
            mission, at the moment when that tick's commands take effect.
        wanted: (M, R, 6) h^d of every follower with two derivatives, likewise.
        pose_noise: (2, 3, 3) covariance the host gives a first pose, and all others.
    """

    starts: Floats
    plants: Floats
    leaders: Integers
    gains: Integers
    told: NDArray[np.bool_]
    freedoms: Floats
    planned: Floats
    wanted: Floats
    pose_noise: Floats


class Chance(NamedTuple):
    """What happens to N runs, or to one, without the first axis; robots cannot change it.

    Attributes:
        ticks: (N, 3) first tick with commands, the one after the last, number of all ticks.
        mission: (N, T) tick of the mission's clock; -1 before the start.
        share: (N, T) of its speed that every robot may drive.
        frame: (N, T) number of the frame that is handed out at a tick, -1 for none.
        taken: (N, F) when each frame's picture was taken, ascending [s].
        stamp: (N, F) when the frame says it was taken [s].
        noise: (N, F, R, 3) errors of the measured poses [m, m, rad].
        lost: (N, T, R) commands of a tick that never arrive.
        tones: (N, R, 2, TONES, 2) of the disturbances.
        rates: (N, R, 2) h'(0) where the start has measured it.
    """

    ticks: Integers
    mission: Integers
    share: Floats
    frame: Integers
    taken: Floats
    stamp: Floats
    noise: Floats
    lost: NDArray[np.bool_]
    tones: Floats
    rates: Floats


class Trace(NamedTuple):
    """What N runs were, or one, tick by tick; rows behind a run's last tick mean nothing.

    Attributes:
        states: (N, T, R, 5) true x, y, theta, v, omega.
        ahead: (N, T, R, 5) believed, for the moment when the tick's commands take effect.
        commands: (N, T, R, 2) v and omega that were sent.
        kept: (N, T, R) who was kept off others.
    """

    states: Floats
    ahead: Floats
    commands: Floats
    kept: NDArray[np.bool_]


@compilable
def chance_of(chance: Chance, run: int) -> Chance:
    """What happens to one run.

    Args:
        chance: of all runs.
        run: number of the run.

    Returns:
        Its part of the tables.
    """
    return Chance(
        chance.ticks[run], chance.mission[run], chance.share[run], chance.frame[run],
        chance.taken[run], chance.stamp[run], chance.noise[run], chance.lost[run],
        chance.tones[run], chance.rates[run],
    )  # fmt: skip


@compilable
def trace_of(trace: Trace, run: int) -> Trace:
    """What one run is.

    Args:
        trace: of all runs.
        run: number of the run.

    Returns:
        Its part of the tables, to be filled.
    """
    return Trace(trace.states[run], trace.ahead[run], trace.commands[run], trace.kept[run])


class Goals(NamedTuple):
    """What runs are judged by, the same in all runs of a batch.

    Attributes:
        period: between two ticks [s].
        planned: (M, 2) the leader's place, by the tick of the mission, at that tick.
        wanted: (M, R, 2, 2) distance and bearing about each leader, likewise.
        leaders: (R, 2) whom a robot follows, -1 for none.
        settles_by: (R,) the shape's first change; inf without one [s].
        camera_offset: of the followers' camera points, d [m].
        side: of the square bodies [m].
    """

    period: float
    planned: Floats
    wanted: Floats
    leaders: Integers
    settles_by: Floats
    camera_offset: float
    side: float


class Figures(NamedTuple):
    """How well N runs went; NaN where a figure does not apply.

    Attributes:
        followers: (N, R, 7) as in `scores.FollowerScore`: rms and maximum of the distance's error
            [m], of the bearing's [rad], settled at [s], greatest speeds [m/s, rad/s].
        leader: (N,) rms of its distance to the plan [m].
        clearance: (N,) least distance between two bodies [m].
    """

    followers: Floats
    leader: Floats
    clearance: Floats
