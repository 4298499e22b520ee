"""How well a formation was kept, from a ring's truth: relative configurations about robot 1."""

from collections.abc import Mapping, Sequence
from math import atan2, cos, hypot, pi, sin
from typing import Any

import numpy as np
from numpy.typing import NDArray

from control.geometry import wrap_angle

CAMERA_OFFSET = 0.05  # of the followers' camera points [m]
WANTED: Mapping[int, tuple[float, float]] = {2: (0.15, 0.75 * pi), 3: (0.30, -0.75 * pi)}
"""Distance [m] and bearing [rad] of the paper's followers, after the change of size."""


def relative(robots: Sequence[Mapping[str, Any]], follower: int) -> tuple[float, float]:
    """True distance and bearing of a follower about robot 1, equations (6) and (7).

    Args:
        robots: of one frame of the truth.
        follower: id.

    Returns:
        Distance [m], bearing in (-pi, pi] [rad].
    """
    by_id = {robot["id"]: robot for robot in robots}
    i, k = by_id[1], by_id[follower]
    x = i["x_m"] - k["x_m"] - CAMERA_OFFSET * cos(k["theta_rad"])
    y = i["y_m"] - k["y_m"] - CAMERA_OFFSET * sin(k["theta_rad"])
    return hypot(x, y), wrap_angle(pi + atan2(y, x) - i["theta_rad"])


def errors(frames: Sequence[Mapping[str, Any]], follower: int) -> NDArray[np.float64]:
    """A follower's errors after the change of size.

    Args:
        frames: of the truth.
        follower: id.

    Returns:
        Shape (N, 2): distance [m], bearing, wrapped [rad].
    """
    distance, bearing = WANTED[follower]
    seen = (relative(frame["robots"], follower) for frame in frames)
    return np.array([(d - distance, wrap_angle(b - bearing)) for d, b in seen])
