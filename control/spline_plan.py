"""A plan that was found: a spline along a time law, with what it leaves of every limit."""

from dataclasses import dataclass, field
from math import atan2, inf, pi

import numpy as np
from scipy.interpolate import BSpline

from control.flatness import leader_rows, shape
from control.motion_model import Array
from control.plan import PlannedMotion
from control.plan_problem import knots, read_only
from control.plan_request import Resolution
from control.time_law import TimeLaw
from control.unicycle import UnicycleState


@dataclass(frozen=True, slots=True)
class Margin:
    """How close a plan comes to one of its constraints.

    Attributes:
        name: of the constraint.
        value: a share of a limit, at most 1 [1]; or a distance beyond the wanted one [m].
        t: when, on the mission's clock [s].
    """

    name: str
    value: float
    t: float


@dataclass(frozen=True, slots=True, eq=False)
class SplinePlan:
    """A plan p(t) = P(S(t)), flat in (x, y): theta = atan2(y', x'), v = |p'|.

    Before its start it gives the motion of the start. After its end the robot stands at the goal
    if the goal's speed is 0, else it goes straight on at that speed.

    Attributes:
        control_points: (c, 2) of the clamped spline P, on the floor [m]; read-only.
        law: S.
        resolution: degree of the spline, and the nodes at which it was collocated.
        heading: at the start, not wrapped [rad].
        t_start: on the mission's clock [s].
        shares: of every limit, the greatest that the plan uses [1].
        gaps: to every obstacle and border, the least beyond the clearance [m].
    """

    control_points: Array
    law: TimeLaw
    resolution: Resolution
    heading: float
    t_start: float
    shares: tuple[Margin, ...] = ()
    gaps: tuple[Margin, ...] = ()
    _curves: tuple[BSpline, ...] = field(init=False, repr=False)
    _headings: tuple[Array, Array] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        read_only(self.control_points)
        breaks = knots(self.law, self.resolution)
        curve = BSpline(breaks, self.control_points, self.resolution.degree)
        object.__setattr__(self, "_curves", tuple(curve.derivative(i) for i in range(4)))
        s = np.linspace(0.0, breaks[-1], 10 * self.resolution.nodes)
        along = self._curves[1](s)
        headings = np.unwrap(np.arctan2(along[:, 1], along[:, 0]))
        turns = round((self.heading - headings[0]) / (2.0 * pi))
        object.__setattr__(self, "_headings", (s, headings + 2.0 * pi * turns))

    @property
    def duration(self) -> float:
        """Time from start to goal [s]."""
        return self.law.duration

    @property
    def clearance(self) -> float:
        """Least distance to an obstacle or border beyond the clearance; inf without any [m]."""
        return min((gap.value for gap in self.gaps), default=inf)

    def at(self, t: float) -> PlannedMotion:
        """Wanted motion at a time, in closed form.

        Args:
            t: time on the mission's clock [s].

        Returns:
            Wanted state and accelerations; v >= 0, the heading is not wrapped.
        """
        law, (p, p1, p2, p3) = self._along(np.array([t]))
        v, omega, v_rate, omega_rate = leader_rows(shape(p1, p2, p3), law)[:, 0, 0].tolist()
        if t > self.t_start + self.duration:
            omega, v_rate, omega_rate = 0.0, 0.0, 0.0
        x, y = p[:, 0].tolist()
        theta = self._unwrapped(atan2(p1[1, 0], p1[0, 0]), float(law[0, 0]))
        return PlannedMotion(UnicycleState(x, y, theta, v, omega), v_rate, omega_rate)

    def positions(self, t: Array) -> Array:
        """Wanted positions at many times.

        Args:
            t: (n,) times on the mission's clock [s].

        Returns:
            (2, n) positions on the floor [m].
        """
        positions: Array = self._along(t)[1][0]
        return positions

    def derivatives(self, s: Array) -> Array:
        """The curve and its derivatives for S.

        Args:
            s: (n,) places on the curve, from 0 to S at the end [s].

        Returns:
            (4, 2, n): P, P', P'', P''' [m, m/s, m/s^2, m/s^3].
        """
        return np.array([curve(s).T for curve in self._curves])

    def _along(self, t: Array) -> tuple[Array, Array]:
        """(4, n) S and (4, 2, n) the curve, with derivatives; straight on behind the end."""
        since = t - self.t_start
        law = self.law.at(np.clip(since, 0.0, self.duration))
        curve = self.derivatives(law[0])
        curve[0] += np.maximum(since - self.duration, 0.0) * law[1] * curve[1]
        return law, curve

    def _unwrapped(self, heading: float, s: float) -> float:
        """The heading with the turns that the curve has made so far."""
        near = float(np.interp(s, *self._headings))
        return heading + 2.0 * pi * round((near - heading) / (2.0 * pi))
