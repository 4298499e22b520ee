"""The conditions under which bodies stay apart, and inside the arena: rows for `control.safety`.

Each corner of a square body has a distance h to every other body, and the circle about the body has
one to every side of the arena, which may shrink only slowly: h' >= -rate (h - clearance), not at
all where h < clearance. h' is linear in the velocities: that of the corner against that of the
nearest point of the other body, along the line between them.
"""

from dataclasses import dataclass
from math import cos, hypot, inf, sin, sqrt

import numpy as np
from numpy.typing import NDArray

from control.compilable import compilable
from control.errors import ControlError
from control.value import value

Floats = NDArray[np.float64]
Row = tuple[int, int, float, float, float, float, float]
"""Robots i and j, what h' takes of v_i, w_i, v_j and w_j, and the least h' [m/s]."""


@value
@dataclass(frozen=True, slots=True)
class Arena:
    """The rectangle that bodies must not leave.

    Attributes:
        x_low: its left side [m].
        y_low: its near side [m].
        x_high: its right side [m].
        y_high: its far side [m].

    Raises:
        ControlError: unless low < high.
    """

    x_low: float = -inf
    y_low: float = -inf
    x_high: float = inf
    y_high: float = inf

    def __post_init__(self) -> None:
        if not (self.x_low < self.x_high and self.y_low < self.y_high):
            raise ControlError(f"an arena needs low < high on both axes, got {self}")


@value
@dataclass(frozen=True, slots=True)
class Clearance:
    """How far apart bodies are kept.

    Attributes:
        distance: between bodies, and to the arena's sides, >= 0 [m].
        rate: share of the distance beyond it that may be lost a second, > 0 [1/s].
        arm: way that counts as much as a radian, > 0: the less, the rather robots turn [m].
        half_side: of the square bodies, > 0 [m].

    Raises:
        ControlError: if a number is out of its range.
    """

    distance: float = 0.022
    rate: float = 8.0
    arm: float = 0.05
    half_side: float = 0.0375

    def __post_init__(self) -> None:
        if not (self.distance >= 0.0 and min(self.rate, self.arm, self.half_side) > 0.0):
            raise ControlError(f"a clearance >= 0 m with rate, arm and body > 0, got {self}")


@compilable
def all_far(
    poses: Floats, twists: Floats, freedoms: Floats, clearance: Clearance, arena: Arena
) -> bool:
    """Whether every row is met for certain, seen without one: by circles around the bodies.

    Args:
        poses: (N, 3 or more) x, y, theta [m, m, rad].
        twists: (N, 2) velocities [m/s, rad/s].
        freedoms: (N,) how easily a robot gives way.
        clearance: what is kept, and how.
        arena: what must not be left.

    Returns:
        True only if `corner_rows` has none that these velocities break.
    """
    half = clearance.half_side
    for i in range(len(poses)):
        reach = _reach(twists, i, half)
        near = clearance.distance + 1.5 * half + reach / clearance.rate
        if freedoms[i] > 0.0 and not _inside(poses, i, arena, near):
            return False
        for j in range(i):
            x, y = poses[i, 0] - poses[j, 0], poses[i, 1] - poses[j, 1]
            room = clearance.rate * (sqrt(x * x + y * y) - clearance.distance - 3.0 * half)
            if room >= reach + _reach(twists, j, half):  # whatever their headings
                continue
            if room < _closing(poses, twists, i, j, half) and freedoms[i] + freedoms[j] > 0.0:
                return False
    return True


@compilable
def _closing(poses: Floats, twists: Floats, i: int, j: int, half: float) -> float:
    """Greatest speed between a point of one body and a point of another [m/s]."""
    v, u, between = twists[i, 0], twists[j, 0], poses[i, 2] - poses[j, 2]
    turning = abs(twists[i, 1]) + abs(twists[j, 1])
    return float(sqrt(max(v * v + u * u - 2.0 * v * u * cos(between), 0.0)) + 1.5 * half * turning)


@compilable
def corner_rows(
    poses: Floats, twists: Floats, freedoms: Floats, clearance: Clearance, arena: Arena
) -> list[Row]:
    """Conditions on all corners that could matter at these velocities.

    Args:
        poses: (N, 3) x, y, theta [m, m, rad].
        twists: (N, 2) velocities [m/s, rad/s].
        freedoms: (N,) how easily a robot gives way.
        clearance: what is kept, and how.
        arena: what must not be left.

    Returns:
        The rows, of which the first always holds.
    """
    headings = np.empty((len(poses), 2))
    for i in range(len(poses)):
        headings[i, 0], headings[i, 1] = cos(poses[i, 2]), sin(poses[i, 2])
    rows = [(0, 0, 0.0, 0.0, 0.0, 0.0, -1.0)]  # one that always holds: the list's type
    half = clearance.half_side
    for i in range(len(poses)):
        reach = _reach(twists, i, half)
        near = clearance.distance + 1.5 * half + reach / clearance.rate
        if freedoms[i] > 0.0 and not _inside(poses, i, arena, near):
            _add_borders(rows, poses, headings, i, clearance, arena)
        for j in range(i):
            apart = hypot(poses[i, 0] - poses[j, 0], poses[i, 1] - poses[j, 1])
            closing = (reach + _reach(twists, j, half)) / clearance.rate
            if apart < clearance.distance + 3.0 * half + closing and freedoms[i] + freedoms[j] > 0:
                for corner in range(4):
                    rows.append(_corner_row(poses, headings, i, j, corner, clearance))
                    rows.append(_corner_row(poses, headings, j, i, corner, clearance))
    return rows


@compilable
def _reach(twists: Floats, i: int, half: float) -> float:
    """Greatest speed of a point of a body [m/s]."""
    return float(abs(twists[i, 0]) + 1.5 * half * abs(twists[i, 1]))


@compilable
def _inside(poses: Floats, i: int, arena: Arena, near: float) -> bool:
    x, y = float(poses[i, 0]), float(poses[i, 1])
    across = x - arena.x_low > near and arena.x_high - x > near
    return across and y - arena.y_low > near and arena.y_high - y > near


@compilable
def _corner(headings: Floats, i: int, corner: int, half: float) -> tuple[float, float]:
    """A corner seen from the body's centre, in floor axes [m, m]."""
    ahead = half if corner < 2 else -half
    left = half if corner % 2 == 0 else -half
    c, s = headings[i, 0], headings[i, 1]
    return ahead * c - left * s, ahead * s + left * c


@compilable
def _corner_row(
    poses: Floats, headings: Floats, i: int, j: int, corner: int, clearance: Clearance
) -> Row:
    """A corner of i against the body of j."""
    half = clearance.half_side
    rx, ry = _corner(headings, i, corner, half)
    dx, dy = poses[i, 0] + rx - poses[j, 0], poses[i, 1] + ry - poses[j, 1]
    c, s = headings[j, 0], headings[j, 1]
    x, y = c * dx + s * dy, c * dy - s * dx  # in the frame of j
    qx, qy = max(-half, min(half, x)), max(-half, min(half, y))
    h = hypot(x - qx, y - qy)
    if h > 0.0:
        nx, ny = (x - qx) / h, (y - qy) / h
    elif half - abs(x) < half - abs(y):  # inside: out by the nearest side
        h, nx, ny = abs(x) - half, 1.0 if x > 0.0 else -1.0, 0.0
    else:
        h, nx, ny = abs(y) - half, 0.0, 1.0 if y > 0.0 else -1.0
    nx, ny = c * nx - s * ny, s * nx + c * ny
    qx, qy = c * qx - s * qy, s * qx + c * qy
    ci, si = headings[i, 0], headings[i, 1]
    least = -clearance.rate * max(h - clearance.distance, 0.0)
    return (
        i, j, nx * ci + ny * si, ny * rx - nx * ry, -nx * c - ny * s, nx * qy - ny * qx, least,
    )  # fmt: skip


@compilable
def _add_borders(
    rows: list[Row], poses: Floats, headings: Floats, i: int, clearance: Clearance, arena: Arena
) -> None:
    """The circle about the body of i against the arena's sides: a body at a side may turn away."""
    x, y, c, s = poses[i, 0], poses[i, 1], headings[i, 0], headings[i, 1]
    radius = hypot(clearance.half_side, clearance.half_side)
    for nx, ny, away in (
        (1.0, 0.0, x - arena.x_low),
        (-1.0, 0.0, arena.x_high - x),
        (0.0, 1.0, y - arena.y_low),
        (0.0, -1.0, arena.y_high - y),
    ):
        if away < inf:
            least = -clearance.rate * max(away - radius - clearance.distance, 0.0)
            rows.append((i, i, nx * c + ny * s, 0.0, 0.0, 0.0, least))
