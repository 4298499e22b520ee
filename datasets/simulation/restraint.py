"""What becomes of the laws' commands in one run, as in `pipeline/restraint.py`.

Slowed by the safety rules, kept off other bodies; the laws learn what their robots really get.
"""

import numpy as np
from numpy.typing import NDArray

from control.clearing import clear_commands
from control.compilable import compilable
from control.leader import LeaderMemory
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
    count = len(commands)
    states, gains = np.empty((count, 5)), np.empty((count, 2))
    for robot in range(count):
        state, gain = filters.ahead[robot], filters.gains[robot]
        states[robot, 0], states[robot, 1], states[robot, 2] = state.x, state.y, state.theta
        states[robot, 3], states[robot, 4] = state.v, state.omega
        gains[robot, 0], gains[robot, 1] = gain.v, gain.omega
    given = clear_commands(
        states, commands, gains, field.freedoms, host.period, host.follower.actuation,
        host.clearance, host.arena,
    )  # fmt: skip
    for robot in range(count):
        kept[robot] = given[robot, 0] != commands[robot, 0] or given[robot, 1] != commands[robot, 1]
        commands[robot] = given[robot]


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
