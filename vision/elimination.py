"""One Gauss-Newton step of the pose fit, with the brightnesses of the tag's parts eliminated.

A sample shows b_K + sum over the K parts of v_k (b_k - b_K): coverages v times brightnesses b, of
which the last is that of the floor around the tag. The brightnesses are linear unknowns; they are
solved exactly and projected out of the pose's normal equations (variable projection, Golub and
Pereyra 1973). The unknowns are called a: a_0 = b_K, a_k = b_(k-1) - b_K.

Samples stand in the columns of a table, one row per quantity, so that a processor takes 8 at a
time: PLACE x, y; WEIGHT, its root; from COVERS on the K coverages, their K slopes along x and K
along y, the C values, and 4 rows to work in. From WEIGHT on all are multiplied by the weight's
root. Lengths are in cells of the template.
"""

import numpy as np
from numpy.typing import NDArray

from vision.compiled import compiled_part

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]

PLACE, WEIGHT, COVERS = 0, 2, 3
_RIDGE = 1e-3  # samples of brightness 0 for every unknown: keeps parts out of sight solvable
_FADE, _FADE_FROM = np.float32(0.03), np.float32(0.999)  # weight: 1 on the tag, 0 outside
_RING, _LEAST_RING = np.float32(0.985), 8  # samples that see as much of the floor, at least
_NONE, _ALL = np.float32(0.0), np.float32(1.0)


@compiled_part
def look_up(
    cells: Singles, cell: float, pose: Floats, places: Singles, values: Singles, noise: Floats,
    count: int, table: Singles,
) -> None:  # fmt: skip
    """Fill the table with what a template says of samples.

    Args:
        cells: shape (n, n, K), of one template.
        cell: side of a cell [m].
        pose: shape (3,), of the tag relative to the places' origin [m, m, rad].
        places: shape (2, N), floor points of the samples, x and y [m].
        values: shape (C or more, N), what the samples show.
        noise: shape (C,), its standard deviation [grey levels].
        count: number of samples.
        table: shape (3 + 3 K + C + 4, N).
    """
    parts, channels = cells.shape[2], len(noise)
    _place(cells.shape[0], cell, pose, places, count, table)
    weight = table[WEIGHT]
    for i in range(count):
        weight[i] = _ALL
    for k in range(parts):
        _interpolate(cells, k, count, table)
        covers = table[COVERS + k]
        for i in range(count):
            weight[i] -= covers[i]
    uneven = np.float32(_unevenness(weight, values, noise, count))
    for i in range(count):
        seen = weight[i]  # of the floor around, up to 0.999
        fade = min(max((_FADE_FROM - seen) / _FADE, _NONE), _ALL)
        weight[i] = np.sqrt(fade / (_ALL + uneven * seen * seen))
    for row in range(COVERS, COVERS + 3 * parts):
        covers = table[row]
        for i in range(count):
            covers[i] *= weight[i]
    for channel in range(channels):
        shown, own = table[COVERS + 3 * parts + channel], values[channel]
        for i in range(count):
            shown[i] = weight[i] * own[i]


@compiled_part
def _place(n: int, cell: float, pose: Floats, places: Singles, count: int, table: Singles) -> None:
    """Turn floor points into the tag's frame [cells]; work rows: first cell, and place in it."""
    c, s = np.float32(np.cos(pose[2]) / cell), np.float32(np.sin(pose[2]) / cell)
    x0, y0 = np.float32(pose[0]), np.float32(pose[1])
    middle, last = np.float32(n // 2), np.float32(n - 1.001)
    x, y = table[PLACE], table[PLACE + 1]
    first, across, along = table[-3], table[-2], table[-1]
    for i in range(count):
        dx, dy = places[0, i] - x0, places[1, i] - y0
        x[i], y[i] = c * dx + s * dy, c * dy - s * dx
    for i in range(count):
        p = min(last, max(_NONE, x[i] + middle))  # nan becomes 0
        q = min(last, max(_NONE, y[i] + middle))
        column, row = np.int32(p), np.int32(q)
        across[i], along[i] = p - np.float32(column), q - np.float32(row)
        first[i] = np.float32(row * n + column)  # exact up to 2^24


@compiled_part
def _interpolate(cells: Singles, part: int, count: int, table: Singles) -> None:
    """Coverage of a part and its slopes [1/cell], interpolated linearly between four cells."""
    n, parts = cells.shape[0], cells.shape[2]
    flat = cells.reshape(-1)
    covers = table[COVERS + part]
    slope_x, slope_y = table[COVERS + parts + part], table[COVERS + 2 * parts + part]
    first, across, along = table[-3], table[-2], table[-1]
    for i in range(count):
        at = np.int64(first[i]) * parts + part
        one, two = flat[at], flat[at + parts]
        three, four = flat[at + n * parts], flat[at + n * parts + parts]
        step, twist = two - one, (four - three) - (two - one)
        slope = (three - one) + across[i] * twist
        covers[i] = one + across[i] * step + along[i] * slope
        slope_x[i], slope_y[i] = step + along[i] * twist, slope


@compiled_part
def _unevenness(outside: Singles, values: Singles, noise: Floats, count: int) -> float:
    """Variance of the floor around the tag, as seen in a ring outside its edge, over the noise's.

    Lines, shadows and neighbours around the tag count as noise in proportion to what of them a
    sample sees.
    """
    worst = 0.0
    for channel in range(len(noise)):
        own, number, total, squares = values[channel], 0, 0.0, 0.0
        for i in range(count):
            if outside[i] > _RING:
                number += 1
                total += own[i]
                squares += own[i] * own[i]
        if number >= _LEAST_RING:
            variance = (squares - total * total / number) / number
            worst = max(worst, variance / noise[channel] ** 2 - 1.0)
    return worst


@compiled_part
def dot(one: Singles, other: Singles, count: int) -> float:
    """Sum of products.

    Args:
        one: shape (N,).
        other: shape (N,).
        count: of the first elements.

    Returns:
        The sum.
    """
    total = _NONE
    for i in range(count):
        total += one[i] * other[i]
    return float(total)


@compiled_part
def solve_brightness(
    table: Singles, count: int, parts: int, channels: int, inner: Floats, bright: Floats
) -> None:
    """Solve for the brightnesses that explain the samples best.

    Args:
        table: of the samples.
        count: number of samples.
        parts: K.
        channels: C.
        inner: shape (3, K + 1, K + 1), receives the inverse of the brightnesses' normal matrix as
            its first member.
        bright: shape (C or more, K + 1), receives the unknowns a.
    """
    inverse, normal, moment = inner[0], inner[1], inner[2, 0]
    for k in range(parts + 1):
        for j in range(k + 1):
            normal[k, j] = normal[j, k] = dot(table[WEIGHT + k], table[WEIGHT + j], count)
        normal[k, k] += _RIDGE
    invert(normal, inverse)
    for channel in range(channels):
        shown = table[COVERS + 3 * parts + channel]
        for k in range(parts + 1):
            moment[k] = dot(table[WEIGHT + k], shown, count)
        for k in range(parts + 1):
            bright[channel, k] = 0.0
            for j in range(parts + 1):
                bright[channel, k] += inverse[k, j] * moment[j]


@compiled_part
def accumulate(
    table: Singles, count: int, parts: int, channel: int, inverse: Floats, bright: Floats,
    normal: Floats, gradient: Floats,
) -> tuple[float, float]:  # fmt: skip
    """Sum up the pose's normal equations for one channel and eliminate the brightnesses.

    Args:
        table: of the samples.
        count: number of samples.
        parts: K.
        channel: of the values.
        inverse: shape (K + 1, K + 1), see `solve_brightness`.
        bright: shape (K + 1,), the channel's unknowns a.
        normal: shape (3, 3), receives J^T J without what brightnesses explain; J of a step
            forward, a step left [1/cell] and a turn [1/rad].
        gradient: shape (3,), receives J^T of the residuals.

    Returns:
        Sum of the squared residuals; squared slope of the picture, summed [1/cell^2].
    """
    _differentiate(table, count, parts, channel, bright)
    shared = np.zeros((3, parts + 1))
    for j in range(3):
        step = table[j - 3]
        gradient[j] = dot(step, table[-4], count)
        for k in range(j + 1):
            normal[j, k] = normal[k, j] = dot(step, table[k - 3], count)
        for k in range(parts + 1):
            shared[j, k] = dot(step, table[WEIGHT + k], count)
    slope = normal[0, 0] + normal[1, 1]
    for j in range(3):
        for p in range(parts + 1):
            explained = 0.0
            for q in range(parts + 1):
                explained += inverse[p, q] * shared[j, q]
            for k in range(3):
                normal[j, k] -= explained * shared[k, p]
    return dot(table[-4], table[-4], count), slope


@compiled_part
def _differentiate(table: Singles, count: int, parts: int, channel: int, bright: Floats) -> None:
    """Residuals and the picture's derivatives by forward, left and turn, into the work rows."""
    residual, ahead, aside, turn = table[-4], table[-3], table[-2], table[-1]
    shown, weight = table[COVERS + 3 * parts + channel], table[WEIGHT]
    floor = np.float32(bright[0])
    for i in range(count):
        residual[i] = shown[i] - floor * weight[i]
        ahead[i] = aside[i] = _NONE
    for k in range(parts):
        own = np.float32(bright[k + 1])
        covers, slope_x = table[COVERS + k], table[COVERS + parts + k]
        slope_y = table[COVERS + 2 * parts + k]
        for i in range(count):
            residual[i] -= own * covers[i]
            ahead[i] -= own * slope_x[i]
            aside[i] -= own * slope_y[i]
    x, y = table[PLACE], table[PLACE + 1]
    for i in range(count):
        turn[i] = x[i] * aside[i] - y[i] * ahead[i]


@compiled_part
def part_colors(bright: Floats, separate: bool, colors: Floats) -> None:
    """Turn brightnesses into colours.

    Args:
        bright: shape (3, K + 1), unknowns a of B, G and R, or of luma, blue and red chroma.
        separate: whether they are those of B, G and R.
        colors: shape (K + 1, 3), receives BGR of the parts, and of the floor last.
    """
    parts = len(colors) - 1
    for k in range(parts + 1):
        one, two, three = bright[0, 0], bright[1, 0], bright[2, 0]
        if k < parts:
            one, two = one + bright[0, k + 1], two + bright[1, k + 1]
            three = three + bright[2, k + 1]
        if separate:
            colors[k, 0], colors[k, 1], colors[k, 2] = one, two, three
        else:  # luma, blue and red chroma
            colors[k, 0], colors[k, 2] = one + 1.772 * two, one + 1.402 * three
            colors[k, 1] = one - 0.344136 * two - 0.714136 * three


@compiled_part
def invert(matrix: Floats, inverse: Floats) -> None:
    """Invert a symmetric positive definite matrix by Gauss and Jordan's elimination.

    Args:
        matrix: shape (M, M); is used up.
        inverse: shape (M, M), receives the inverse.
    """
    count = len(matrix)
    for k in range(count):
        for j in range(count):
            inverse[k, j] = 1.0 if j == k else 0.0
    for k in range(count):
        pivot = 1.0 / matrix[k, k]
        for j in range(count):
            matrix[k, j] *= pivot
            inverse[k, j] *= pivot
        for i in range(count):
            factor = matrix[i, k]
            if i != k:
                for j in range(count):
                    matrix[i, j] -= factor * matrix[k, j]
                    inverse[i, j] -= factor * inverse[k, j]
