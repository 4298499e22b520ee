"""What becomes of the laws' commands in one run, as in `pipeline/restraint.py`.

Slowed by the safety rules, kept off other bodies; the laws learn what their robots really get.
"""

import numpy as np
from numpy.typing import NDArray

from control.clearing import clear_commands
from control.compilable import compilable
from control.leader import LeaderMemory
from control.relative import Vector2
from control.sliding import overruled
from control.unicycle import Twist
from datasets.simulation.filters import gain_of, state_of
from datasets.simulation.inputs import Floats, Host
from datasets.simulation.laws import Laws, sample_of


@compilable
def restrain(
    laws: Laws, ahead: Floats, means: Floats, host: Host, freedoms: Floats, wanted: Floats,
    wishes: Floats, share: float, commands: Floats, kept: NDArray[np.bool_],
) -> None:  # fmt: skip
    """Turn what the laws want into what may be sent.

    Args:
        laws: told of what is given instead.
        ahead: (R, 5) states at the moment the commands take effect.
        means: (R, 7) as in `Filters`.
        host: motors, clearance and arena.
        freedoms: (R,) who gives way.
        wanted: (R, 6) references of the present tick.
        wishes: (R, 2) v and omega that the laws want [m/s, rad/s].
        share: of its speed that every robot may drive.
        commands: (R, 2) filled with v and omega that may be [m/s, rad/s].
        kept: (R,) filled: who is kept off others.
    """
    motors = host.follower.actuation
    for robot in range(len(commands)):
        commands[robot, 0] = share * wishes[robot, 0]
        commands[robot, 1] = share * wishes[robot, 1]
    clear = clear_commands(
        ahead, commands, means[:, 5:], freedoms, host.period, motors, host.clearance, host.arena
    )
    for robot in range(len(commands)):
        v, omega = clear[robot]
        kept[robot] = v != commands[robot, 0] or omega != commands[robot, 1]
        commands[robot, 0], commands[robot, 1] = v, omega
        if v != wishes[robot, 0] or omega != wishes[robot, 1]:
            own, gain = state_of(ahead, robot).twist, gain_of(means, robot)
            u = motors.acceleration(own, Twist(v, omega), host.period, gain)
            _tell(laws, ahead, means, wanted, robot, u, host.follower.camera_offset)


@compilable
def _tell(
    laws: Laws, ahead: Floats, means: Floats, wanted: Floats, robot: int, u: Vector2, d: float
) -> None:
    """Let a law know what its robot gets, so that nothing winds up."""
    if robot == 0:
        m = laws.leader[0]
        laws.leader[0] = LeaderMemory(m.error, m.integral, m.sliding, u, m.fresh)
    else:
        role = laws.roles[robot]
        sample = sample_of(ahead, means, laws.given, wanted, robot, role, False, d)
        laws.followers[robot] = overruled(laws.followers[robot], sample, u, role.gains)
    laws.given[robot, 0], laws.given[robot, 1] = u
