"""What becomes of the laws' commands in one run, as in `pipeline/restraint.py`.

Slowed by the safety rules, kept off other bodies; the laws learn what their robots really get.
"""

import numpy as np
from numpy.typing import NDArray

from control.compilable import compilable
from control.leader import LeaderMemory
from control.safety import keep_apart
from control.sliding import overruled
from control.unicycle import Twist
from datasets.simulation.filters import Filters
from datasets.simulation.inputs import Field, Floats, Host
from datasets.simulation.laws import Laws, sample_of


@compilable
def restrain(
    laws: Laws, filters: Filters, host: Host, field: Field, mission: int, share: float,
    commands: Floats, kept: NDArray[np.bool_],
) -> None:  # fmt: skip
    """Turn what the laws want into what may be sent.

    Args:
        laws: told of what is given instead.
        filters: states at the moment the commands take effect.
        host: motors, clearance and arena.
        field: who gives way, and references.
        mission: tick of the mission.
        share: of its speed that every robot may drive.
        commands: (R, 2) v and omega, replaced where they may not be [m/s, rad/s].
        kept: (R,) filled: who is kept off others.
    """
    wanted = commands.copy()
    commands *= share
    _keep_apart(filters, host, field, commands, kept)
    for robot in range(len(commands)):
        given = Twist(commands[robot, 0], commands[robot, 1])
        if given.v != wanted[robot, 0] or given.omega != wanted[robot, 1]:
            _tell(laws, filters, host, field, mission, robot, given)


@compilable
def _keep_apart(
    filters: Filters, host: Host, field: Field, commands: Floats, kept: NDArray[np.bool_]
) -> None:
    """Replace the commands that lead too near to others."""
    count, dt, motors = len(commands), host.period, host.follower.actuation
    poses, ways = np.empty((count, 3)), np.empty((3, count, 2))  # wanted, least, greatest
    for robot in range(count):
        state, gain = filters.ahead[robot], filters.gains[robot]
        poses[robot, 0], poses[robot, 1], poses[robot, 2] = state.x, state.y, state.theta
        command = Twist(commands[robot, 0], commands[robot, 1])
        a, b = motors.acceleration(state.twist, command, dt, gain)
        low, high = motors.reachable(state.twist, dt, gain)
        ways[0, robot, 0], ways[0, robot, 1] = state.v + dt * a, state.omega + dt * b
        ways[1, robot, 0], ways[1, robot, 1] = low.v, low.omega
        ways[2, robot, 0], ways[2, robot, 1] = high.v, high.omega
    reached = keep_apart(
        poses, ways[0], ways[1], ways[2], field.freedoms, host.clearance, host.arena
    )
    for robot in range(count):
        own, to = filters.ahead[robot].twist, reached[robot]
        kept[robot] = to[0] != ways[0, robot, 0] or to[1] != ways[0, robot, 1]
        if kept[robot]:
            u = (to[0] - own.v) / dt, (to[1] - own.omega) / dt
            command, _ = motors.command(own, u, dt, filters.gains[robot])
            commands[robot, 0], commands[robot, 1] = command.v, command.omega


@compilable
def _tell(
    laws: Laws, filters: Filters, host: Host, field: Field, mission: int, robot: int, given: Twist
) -> None:
    """Let a law know what its robot gets, so that nothing winds up."""
    own = filters.ahead[robot].twist
    u = host.follower.actuation.acceleration(own, given, host.period, filters.gains[robot])
    if robot == 0:
        m = laws.leader[0]
        laws.leader[0] = LeaderMemory(m.error, m.integral, m.sliding, u, m.fresh)
    else:
        sample = sample_of(laws, filters, host, field, mission, robot, False)
        laws.followers[robot] = overruled(laws.followers[robot], sample, u, laws.gains[robot])
    laws.given[robot] = u
