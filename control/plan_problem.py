"""The planner's problem for a given time law: curves, and what they must keep, with Jacobians.

Every constraint is a named share that must not exceed 1: a velocity over its limit; for
distances 1 plus what lacks, over the length of the way.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from control.flatness import in_time, motion, motion_gradient, point_motion
from control.motion_model import Array
from control.obstacles import borders
from control.plan_curves import End, curves_between, spline_basis
from control.plan_request import PlanRequest
from control.time_law import TimeLaw

NODES = 41
"""Even times at which constraints are collocated."""

FINER = 10
"""The constraints are checked at so many times the intervals of the nodes."""

TURNING_BACK = "pace"
"""Name of the share of curves that all but stop on the way."""

_SLOWEST = 0.1  # of the usual pace: slower, a curve may turn back on itself
_LEAST = 1e-9  # of distances, which have no direction at 0 [m]

Row = tuple[str, Array]


@dataclass(frozen=True, slots=True)
class Problem:
    """A request whose time law and ends are decided, at n times.

    Attributes:
        request: as asked.
        law: of the time.
        length: of the way, roughly [m].
        curves: to choose from, by m variables w: best (2, c) and directions (2, c, m) [m].
        t: (n,) times since the start [s].
        constant: (4, 2, n) P, P', P'', P''' for w = 0 [m, s].
        linear: (4, 2, n, m) their derivatives for w [m, s].
    """

    request: PlanRequest
    law: TimeLaw
    length: float
    curves: tuple[Array, Array]
    t: Array
    constant: Array
    linear: Array

    def at(self, chosen: NDArray[np.bool_]) -> "Problem":
        """The same problem at some of its times.

        Args:
            chosen: (n,) which.

        Returns:
            The smaller problem.
        """
        constant, linear = self.constant[:, :, chosen], self.linear[:, :, chosen]
        return replace(self, t=self.t[chosen], constant=constant, linear=linear)

    def derivatives(self, w: Array) -> Array:
        """P and its derivatives for S.

        Args:
            w: (m,) variables.

        Returns:
            (4, 2, n) [m, m/s, m/s^2, m/s^3].
        """
        derivatives: Array = self.constant + self.linear @ w
        return derivatives

    def names(self) -> list[str]:
        """What the shares are of.

        Returns:
            (r,) names.
        """
        p = self.constant
        return [name for name, _ in (*self._limits(motion(*p[1:])), *self._distances(p[0]))]

    def shares(self, w: Array) -> Array:
        """All shares.

        Args:
            w: (m,) variables.

        Returns:
            (r, n) shares, at most 1 where the curve keeps its limits [1].
        """
        p = self.derivatives(w)
        rows = *self._limits(motion(*p[1:])), *self._distances(p[0])
        return np.array([row[0] for _, row in rows])

    def jacobian(self, w: Array) -> Array:
        """Derivatives of all shares.

        Args:
            w: (m,) variables.

        Returns:
            (r, n, m) derivatives for the variables [1].
        """
        p = self.derivatives(w)
        gradient = np.einsum("qkxn,kxnm->qnm", motion_gradient(*p[1:]), self.linear[1:])
        limits = [(row[1:], gradient) for _, row in self._limits(motion(*p[1:]))]
        distances = [(row[1:], self.linear[0]) for _, row in self._distances(p[0])]
        return np.array([np.einsum("xn,xnm->nm", *pair) for pair in (*limits, *distances)])

    def _limits(self, along: Array) -> Iterator[Row]:
        """(5, n) rows: a share, then its derivatives for the motion along the curve."""
        limits, (_, pace, slope) = self.request.limits, self.law.at(self.t)
        units = np.broadcast_to(np.eye(4)[:, :, None], (4, *along.shape))
        rows = np.concatenate((along[:, None], units), axis=1)
        v, omega, v_rate, omega_rate = in_time(rows, pace, slope)
        slowness = rows[0] * (-self.law.end / self.length)
        slowness[0] += 1.0 + _SLOWEST
        yield TURNING_BACK, slowness
        yield "speed", v / limits.v
        yield from _both("turning rate", omega / limits.omega)
        yield from _both("acceleration", v_rate / limits.v_rate)
        yield from _both("angular acceleration", omega_rate / limits.omega_rate)
        for place in self.request.places:
            speed, turn = point_motion(along, place.x, place.y)
            half = 0.5 * place.track_width
            for rim in (speed + half * turn, speed - half * turn):
                name = f"wheel speed of the follower at ({place.x:g}, {place.y:g}) m"
                yield name, pace * rim / place.wheel_speed

    def _distances(self, p: Array) -> Iterator[Row]:
        """(3, n) rows: a share, then its derivatives for x and y."""
        request = self.request
        for o in request.obstacles:
            apart = o.apart(p, self.t)
            distance = np.maximum(np.hypot(*apart), _LEAST)
            away = apart / distance
            row = self._closeness(distance - o.radius, away)
            yield f"distance to the obstacle at ({o.x:g}, {o.y:g}) m", row
        for name, inward, at in borders(request.arena):
            normal = np.array(inward)[:, None]
            row = self._closeness((normal * p).sum(axis=0) - at, normal + np.zeros_like(p))
            yield f"distance to {name}", row

    def _closeness(self, distance: Array, gradient: Array) -> Array:
        """A share from a distance [m] and its derivatives for x and y [1]."""
        share = 1.0 + (self.request.clearance - distance) / self.length
        return np.array([share, *(gradient / -self.length)])


def problem(request: PlanRequest, ends: tuple[End, End], law: TimeLaw, length: float) -> Problem:
    """The problem of a request on a mesh FINER than its nodes.

    Args:
        request: as asked.
        ends: of the curve.
        law: of the time.
        length: of the way, roughly [m].

    Returns:
        The problem.
    """
    spline = spline_basis(law.end)
    best, directions = curves = curves_between(ends, spline, length)
    t = np.linspace(0.0, law.duration, FINER * (NODES - 1) + 1)
    s = law.at(t)[0]
    basis = np.array([spline(s, order) for order in range(4)])
    constant, linear = best @ basis.transpose(0, 2, 1), basis[:, None] @ directions
    return Problem(request, law, length, curves, t, constant, linear)


def _both(name: str, row: Array) -> tuple[Row, Row]:
    """A limit of either sign."""
    return (name, row), (name, -row)
