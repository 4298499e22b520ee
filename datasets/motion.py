"""Where moving robots are a moment before or after: arcs at constant velocity."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def moved(motions: Floats, dt: Floats) -> Floats:
    """Follow the arcs of unicycles, exactly.

    Args:
        motions: shape (N, 5), x, y, theta, v, omega [m, m, rad, m/s, rad/s].
        dt: shape (N,), how much later; negative for earlier [s].

    Returns:
        Poses x, y, theta, shape (N, 3) [m, m, rad].
    """
    x, y, theta, v, omega = motions.T
    half = 0.5 * omega * dt
    chord = v * dt * np.sinc(half / np.pi)
    ahead = theta + half
    return np.column_stack((x + chord * np.cos(ahead), y + chord * np.sin(ahead), ahead + half))
