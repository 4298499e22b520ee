"""What a leader-follower pair goes through if its follower keeps s = 0 (23), sampled."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from control.errors import ControlError
from control.follower import SlidingGains
from control.formation import ShapeReference
from control.nominal import FloatArray, nominal_error
from control.output import MIN_DISTANCE, LeaderMotion, pair_output
from control.plan import PlannedMotion
from control.relative import RelativeState, Vector2, apply, inverse_input_matrix, leader_matrix
from control.unicycle import Twist


@dataclass(frozen=True, slots=True)
class Motion:
    """A robot's motion over N samples.

    Attributes:
        twist: (2, N) velocities [m/s, rad/s].
        acceleration: (2, N) between jumps of the velocities [m/s^2, rad/s^2].
    """

    twist: FloatArray
    acceleration: FloatArray


@dataclass(frozen=True, slots=True)
class PairCourse:
    """A pair over N samples; second entries are of distance and bearing.

    Attributes:
        times: (N,) on the mission's clock, evenly spaced [s].
        leader: motion of robot i.
        wanted: (3, 2, N) h^d and two derivatives [m, rad, per s, per s^2].
        error: (3, 2, N) e and two derivatives, (23) [m, rad, per s, per s^2].
    """

    times: FloatArray
    leader: Motion
    wanted: FloatArray
    error: FloatArray

    @property
    def output(self) -> FloatArray:
        """(3, 2, N) h = h^d - e and two derivatives [m, rad, per s, per s^2]."""
        h: FloatArray = self.wanted - self.error
        return h

    def moved(self, pace: float, added: float) -> "PairCourse":
        """The same errors behind another leader, in another shape.

        Args:
            pace: of the leader: its speeds grow with it, its accelerations with its square [1].
            added: to the wanted distance [m].

        Returns:
            The course.
        """
        lead, wanted = self.leader, self.wanted.copy()
        wanted[0, 0] += added
        leader = Motion(pace * lead.twist, pace * pace * lead.acceleration)
        return replace(self, leader=leader, wanted=_frozen(wanted))


@dataclass(frozen=True, slots=True)
class IdealFollower:
    """A follower that keeps s = 0 throughout.

    Attributes:
        motion: of the follower, for those that follow it.
        phi: (N,) psi + theta_ik [rad].
    """

    motion: Motion
    phi: FloatArray


def planned_motion(planned: Iterable[PlannedMotion]) -> Motion:
    """Motion of the formation's leader, as planned.

    Args:
        planned: wanted motion at every sample.

    Returns:
        The motion.
    """
    rows = [(p.state.v, p.state.omega, p.v_rate, p.omega_rate) for p in planned]
    table = _frozen(np.array(rows, dtype=np.float64).T)
    return Motion(table[:2], table[2:])


def jumps(motion: Motion, times: FloatArray, least: float = 0.05) -> FloatArray:
    """Jumps of velocities that the accelerations do not tell.

    Args:
        motion: of a leader.
        times: (N,) of its samples [s].
        least: smaller ones are none [m/s, rad/s].

    Returns:
        (3, J): when, and by how much v and omega jump [s, m/s, rad/s].
    """
    mean = 0.5 * (motion.acceleration[:, 1:] + motion.acceleration[:, :-1])
    left = np.diff(motion.twist) - mean * np.diff(times)
    at = np.flatnonzero(np.abs(left).max(axis=0) > least)
    return np.vstack((times[at + 1], left[:, at]))


def pair_course(
    times: FloatArray,
    leader: Motion,
    wanted: Iterable[ShapeReference],
    start: tuple[Vector2, Vector2],
    gains: SlidingGains,
) -> PairCourse:
    """A pair whose errors are nominal from the start.

    Args:
        times: (N,) evenly spaced, N >= 2 [s].
        leader: its motion at these times.
        wanted: the shape at these times.
        start: e(0) and e'(0) of distance and bearing [m, rad, per s].
        gains: K and L.

    Returns:
        The course.

    Raises:
        ControlError: if there are fewer than two samples.
    """
    if len(times) < 2:
        raise ControlError(f"a course needs at least 2 samples, got {len(times)}")
    rows = [
        (w.distance, w.bearing, w.distance_rate, w.bearing_rate,
         w.distance_acceleration, w.bearing_acceleration)
        for w in wanted
    ]  # fmt: skip
    shape, error = np.array(rows, dtype=np.float64).T.reshape(3, 2, -1), np.empty((3, 2, len(rows)))
    for j, channel in enumerate((gains.distance, gains.bearing)):
        e, rate = nominal_error(channel, start[0][j], start[1][j], times)
        error[:, j] = e, rate, -channel.proportional * rate - channel.integral * e  # (23)
    return PairCourse(times, leader, _frozen(shape), _frozen(error))


def ideal_follower(course: PairCourse, heading: float, camera_offset: float) -> IdealFollower:
    """The follower's motion if s = 0 throughout: h is nominal, its heading follows by (2).

    Args:
        course: of the pair.
        heading: theta_ik at the first sample [rad].
        camera_offset: d, > 0 [m].

    Returns:
        Its motion and phi.

    Raises:
        ControlError: if it comes so near to its leader that the law's G ends.
    """
    h, dt = course.output, float(course.times[1] - course.times[0])
    _require_apart(float(h[0, 0].min()))
    table = np.vstack((*h, course.leader.twist, course.leader.acceleration)).T.tolist()
    rows = []
    for l, psi, l_rate, psi_rate, l_bend, psi_bend, v, w, a, alpha in table:  # noqa: E741
        relative, lead = RelativeState(l, psi, heading), LeaderMotion(Twist(v, w), (a, alpha))
        f1, f2 = apply(leader_matrix(relative), (v, w))
        inverse = inverse_input_matrix(relative, camera_offset)
        own = Twist(*apply(inverse, (l_rate - f1, psi_rate - f2)))
        o = pair_output(relative, own, lead, camera_offset)
        rest = l_bend - o.drift[0] - o.push[0], psi_bend - o.drift[1] - o.push[1]
        u1, u2 = apply(inverse, rest)
        rows.append((own.v, own.omega, u1 + o.own[0], u2 + o.own[1], psi + heading))
        heading += dt * (w - own.omega)
    found = _frozen(np.array(rows).T)
    return IdealFollower(Motion(found[:2], found[2:4]), found[4])


def _require_apart(least: float) -> None:
    if not least > MIN_DISTANCE:
        raise ControlError(
            f"the nominal path comes within {least:.3f} m of the leader, {MIN_DISTANCE:g} m is the "
            "least: start nearer to the shape, or want a wider one"
        )


def _frozen(array: FloatArray) -> FloatArray:
    array.setflags(write=False)
    return array
