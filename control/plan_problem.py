"""The planner's problem on a mesh: variables without equations, cost, constraints, Jacobians."""

from dataclasses import dataclass
from math import cos, sin

import numpy as np
from scipy.interpolate import BSpline
from scipy.linalg import cholesky, qr, solve_triangular

from control.motion_model import Array
from control.plan_request import Resolution
from control.time_law import TimeLaw


def read_only(*arrays: Array) -> None:
    """Keep values from being changed.

    Args:
        *arrays: to lock.
    """
    for array in arrays:
        array.flags.writeable = False


@dataclass(frozen=True, slots=True)
class End:
    """What is fixed where a curve starts or ends.

    Attributes:
        position: [m, m].
        heading: direction of the first derivative [rad].
        pace: |P'|, > 0 [m/s].
        rush: P'' along the heading; None leaves it open [m/s^2].
        bend: P'' to the left of the heading [m/s^2].
    """

    position: tuple[float, float]
    heading: float
    pace: float
    rush: float | None = None
    bend: float = 0.0


@dataclass(frozen=True, slots=True)
class Mesh:
    """Times, and what the spline's basis is there; read-only.

    Attributes:
        t: (n,) from 0 to the duration [s].
        law: (4, n) S and its derivatives.
        basis: (4, n, c) basis functions and their derivatives for S.
    """

    t: Array
    law: Array
    basis: Array

    def __post_init__(self) -> None:
        read_only(self.t, self.law, self.basis)


def knots(law: TimeLaw, resolution: Resolution) -> Array:
    """Clamped, evenly spaced knots over all of S.

    Args:
        law: its S at the end is the end of the curve.
        resolution: degree and number of control points.

    Returns:
        (control points + degree + 1,) knots [s].
    """
    degree, end = resolution.degree, float(law.at(np.array([law.duration]))[0, 0])
    inner = np.linspace(0.0, end, resolution.control_points - degree + 1)
    return np.concatenate((np.zeros(degree), inner, np.full(degree, end)))


def mesh(law: TimeLaw, resolution: Resolution, nodes: int) -> Mesh:
    """Evenly spaced times with the basis of a plan's curve.

    Args:
        law: the plan's time law.
        resolution: of its curve.
        nodes: number of times.

    Returns:
        The mesh.
    """
    t = np.linspace(0.0, law.duration, nodes)
    s, breaks = law.at(t), knots(law, resolution)
    s[0] = np.clip(s[0], 0.0, breaks[-1])  # the last bits of an integral
    spline = BSpline(breaks, np.eye(resolution.control_points), resolution.degree)
    return Mesh(t, s, np.array([spline(s[0], order) for order in range(4)]))


@dataclass(frozen=True, slots=True)
class Space:
    """All curves between two ends: control points = best + directions w, cost = least + |w|^2.

    Attributes:
        best: (2, c) control points of the cheapest curve that only the ends constrain [m].
        directions: (2, c, m) of the free variables w.
        least: cost of the best curve.

    Both arrays are read-only.
    """

    best: Array
    directions: Array
    least: float

    def __post_init__(self) -> None:
        read_only(self.best, self.directions)

    def curve(self, w: Array) -> Array:
        """Control points.

        Args:
            w: (m,) variables.

        Returns:
            (2, c) control points [m].
        """
        points: Array = self.best + self.directions @ w
        return points

    def nearest(self, basis: Array, points: Array, tolerance: float) -> Array:
        """Variables of the curve near points that weighs closeness against its cost.

        Args:
            basis: (n, c) basis functions at the points' times.
            points: (2, n) wanted positions [m].
            tolerance: an rms distance that weighs as much as a cost of 1 [m].

        Returns:
            (m,) variables.
        """
        reach = (basis @ self.directions).reshape(-1, self.directions.shape[2])
        off = (points - self.best @ basis.T).ravel()
        weight = 1.0 / (len(basis) * tolerance**2)
        normal = weight * (reach.T @ reach) + np.eye(reach.shape[1])
        return np.asarray(np.linalg.solve(normal, weight * (reach.T @ off)), dtype=float)


def space(fine: Mesh, ends: tuple[End, End], scale: float) -> Space:
    """The variables of a problem: the ends eliminated, the cost made a plain square.

    The cost is the integral of squared jerk, plus squared acceleration over duration^2.

    Args:
        fine: the mesh of the integral.
        ends: of the curve.
        scale: what the cost is divided by [m^2/s^5].

    Returns:
        The space of curves.
    """
    count = fine.basis.shape[2]
    rows, values = _equations(fine, ends)
    whole, upper = qr(rows.T)
    fixed = len(values)
    particular = whole[:, :fixed] @ solve_triangular(upper[:fixed], values, trans="T")
    free = whole[:, fixed:]
    weight = np.kron(np.eye(2), _cost(fine) / scale)
    root = cholesky(free.T @ weight @ free, lower=True)
    step = solve_triangular(root, free.T @ weight @ particular, lower=True)
    directions = solve_triangular(root, free.T, lower=True).T
    best = particular - directions @ step
    least = float(best @ weight @ best)
    return Space(best.reshape(2, count), directions.reshape(2, count, -1), least)


def _cost(fine: Mesh) -> Array:
    """(c, c) form of the cost, by trapezoids."""
    _, s1, s2, s3 = fine.law[:, :, None]
    _, b1, b2, b3 = fine.basis
    jerk = b3 * s1**3 + 3.0 * b2 * s1 * s2 + b1 * s3
    acceleration = (b2 * s1**2 + b1 * s2) / fine.t[-1]
    weights = np.full((len(fine.t), 1), fine.t[1])
    weights[[0, -1]] *= 0.5
    form: Array = jerk.T @ (weights * jerk) + acceleration.T @ (weights * acceleration)
    return form


def _equations(fine: Mesh, ends: tuple[End, End]) -> tuple[Array, Array]:
    """Rows and values of what the ends fix, on x and y of the control points."""
    both = zip(ends, (0, -1), strict=True)
    fixed = [row for end, at in both for row in _fixed(end, fine.basis[:3, at])]
    return np.array([row for row, _ in fixed]), np.array([value for _, value in fixed])


def _fixed(end: End, basis: Array) -> list[tuple[Array, float]]:
    place, first, second = basis
    c, s = cos(end.heading), sin(end.heading)
    wanted = (
        (place, (1.0, 0.0), end.position[0]),
        (place, (0.0, 1.0), end.position[1]),
        (first, (-s, c), 0.0),
        (first, (c, s), end.pace),
        (second, (-s, c), end.bend),
        (second, (c, s), end.rush),
    )
    return [
        (np.concatenate((dx * row, dy * row)), value)
        for row, (dx, dy), value in wanted
        if value is not None
    ]
