"""The filter's equations as loops, for machine code that predicts and corrects a thousand times.

What `control/estimation.py` does with numpy and filterpy; the tests hold both against each other.
"""

from math import sqrt
from typing import TypeAlias

from control.actuation import DriveGain
from control.compilable import compilable
from control.geometry import wrap_angle
from control.motion_model import Array, ProcessNoise, Transition
from control.unicycle import UnicycleState

Column: TypeAlias = tuple[float, float, float, float, float, float, float]

GAIN_RANGE = (0.5, 2.0)
"""What a drive gain may be: a robot that is held or slips is no robot of gain 0."""


@compilable
def propagate(covariance: Array, f: Transition, noise: ProcessNoise) -> None:
    """Replace a covariance by that after a roll: F P F' + Q.

    Args:
        covariance: (7, 7) P, symmetric; stays so to the last bit.
        f: Jacobian of the roll.
        noise: Q of the roll.
    """
    p = covariance
    for j in range(7):
        column = p[0, j], p[1, j], p[2, j], p[3, j], p[4, j], p[5, j], p[6, j]
        p[0, j], p[1, j], p[2, j], p[3, j], p[4, j] = _rolled(f, column)
    for i in range(7):
        row = p[i, 0], p[i, 1], p[i, 2], p[i, 3], p[i, 4], p[i, 5], p[i, 6]
        p[i, 0], p[i, 1], p[i, 2], p[i, 3], p[i, 4] = _rolled(f, row)
    x, y, theta = noise.x, noise.y, noise.theta
    p[0, 0] += x[0]
    p[1, 0] += x[1]
    p[2, 0] += x[2]
    p[3, 0] += x[3]
    p[4, 0] += x[4]
    p[1, 1] += y[0]
    p[2, 1] += y[1]
    p[3, 1] += y[2]
    p[4, 1] += y[3]
    p[2, 2] += theta[0]
    p[4, 2] += theta[1]
    p[3, 3] += noise.speeds[0]
    p[4, 4] += noise.speeds[1]
    p[5, 5] += noise.gains[0]
    p[6, 6] += noise.gains[1]
    for i in range(1, 7):
        for j in range(i):
            p[j, i] = p[i, j]


@compilable
def correct_by_pose(
    state: UnicycleState, gain: DriveGain, covariance: Array, measured: Array, noise: Array,
    room: Array,
) -> tuple[UnicycleState, DriveGain]:  # fmt: skip
    """State, gains and covariance corrected by a pose measured at the same time.

    With the triangle L of the innovation's covariance, L L' = H P H' + R, and Y = L^-1 H P the
    state gains Y' L^-1 (z - H x), the covariance loses Y' Y.

    Args:
        state: before.
        gain: before.
        covariance: (7, 7) P, symmetric; replaced, and stays so to the last bit.
        measured: (3,) z: x, y, theta [m, m, rad].
        noise: (3, 3) R of the measured pose.
        room: (7, 3) for Y', so that none has to be found every time.

    Returns:
        State, and gains kept within `GAIN_RANGE`.
    """
    p, r, y, (low, high) = covariance, noise, room, GAIN_RANGE
    a = 1.0 / sqrt(p[0, 0] + r[0, 0])  # of the triangle's diagonal a, c, f: one over it
    b, d = (p[1, 0] + r[1, 0]) * a, (p[2, 0] + r[2, 0]) * a
    c = 1.0 / sqrt(p[1, 1] + r[1, 1] - b * b)
    e = (p[2, 1] + r[2, 1] - b * d) * c
    f = 1.0 / sqrt(p[2, 2] + r[2, 2] - d * d - e * e)
    z0 = (measured[0] - state.x) * a
    z1 = (measured[1] - state.y - b * z0) * c
    z2 = (wrap_angle(measured[2] - state.theta) - d * z0 - e * z1) * f
    for i in range(7):
        y[i, 0] = p[i, 0] * a
        y[i, 1] = (p[i, 1] - b * y[i, 0]) * c
        y[i, 2] = (p[i, 2] - d * y[i, 0] - e * y[i, 1]) * f
    for i in range(7):
        for j in range(i + 1):
            p[i, j] -= y[i, 0] * y[j, 0] + y[i, 1] * y[j, 1] + y[i, 2] * y[j, 2]
            p[j, i] = p[i, j]
    corrected = UnicycleState(
        state.x + y[0, 0] * z0 + y[0, 1] * z1 + y[0, 2] * z2,
        state.y + y[1, 0] * z0 + y[1, 1] * z1 + y[1, 2] * z2,
        state.theta + y[2, 0] * z0 + y[2, 1] * z1 + y[2, 2] * z2,
        state.v + y[3, 0] * z0 + y[3, 1] * z1 + y[3, 2] * z2,
        state.omega + y[4, 0] * z0 + y[4, 1] * z1 + y[4, 2] * z2,
    )
    gain_v = gain.v + y[5, 0] * z0 + y[5, 1] * z1 + y[5, 2] * z2
    gain_omega = gain.omega + y[6, 0] * z0 + y[6, 1] * z1 + y[6, 2] * z2
    return corrected, DriveGain(max(low, min(high, gain_v)), max(low, min(high, gain_omega)))


@compilable
def _rolled(f: Transition, p: Column) -> tuple[float, float, float, float, float]:
    """F times a column, but for its last two entries: they stay."""
    x, y, theta = f.x, f.y, f.theta
    return (
        p[0] + x[0] * p[2] + x[1] * p[3] + x[2] * p[4] + x[3] * p[5] + x[4] * p[6],
        p[1] + y[0] * p[2] + y[1] * p[3] + y[2] * p[4] + y[3] * p[5] + y[4] * p[6],
        p[2] + theta[0] * p[4] + theta[1] * p[6],
        f.v[0] * p[3] + f.v[1] * p[5],
        f.omega[0] * p[4] + f.omega[1] * p[6],
    )
