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

import numpy as np
from numpy.typing import NDArray

from control.barriers import Arena as Arena
from control.barriers import Clearance as Clearance
from control.barriers import Floats as Floats
from control.barriers import Row, corner_rows
from control.compilable import compilable

_SWEEPS = 200
_EXACT = 1e-7  # by which a row may be missed [m/s]


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
    rows = corner_rows(poses, twists, freedoms, clearance, arena)
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
    sizes = np.array([_size(row, freedoms, turning) for row in rows])
    for _ in range(_SWEEPS):
        moved = 0.0
        for k in range(len(rows)):
            size, (i, j, iv, iw, jv, jw, least) = sizes[k], rows[k]
            missing = least - _rate(rows[k], x)
            if size == 0.0 or (missing <= 0.0 and pressed[k] == 0.0):
                continue
            press = max(pressed[k] + missing / size, 0.0) - pressed[k]
            pressed[k] += press
            fi, fj = freedoms[i], freedoms[j]
            x[i, 0] += fi * press * iv
            x[i, 1] += fi * press * turning * iw
            x[j, 0] += fj * press * jv
            x[j, 1] += fj * press * turning * jw
            moved = max(moved, abs(press) * size)
        if moved < _EXACT:
            break
    return _slowed(rows, x, freedoms)


@compilable
def _size(row: Row, freedoms: Floats, turning: float) -> float:
    """How much a row's rate gains by being pressed."""
    i, j, iv, iw, jv, jw, _ = row
    one = freedoms[i] * (iv * iv + turning * iw * iw)
    return float(one + freedoms[j] * (jv * jv + turning * jw * jw))


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
