"""The filter's equations as loops, for machine code that predicts and corrects a thousand times.

What `control/estimation.py` does with numpy and filterpy; the tests hold both against each other.
"""

from math import sqrt

import numpy as np

from control.actuation import DriveGain
from control.compilable import compilable
from control.geometry import wrap_angle
from control.motion_model import Array
from control.unicycle import UnicycleState

GAIN_RANGE = (0.5, 2.0)
"""What a drive gain may be: a robot that is held or slips is no robot of gain 0."""


@compilable
def propagate(covariance: Array, f: Array, noise: Array) -> Array:
    """Covariance after a roll: F P F' + Q.

    Args:
        covariance: (7, 7) P, symmetric.
        f: (7, 7) Jacobian of the roll, `motion_model.transition`, upper triangular.
        noise: (7, 7) Q, `motion_model.process_noise`.

    Returns:
        (7, 7), symmetric to the last bit.
    """
    half, new = np.empty((7, 7)), np.empty((7, 7))
    for i in range(7):
        for j in range(7):
            total = 0.0
            for k in range(i, 7):
                total += f[i, k] * covariance[j, k]
            half[i, j] = total
        for j in range(i + 1):
            total = noise[i, j]
            for k in range(j, 7):
                total += half[i, k] * f[j, k]
            new[i, j] = new[j, i] = total
    return new


@compilable
def correct_by_pose(
    state: UnicycleState, gain: DriveGain, covariance: Array, measured: Array, noise: Array
) -> tuple[UnicycleState, DriveGain, Array]:
    """State, gains and covariance corrected by a pose measured at the same time, in Joseph's form.

    Args:
        state: before.
        gain: before.
        covariance: (7, 7) P before, symmetric.
        measured: (3,) x, y, theta [m, m, rad].
        noise: (3, 3) R of the measured pose.

    Returns:
        State, gains kept within `GAIN_RANGE`, and (7, 7) covariance, symmetric to the last bit.
    """
    k, (low, high) = _kalman_gain(covariance, noise), GAIN_RANGE
    a, b = measured[0] - state.x, measured[1] - state.y
    c = wrap_angle(measured[2] - state.theta)
    corrected = UnicycleState(
        state.x + k[0, 0] * a + k[0, 1] * b + k[0, 2] * c,
        state.y + k[1, 0] * a + k[1, 1] * b + k[1, 2] * c,
        state.theta + k[2, 0] * a + k[2, 1] * b + k[2, 2] * c,
        state.v + k[3, 0] * a + k[3, 1] * b + k[3, 2] * c,
        state.omega + k[4, 0] * a + k[4, 1] * b + k[4, 2] * c,
    )
    gain_v = gain.v + k[5, 0] * a + k[5, 1] * b + k[5, 2] * c
    gain_omega = gain.omega + k[6, 0] * a + k[6, 1] * b + k[6, 2] * c
    within = DriveGain(max(low, min(high, gain_v)), max(low, min(high, gain_omega)))
    return corrected, within, _joseph(covariance, k, noise)


@compilable
def _kalman_gain(covariance: Array, noise: Array) -> Array:
    """K = P H' (H P H' + R)^-1, (7, 3), by Cholesky's triangle of the innovation's covariance."""
    p, r = covariance, noise
    a = 1.0 / sqrt(p[0, 0] + r[0, 0])  # of the triangle's diagonal a, c, f: one over it
    b, d = (p[1, 0] + r[1, 0]) * a, (p[2, 0] + r[2, 0]) * a
    c = 1.0 / sqrt(p[1, 1] + r[1, 1] - b * b)
    e = (p[2, 1] + r[2, 1] - b * d) * c
    f = 1.0 / sqrt(p[2, 2] + r[2, 2] - d * d - e * e)
    k = np.empty((7, 3))
    for i in range(7):
        y0 = p[i, 0] * a
        y1 = (p[i, 1] - b * y0) * c
        k[i, 2] = (p[i, 2] - d * y0 - e * y1) * f * f
        k[i, 1] = (y1 - e * k[i, 2]) * c
        k[i, 0] = (y0 - b * k[i, 1] - d * k[i, 2]) * a
    return k


@compilable
def _joseph(covariance: Array, k: Array, noise: Array) -> Array:
    """(I - K H) P (I - K H)' + K R K'."""
    p, r, new = covariance, noise, np.empty((7, 7))
    for i in range(7):
        a, b, c = k[i, 0], k[i, 1], k[i, 2]
        # row i of K R - (I - K H) P H'
        u = a * r[0, 0] + b * r[1, 0] + c * r[2, 0] - _left(p, i, 0, a, b, c)
        v = a * r[0, 1] + b * r[1, 1] + c * r[2, 1] - _left(p, i, 1, a, b, c)
        w = a * r[0, 2] + b * r[1, 2] + c * r[2, 2] - _left(p, i, 2, a, b, c)
        for j in range(i + 1):
            total = _left(p, i, j, a, b, c) + u * k[j, 0] + v * k[j, 1] + w * k[j, 2]
            new[i, j] = new[j, i] = total
    return new


@compilable
def _left(p: Array, i: int, j: int, a: float, b: float, c: float) -> float:
    """Entry of (I - K H) P, with row i of K."""
    return float(p[i, j] - a * p[0, j] - b * p[1, j] - c * p[2, j])
