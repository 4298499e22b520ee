"""Model (3) over one step with a constant drive: what the world and the batched runs share.

v' = ((1 + eps) c_v - v) / lag + pi_v,   omega' = ((1 + eps') c_omega - omega) / lag + pi_omega
"""

from math import cos, exp, sin, sqrt
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from control.compilable import compilable
from control.geometry import cos_of_turn, sin_of_turn

Motion: TypeAlias = tuple[float, float, float, float, float]  # x, y, theta, v, omega
Floats = NDArray[np.float64]

GRID = 0.005
"""Longest step [s]."""

SLACK = 1e-9
"""Times closer than this are the same [s]."""

TONES = 3
"""Sinusoids in a disturbance."""

_EARLY, _LATE = 0.5 - sqrt(3.0) / 6.0, 0.5 + sqrt(3.0) / 6.0  # Gauss's two points on [0, 1]


@compilable
def motion_after(motion: Motion, goal_v: float, goal_omega: float, lag: float, dt: float) -> Motion:
    """Drive on towards constant velocities.

    Velocities and heading are exact; the place is integrated by Gauss's two-point rule.

    Args:
        motion: at the start; the heading is not wrapped [m, m, rad, m/s, rad/s].
        goal_v: forward velocity the motors tend to [m/s].
        goal_omega: angular velocity they tend to [rad/s].
        lag: time constant of the motors, >= 0 [s].
        dt: duration; the motion is given back as it is unless > 0 [s].

    Returns:
        Motion at the end.
    """
    if dt <= 0.0:
        return motion
    x, y, theta, v, omega = motion
    dv, dw = v - goal_v, omega - goal_omega
    early, late = (exp(-_EARLY * dt / lag), exp(-_LATE * dt / lag)) if lag > 0.0 else (0.0, 0.0)
    first = goal_omega * _EARLY * dt + dw * lag * (1.0 - early)  # turned by then
    last = goal_omega * _LATE * dt + dw * lag * (1.0 - late)
    middle, half = theta + 0.5 * (first + last), 0.5 * (last - first)
    along = dt * (goal_v + 0.5 * dv * (early + late)) * cos_of_turn(half)
    aside = 0.5 * dt * dv * (early - late) * sin_of_turn(half)
    c, s = cos(middle), sin(middle)
    x, y = x + along * c + aside * s, y + along * s - aside * c
    decay = early * late  # the nodes share out the step
    theta += goal_omega * dt + dw * lag * (1.0 - decay)
    return x, y, theta, goal_v + dv * decay, goal_omega + dw * decay


@compilable
def wave(tones: Floats, t: float) -> float:
    """A seeded sum of slow sinusoids, within -1 and 1 by construction.

    Args:
        tones: (TONES, 2) angular frequency and phase of each [rad/s, rad].
        t: time [s].

    Returns:
        Share of a disturbance's bound.
    """
    total = 0.0
    for tone in range(TONES):
        total += sin(tones[tone, 0] * t + tones[tone, 1])
    return total / TONES


def draw_tones(rng: np.random.Generator) -> Floats:
    """Draw the tones of a robot's disturbances, 0.2 to 3 Hz.

    Args:
        rng: decides.

    Returns:
        (2, TONES, 2): of the forward and of the angular disturbance.
    """
    return 2.0 * np.pi * rng.uniform((0.2, 0.0), (3.0, 1.0), (2, TONES, 2))
