"""Maxima of smooth measures over a box: a grid, steps uphill, then bounded optimisation.

Found, not proved. A maximum that has many rivals is found because every value of the last
coordinate (an angle, in what this is for) sends its own best point uphill, and a step may go to the
other end of a range at once.
"""

from collections.abc import Callable, Iterator
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from control.nominal import FloatArray

Measures: TypeAlias = Callable[[FloatArray], FloatArray]
"""(D, N) points -> (M, N) values, all of them finite."""

CLIMB = 30
"""Steps uphill from the best point of the grid for every value of the last coordinate."""

STARTS = 2
"""Best points after the climb, from which each maximum is refined."""

STEP = 1e-6
"""Of finite differences, as a share of a range."""


def maxima(measures: Measures, box: FloatArray, levels: NDArray[np.int64]) -> list[float]:
    """Greatest value of each measure over a box.

    Args:
        measures: what to maximise.
        box: (D, 2) ranges; some may be single values.
        levels: (D,) of the grid, >= 2, for every range.

    Returns:
        M values, each reached by a point of the box.
    """

    def shares(unit: FloatArray) -> FloatArray:
        return measures(box[:, :1] + (box[:, 1:] - box[:, :1]) * unit)

    moving = np.flatnonzero(box[:, 1] > box[:, 0])
    grid = _layers(np.where(box[:, 1] > box[:, 0], levels, 1))
    best = np.stack([layer[:, shares(layer).argmax(axis=1)] for layer in grid], axis=2)
    tops = [_climbed(shares, j, best[:, j], moving) for j in range(best.shape[1])]
    return [_refined(shares, j, top) for j, top in enumerate(tops)]


def _layers(levels: NDArray[np.int64]) -> Iterator[FloatArray]:
    """The grid in shares of the ranges, (D, N) for every value of the last coordinate."""
    axes = [np.linspace(0.0, 1.0, n) for n in levels]
    grid = np.stack(np.meshgrid(*axes[:-1], [0.0], indexing="ij")).reshape(len(axes), -1)
    for value in axes[-1]:
        grid[-1] = value
        yield grid


def _climbed(
    measures: Measures, j: int, points: FloatArray, moving: NDArray[np.intp]
) -> FloatArray:
    """(D, H) points after steps uphill for measure j: to an end of a range or along it."""
    step, each = 0.25, np.arange(points.shape[1])
    for _ in range(CLIMB):
        around = np.repeat(points[:, :, None], 4 * len(moving) + 1, axis=2)
        for k, i in enumerate(moving):
            for n, place in enumerate((0.0, 1.0, points[i] - step, points[i] + step)):
                around[i, :, 4 * k + n] = np.clip(place, 0.0, 1.0)
        values = measures(around.reshape(len(points), -1))[j].reshape(around.shape[1:])
        points = around[:, each, values.argmax(axis=1)]
        step *= 0.8
    return points


def _refined(measures: Measures, j: int, points: FloatArray) -> float:
    """Greatest value of measure j near the best of some points (D, H)."""
    reached = measures(points)[j]
    best = np.argsort(-reached)[:STARTS]
    step, bounds = STEP * np.eye(len(points)), [(0.0, 1.0)] * len(points)

    def downhill(unit: FloatArray) -> tuple[float, FloatArray]:
        ahead, behind = np.minimum(unit + step, 1.0), np.maximum(unit - step, 0.0)
        values = measures(np.concatenate([unit[:, None], ahead.T, behind.T], axis=1))[j]
        up, down = np.split(values[1:], 2)
        return -float(values[0]), (down - up) / np.diagonal(ahead - behind)

    # TNC: no linear algebra library, whose threads cost more than the work
    found = [minimize(downhill, points[:, k], jac=True, method="TNC", bounds=bounds) for k in best]
    return max(float(reached.max()), *(-float(result.fun) for result in found))
