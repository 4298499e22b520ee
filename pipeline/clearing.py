"""The filter between bodies as machine code: 12 us a call where nothing is close."""

import numpy as np

from control import clearing
from control.actuation import Actuation
from control.safety import Arena, Clearance, Floats
from pipeline.compiling import told_of_compiling
from vision.compiled import compiled

_compiled = compiled(clearing.clear_commands)


def clear_commands(
    table: Floats, dt: float, motors: Actuation, clearance: Clearance, arena: Arena
) -> Floats:
    """`control.clearing.clear_commands` of a table with a row a robot.

    Args:
        table: (N, 10) x, y, theta, v, omega, wanted v and omega, both drive gains, freedom
            [m, m, rad, m/s, rad/s, m/s, rad/s, 1, 1, 1].
        dt: for which the commands hold, > 0 [s].
        motors: lag and limits.
        clearance: what is kept, and how.
        arena: what must not be left.

    Returns:
        (N, 2) commands [m/s, rad/s].
    """
    return _compiled(
        table[:, :5], table[:, 5:7], table[:, 7:9], table[:, 9], dt, motors, clearance, arena
    )


def rehearse_clearing() -> None:
    """Compile the filter, or load it from disk, so that no command waits for it."""
    with told_of_compiling("the safety filter", "some seconds"):
        clear_commands(np.ones((2, 10)), 0.01, Actuation(), Clearance(), Arena())
