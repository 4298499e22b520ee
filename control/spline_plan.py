"""A plan that was found: a spline along a time law."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from math import atan2, cos, inf, pi, sin

import numpy as np
import scipy

from control.actuation import require_finite
from control.flatness import in_time, motion
from control.motion_model import Array
from control.obstacles import Obstacle
from control.plan import PlannedMotion
from control.plan_curves import DEGREE, End, spline_basis
from control.time_law import TimeLaw
from control.unicycle import UnicycleState

_FINE = 401  # places along a plan at which headings and distances are taken


@dataclass(frozen=True, slots=True, eq=False)
class SplinePlan:
    """A plan p(t) = P(S(t)), flat in (x, y): theta = atan2(y', x'), v = |p'|.

    Before its start it gives the motion of the start. After its end the robot stands at the goal
    if the goal's speed is 0, else it goes straight on at that speed.

    Attributes:
        control_points: (c, 2) of the clamped spline P, on the floor [m]; read-only.
        law: S.
        heading: at the start, not wrapped [rad].
        t_start: on the mission's clock [s].
    """

    control_points: Array
    law: TimeLaw
    heading: float
    t_start: float
    _curves: tuple["scipy.interpolate.BSpline", ...] = field(init=False, repr=False)
    _headings: tuple[Array, Array] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self.control_points.flags.writeable = False
        curve = scipy.interpolate.BSpline(spline_basis(self.law.end).t, self.control_points, DEGREE)
        object.__setattr__(self, "_curves", tuple(curve.derivative(i) for i in range(4)))
        s = np.linspace(0.0, self.law.end, _FINE)
        x, y = self._curves[1](s).T
        headings = np.unwrap([self.heading, *np.arctan2(y, x)])[1:]
        object.__setattr__(self, "_headings", (s, headings))

    @property
    def t_end(self) -> float:
        """When the goal is reached, on the mission's clock [s]."""
        return self.t_start + self.law.duration

    def at(self, t: float) -> PlannedMotion:
        """Wanted motion at a time, in closed form.

        Args:
            t: time on the mission's clock [s].

        Returns:
            Wanted state and accelerations; v >= 0, the heading is not wrapped.
        """
        (s, pace, slope), (p, p1, p2, p3) = self._along(np.array([t]))
        v, omega, v_rate, omega_rate = in_time(motion(p1, p2, p3), pace, slope)[:, 0].tolist()
        if t > self.t_end:
            omega, v_rate, omega_rate = 0.0, 0.0, 0.0
        x, y = p[:, 0].tolist()
        theta = self._unwrapped(atan2(p1[1, 0], p1[0, 0]), float(s[0]))
        return PlannedMotion(UnicycleState(x, y, theta, v, omega), v_rate, omega_rate)

    def way(self, t: float, times: int) -> Array:
        """Positions at even times from a time to the end.

        Args:
            t: the first time, and the only one behind the end, on the mission's clock [s].
            times: how many.

        Returns:
            (2, times) positions on the floor [m].
        """
        way: Array = self._along(np.linspace(t, max(t, self.t_end), times))[1][0]
        return way

    def end_at(self, t: float) -> End:
        """What a curve must start with to go on from this one without a jump.

        Args:
            t: from start to end, on the mission's clock [s].

        Returns:
            The pose, and of P', P'', P''' what velocities and accelerations depend on.
        """
        state = self.at(t).state
        c, s = cos(state.theta), sin(state.theta)
        x, y = self._along(np.array([t]))[1][1:, :, 0].T
        along, left = (c * x + s * y).tolist(), (c * y - s * x).tolist()
        return End(state.pose, tuple(along[:2]), tuple(left))

    def clearance(self, t: float, obstacles: Iterable[Obstacle]) -> float:
        """How close the rest of the plan comes to obstacles: too close is time to replan.

        Args:
            t: now, on the mission's clock [s].
            obstacles: as they are now.

        Returns:
            The least distance of the leader from an edge until the plan's end; inf without any [m].

        Raises:
            ControlError: if t is not finite.
        """
        _, gaps = self._gaps(t, obstacles)
        return float(gaps.min())

    def meets(self, t: float, obstacles: Iterable[Obstacle], clearance: float) -> float:
        """When the rest of the plan first comes nearer to an obstacle than it may.

        Args:
            t: now, on the mission's clock [s].
            obstacles: as they are now.
            clearance: distance of the leader from an edge that is to be kept [m].

        Returns:
            That moment, on the mission's clock; inf if there is none [s].

        Raises:
            ControlError: if t is not finite.
        """
        since, gaps = self._gaps(t, obstacles)
        near = np.flatnonzero(gaps < clearance)
        return t + float(since[near[0]]) if len(near) else inf

    def _gaps(self, t: float, obstacles: Iterable[Obstacle]) -> tuple[Array, Array]:
        """(n,) times from t to the end, counted from t, and the least distance from an edge."""
        require_finite("time", t)
        since = np.linspace(0.0, max(self.t_end - t, 0.0), _FINE)
        way, gaps = self.way(t, _FINE), np.full(_FINE, inf)
        for o in obstacles:
            gaps = np.minimum(gaps, np.hypot(*o.apart(way, since)) - o.radius)
        return since, gaps

    def _along(self, t: Array) -> tuple[Array, Array]:
        """(3, n) S and (4, 2, n) P, with derivatives; straight on behind the end."""
        law = self.law.at(t - self.t_start)
        curve = np.array([derivative(law[0]).T for derivative in self._curves])
        curve[0] += (t - self.t_end).clip(0.0) * law[1] * curve[1]
        return law, curve

    def _unwrapped(self, heading: float, s: float) -> float:
        """The heading with the turns that the curve has made so far."""
        near = float(np.interp(s, *self._headings))
        return heading + 2.0 * pi * round((near - heading) / (2.0 * pi))
