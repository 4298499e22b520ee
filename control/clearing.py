"""Commands under which bodies stay apart: to the velocities they lead to, and back."""

import numpy as np

from control.actuation import Actuation, DriveGain
from control.barriers import all_far
from control.compilable import compilable
from control.safety import Arena, Clearance, Floats, keep_apart
from control.unicycle import Twist


@compilable
def clear_commands(
    states: Floats,
    commands: Floats,
    gains: Floats,
    freedoms: Floats,
    dt: float,
    motors: Actuation,
    clearance: Clearance,
    arena: Arena,
) -> Floats:
    """The commands nearest to the wanted ones under which bodies stay apart and inside.

    Args:
        states: (N, 5) x, y, theta, v, omega when the commands take effect [m, m, rad, m/s, rad/s].
        commands: (N, 2) wanted; of robots nobody drives NaN [m/s, rad/s].
        gains: (N, 2) drive gains [1].
        freedoms: (N,) how easily a robot gives way: 0 for one that cannot be told to.
        dt: for which the commands hold, > 0 [s].
        motors: lag and limits.
        clearance: what is kept, and how.
        arena: what must not be left.

    Returns:
        (N, 2) commands; those of `commands`, to the last bit, for robots that need not give way,
        and that very array where nothing is close [m/s, rad/s].
    """
    wanted = commands.copy()  # velocities at the end of dt
    for i in range(len(states)):
        own, gain = Twist(states[i, 3], states[i, 4]), DriveGain(gains[i, 0], gains[i, 1])
        a, b = 0.0, 0.0
        if not np.isnan(commands[i, 0]):
            a, b = motors.acceleration(own, Twist(commands[i, 0], commands[i, 1]), dt, gain)
        wanted[i, 0], wanted[i, 1] = own.v + dt * a, own.omega + dt * b
    if all_far(states, wanted, freedoms, clearance, arena):
        return commands
    low, high = wanted.copy(), wanted.copy()
    for i in range(len(states)):
        if not np.isnan(commands[i, 0]):
            own, gain = Twist(states[i, 3], states[i, 4]), DriveGain(gains[i, 0], gains[i, 1])
            least, most = motors.reachable(own, dt, gain)
            low[i, 0], low[i, 1] = least.v, least.omega
            high[i, 0], high[i, 1] = most.v, most.omega
    reached = keep_apart(states[:, :3], wanted, low, high, freedoms, clearance, arena)
    given = commands.copy()
    for i in range(len(states)):
        if reached[i, 0] != wanted[i, 0] or reached[i, 1] != wanted[i, 1]:
            own, gain = Twist(states[i, 3], states[i, 4]), DriveGain(gains[i, 0], gains[i, 1])
            u = (reached[i, 0] - own.v) / dt, (reached[i, 1] - own.omega) / dt
            command, _ = motors.command(own, u, dt, gain)
            given[i, 0], given[i, 1] = command.v, command.omega
    return given
