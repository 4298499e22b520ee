"""Commands under which bodies stay apart: to the velocities they lead to, and back."""

import numpy as np

from control.actuation import Actuation, DriveGain
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
        (N, 2) commands; those of `commands`, to the last bit, for robots that need not give way
        [m/s, rad/s].
    """
    count = len(states)
    ways = np.empty((3, count, 2))  # wanted, least and greatest velocities at the end of dt
    for i in range(count):
        own, gain = Twist(states[i, 3], states[i, 4]), DriveGain(gains[i, 0], gains[i, 1])
        ways[:, i, 0], ways[:, i, 1] = own.v, own.omega
        if not np.isnan(commands[i, 0]):
            command = Twist(commands[i, 0], commands[i, 1])
            a, b = motors.acceleration(own, command, dt, gain)
            low, high = motors.reachable(own, dt, gain)
            ways[0, i, 0], ways[0, i, 1] = own.v + dt * a, own.omega + dt * b
            ways[1, i, 0], ways[1, i, 1] = low.v, low.omega
            ways[2, i, 0], ways[2, i, 1] = high.v, high.omega
    reached = keep_apart(states[:, :3], ways[0], ways[1], ways[2], freedoms, clearance, arena)
    given = commands.copy()
    for i in range(count):
        if reached[i, 0] != ways[0, i, 0] or reached[i, 1] != ways[0, i, 1]:
            own, gain = Twist(states[i, 3], states[i, 4]), DriveGain(gains[i, 0], gains[i, 1])
            u = (reached[i, 0] - own.v) / dt, (reached[i, 1] - own.omega) / dt
            command, _ = motors.command(own, u, dt, gain)
            given[i, 0], given[i, 1] = command.v, command.omega
    return given
