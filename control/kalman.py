"""The filter's equations as loops, for machine code that predicts and corrects a thousand times.

What `control/estimation.py` does with numpy and filterpy; the tests hold both against each other.
"""

from math import sqrt

import numpy as np

from control.compilable import compilable
from control.geometry import wrap_angle
from control.motion_model import Array

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
    half, new = np.zeros((7, 7)), np.empty((7, 7))
    for i in range(7):
        for k in range(i, 7):
            for j in range(7):
                half[i, j] += f[i, k] * covariance[k, j]
        for j in range(i + 1):
            total = noise[i, j]
            for k in range(j, 7):
                total += half[i, k] * f[j, k]
            new[i, j] = new[j, i] = total
    return new


@compilable
def correct_by_pose(
    mean: Array, covariance: Array, measured: Array, noise: Array
) -> tuple[Array, Array]:
    """Mean and covariance corrected by a pose measured at the same time, in Joseph's form.

    Args:
        mean: (7,) before.
        covariance: (7, 7) P before, symmetric.
        measured: (3,) x, y, theta [m, m, rad].
        noise: (3, 3) R of the measured pose.

    Returns:
        Mean with the gains kept within `GAIN_RANGE`, and covariance, symmetric to the last bit.
    """
    k = _kalman_gain(covariance, noise)
    r = measured - mean[:3]
    r[2] = wrap_angle(r[2])
    new = np.empty(7)
    for i in range(7):
        new[i] = mean[i] + k[i, 0] * r[0] + k[i, 1] * r[1] + k[i, 2] * r[2]
    low, high = GAIN_RANGE
    new[5], new[6] = max(low, min(high, new[5])), max(low, min(high, new[6]))
    return new, _joseph(covariance, k, noise)


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
    left = np.empty((7, 7))  # (I - K H) P
    weight = np.empty((7, 3))  # K R - (I - K H) P H'
    for i in range(7):
        for j in range(7):
            left[i, j] = covariance[i, j]
            for m in range(3):
                left[i, j] -= k[i, m] * covariance[m, j]
        for m in range(3):
            weight[i, m] = -left[i, m]
            for n in range(3):
                weight[i, m] += k[i, n] * noise[n, m]
    new = np.empty((7, 7))
    for i in range(7):
        for j in range(i + 1):
            total = left[i, j]
            for m in range(3):
                total += weight[i, m] * k[j, m]
            new[i, j] = new[j, i] = total
    return new
