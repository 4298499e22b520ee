"""Positions on the floor, and the same seen from a plan's start pose."""

from math import cos, sin

import numpy as np

from control.geometry import Pose2D
from control.motion_model import Array


def directions_seen_from(pose: Pose2D, directions: Array) -> Array:
    """Directions in the frame of a pose.

    Args:
        pose: T_floor_frame [m, m, rad].
        directions: (2, n) on the floor.

    Returns:
        (2, n) in the frame.
    """
    turned: Array = _axes(pose).T @ directions
    return turned


def seen_from(pose: Pose2D, points: Array) -> Array:
    """Points in the frame of a pose.

    Args:
        pose: T_floor_frame [m, m, rad].
        points: (2, n) on the floor [m].

    Returns:
        (2, n) in the frame [m].
    """
    return directions_seen_from(pose, points - [[pose.x], [pose.y]])


def on_floor(pose: Pose2D, points: Array) -> Array:
    """Points on the floor.

    Args:
        pose: T_floor_frame [m, m, rad].
        points: (2, n) in the frame [m].

    Returns:
        (2, n) on the floor [m].
    """
    moved: Array = _axes(pose) @ points + [[pose.x], [pose.y]]
    return moved


def _axes(pose: Pose2D) -> Array:
    """(2, 2) axes of a frame, as columns."""
    c, s = cos(pose.theta), sin(pose.theta)
    return np.array([[c, -s], [s, c]])
