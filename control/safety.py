"""Bodies kept apart, and inside the arena: a control-barrier filter on velocities.

Each corner of a square body has a distance h to every other body, and the circle about the body has
one to every side of the arena: square to a side, a body's corners could not turn away from it. The
velocities that commands lead to are left alone if each of these distances shrinks slowly enough,

    h' >= -rate (h - clearance),   not at all where h < clearance,

with h' linear in the velocities: that of the corner against that of the nearest point of the other
body, along the line between them. Else the nearest velocities that do so are given, a quadratic
programme solved by Hildreth's method: row after row, each in closed form; one row alone is solved
at once. Standing still obeys every row, so only what motors can do may stand against it.

Source: A. D. Ames et al., "Control barrier functions: theory and applications", ECC 2019, for the
condition; C. Hildreth, "A quadratic programming procedure", Naval Res. Logistics Quarterly, 1957.
"""

from dataclasses import dataclass
from math import cos, hypot, inf, sin

import numpy as np
from numpy.typing import NDArray

from control.compilable import compilable
from control.errors import ControlError
from control.value import value

Floats = NDArray[np.float64]
Row = tuple[int, int, float, float, float, float, float]
"""Robots i and j, what h' takes of v_i, w_i, v_j and w_j, and the least h' [m/s]."""

_SWEEPS = 200
_EXACT = 1e-7  # by which a row may be missed [m/s]


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
def keep_apart(
    poses: Floats,
    twists: Floats,
    low: Floats,
    high: Floats,
    freedoms: Floats,
    clearance: Clearance,
    arena: Arena,
) -> Floats:
    """The nearest velocities under which bodies stay apart and inside.

    Args:
        poses: (N, 3) x, y, theta when the commands take effect [m, m, rad].
        twists: (N, 2) velocities that the wanted commands lead to; of robots nobody drives those
            they have [m/s, rad/s].
        low: (N, 2) least velocities that can be reached [m/s, rad/s].
        high: (N, 2) greatest velocities that can be reached [m/s, rad/s].
        freedoms: (N,) how easily a robot gives way: 0 for one that cannot be told to.
        clearance: what is kept, and how.
        arena: what must not be left.

    Returns:
        (N, 2) velocities [m/s, rad/s]; those of `twists`, to the last bit, if nothing is close.
    """
    rows = _rows(poses, twists, freedoms, clearance, arena)
    if _met(rows, twists):
        return twists
    for i in range(len(twists)):
        if freedoms[i] > 0.0:
            for k in range(2):
                on_v, on_w = 1.0 - k, float(k)
                rows.append((i, i, on_v, on_w, 0.0, 0.0, min(low[i, k], twists[i, k])))
                rows.append((i, i, -on_v, -on_w, 0.0, 0.0, -max(high[i, k], twists[i, k])))
    return _nearest(rows, twists, freedoms, clearance.arm)


@compilable
def _rows(
    poses: Floats, twists: Floats, freedoms: Floats, clearance: Clearance, arena: Arena
) -> list[Row]:
    """Conditions on all corners that could matter at these commands."""
    rows = [(0, 0, 0.0, 0.0, 0.0, 0.0, -1.0)]  # one that always holds: the list's type
    half = clearance.half_side
    for i in range(len(poses)):
        reach = _reach(twists, i, half)
        near = clearance.distance + 1.5 * half + reach / clearance.rate
        if freedoms[i] > 0.0 and not _inside(poses, i, arena, near):
            _add_borders(rows, poses, i, clearance, arena)
        for j in range(i):
            apart = hypot(poses[i, 0] - poses[j, 0], poses[i, 1] - poses[j, 1])
            closing = (reach + _reach(twists, j, half)) / clearance.rate
            if apart < clearance.distance + 3.0 * half + closing and freedoms[i] + freedoms[j] > 0:
                for corner in range(4):
                    rows.append(_corner_row(poses, i, j, corner, clearance))
                    rows.append(_corner_row(poses, j, i, corner, clearance))
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
def _corner(poses: Floats, i: int, corner: int, half: float) -> tuple[float, float]:
    """A corner seen from the body's centre, in floor axes [m, m]."""
    ahead = half if corner < 2 else -half
    left = half if corner % 2 == 0 else -half
    c, s = cos(poses[i, 2]), sin(poses[i, 2])
    return ahead * c - left * s, ahead * s + left * c


@compilable
def _corner_row(poses: Floats, i: int, j: int, corner: int, clearance: Clearance) -> Row:
    """A corner of i against the body of j."""
    half = clearance.half_side
    rx, ry = _corner(poses, i, corner, half)
    dx, dy = poses[i, 0] + rx - poses[j, 0], poses[i, 1] + ry - poses[j, 1]
    c, s = cos(poses[j, 2]), sin(poses[j, 2])
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
    ci, si = cos(poses[i, 2]), sin(poses[i, 2])
    least = -clearance.rate * max(h - clearance.distance, 0.0)
    return (
        i, j, nx * ci + ny * si, ny * rx - nx * ry, -nx * c - ny * s, nx * qy - ny * qx, least,
    )  # fmt: skip


@compilable
def _add_borders(
    rows: list[Row], poses: Floats, i: int, clearance: Clearance, arena: Arena
) -> None:
    """The circle about the body of i against the arena's sides: a body at a side may turn away."""
    x, y, c, s = poses[i, 0], poses[i, 1], cos(poses[i, 2]), sin(poses[i, 2])
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


@compilable
def _rate(row: Row, twists: Floats) -> float:
    """h' of a row [m/s]."""
    i, j, iv, iw, jv, jw, _ = row
    one = iv * twists[i, 0] + iw * twists[i, 1]
    return float(one + jv * twists[j, 0] + jw * twists[j, 1])


@compilable
def _met(rows: list[Row], twists: Floats) -> bool:
    for row in rows:  # noqa: SIM110 (the compiler knows no generator over a list)
        if _rate(row, twists) < row[6] - _EXACT:
            return False
    return True


@compilable
def _nearest(rows: list[Row], twists: Floats, freedoms: Floats, arm: float) -> Floats:
    """The least change that meets all rows, by Hildreth's method."""
    x, turning = twists.copy(), 1.0 / (arm * arm)
    pressed = np.zeros(len(rows))  # the multipliers
    for _ in range(_SWEEPS):
        moved = 0.0
        for k in range(len(rows)):
            i, j, iv, iw, jv, jw, least = rows[k]
            fi, fj = freedoms[i], freedoms[j]
            size = fi * (iv * iv + turning * iw * iw) + fj * (jv * jv + turning * jw * jw)
            if size == 0.0:
                continue
            press = max(pressed[k] + (least - _rate(rows[k], x)) / size, 0.0) - pressed[k]
            pressed[k] += press
            x[i, 0] += fi * press * iv
            x[i, 1] += fi * press * turning * iw
            x[j, 0] += fj * press * jv
            x[j, 1] += fj * press * turning * jw
            moved = max(moved, abs(press) * size)
        if moved < _EXACT:
            break
    return _slowed(rows, x, freedoms)


@compilable
def _slowed(rows: list[Row], twists: Floats, freedoms: Floats) -> Floats:
    """Where the sweeps have not ended: slower, with all it is near, until every row is met."""
    groups, shares = _groups(rows, freedoms), np.ones(len(twists))
    for row in rows:
        rate = _rate(row, twists)
        if rate < row[6] - 10.0 * _EXACT and rate < 0.0:
            group = groups[row[0] if freedoms[row[0]] > 0.0 else row[1]]
            shares[group] = min(shares[group], max(row[6] / rate, 0.0))
    for i in range(len(twists)):
        if freedoms[i] > 0.0:
            twists[i, 0] *= shares[groups[i]]
            twists[i, 1] *= shares[groups[i]]
    return twists


@compilable
def _groups(rows: list[Row], freedoms: Floats) -> NDArray[np.int64]:
    """Robots that are near each other, directly or by others, have the same number, (N,)."""
    groups = np.arange(len(freedoms))
    for _ in range(len(freedoms)):
        for row in rows:
            i, j = row[0], row[1]
            if freedoms[i] > 0.0 and freedoms[j] > 0.0:
                groups[i] = groups[j] = min(groups[i], groups[j])
    return groups
