"""The curves a plan can have: clamped B-splines between two ends, without equations."""

from dataclasses import dataclass
from math import cos, sin

import numpy as np
import scipy

from control.geometry import Pose2D
from control.motion_model import Array

DEGREE = 5
CONTROL_POINTS = 12

_FINE = 400  # places at which the cost is summed


@dataclass(frozen=True, slots=True)
class End:
    """What is fixed where a curve P(S) starts or ends.

    Attributes:
        pose: position, and the heading that derivatives are seen from [m, m, rad].
        along: P', P'', ... along the heading, as many as are fixed [m/s, m/s^2, ...].
        left: the same to its left [m/s, m/s^2, ...].
    """

    pose: Pose2D
    along: tuple[float, ...]
    left: tuple[float, ...]


def spline_basis(end: float) -> "scipy.interpolate.BSpline":
    """Basis functions of a clamped spline with even knots.

    Args:
        end: of the spline, which starts at 0 [s].

    Returns:
        A spline with a component for each of the c control points.
    """
    inner = np.linspace(0.0, end, CONTROL_POINTS - DEGREE + 1)
    knots = np.concatenate((np.zeros(DEGREE), inner, np.full(DEGREE, end)))
    return scipy.interpolate.BSpline(knots, np.eye(CONTROL_POINTS), DEGREE)


def curves_between(
    ends: tuple[End, End], spline: "scipy.interpolate.BSpline", length: float
) -> tuple[Array, Array]:
    """All curves between two ends, as control points best + directions w that cost |w|^2 more.

    The cost is the integral of |P'''|^2, over what the way takes from rest to rest.

    Args:
        ends: of the curves.
        spline: its basis functions.
        length: of the way, roughly [m].

    Returns:
        The best curve that only the ends constrain (2, c), and directions (2, c, m) [m].
    """
    end = float(spline.t[-1])
    places = zip(ends, (0.0, end), strict=True)
    fixed = [row for what, at in places for row in _fixed(what, spline, at)]
    rows, values = np.array([row for row, _ in fixed]), np.array([value for _, value in fixed])
    whole, upper = np.linalg.qr(rows.T, mode="complete")
    bound, free = whole[:, : len(values)], whole[:, len(values) :]
    best = bound @ np.linalg.solve(upper[: len(values)].T, values)
    scale = (end**6 / (720.0 * length**2 * _FINE)) ** 0.5
    third = scale * spline((np.arange(_FINE) + 0.5) * (end / _FINE), 3)
    weight = np.kron(np.eye(2), third.T @ third)
    root = np.linalg.cholesky(free.T @ weight @ free)
    directions = np.linalg.solve(root, free.T).T
    best = best - directions @ (directions.T @ weight @ best)
    return best.reshape(2, -1), directions.reshape(2, CONTROL_POINTS, -1)


def _fixed(end: End, spline: "scipy.interpolate.BSpline", at: float) -> list[tuple[Array, float]]:
    """Rows and values of what an end fixes, on x and y of the control points."""
    c, s = cos(end.pose.theta), sin(end.pose.theta)
    place = [((1.0, 0.0), 0, end.pose.x), ((0.0, 1.0), 0, end.pose.y)]
    along = [((c, s), order, value) for order, value in enumerate(end.along, 1)]
    left = [((-s, c), order, value) for order, value in enumerate(end.left, 1)]
    return [
        (np.kron(direction, spline(at, order)), value)
        for direction, order, value in (*place, *along, *left)
    ]
