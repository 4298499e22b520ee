"""What a follower's law must reject: proved bounds of (28)-(30) over errors, sample by sample.

With z = psi' + w_i, equation (8) with the own-velocity terms in u leaves of P_bar in (28)

    l z^2 - v_i w_i sin psi - a_i cos psi                         - K e_l'      + errors + pushes
    (-2 l' z - v_i w_i cos psi + a_i sin psi)/l - w_i'            - K e_psi'    + errors + pushes

In metres (bearings times l) G Delta G^-1 is a rotated Delta: its norm is at most the model error E,
so that (29) has delta = 1 - E and delta' = 1 + E, and its entries off the diagonal are at most E:
one channel feels E l or E/l times the control of the other. Every heading phi is covered.
"""

from dataclasses import dataclass
from itertools import product
from math import hypot, inf

import numpy as np

from control.course import IdealFollower, PairCourse
from control.follower import SlidingGains
from control.nominal import FloatArray
from control.output import MIN_DISTANCE
from control.relative import Vector2

Reach = tuple[Vector2, Vector2]
"""Of errors and their rates about a course, of distance and bearing [m, rad, per s]."""

ON_COURSE: Reach = ((0.0, 0.0), (0.0, 0.0))


@dataclass(frozen=True, slots=True)
class Demands:
    """Bounds at N samples, parted by what causes them.

    Attributes:
        exact: (2, N) of |P_bar| without model errors and pushes; infinite where the distance may
            fall to `MIN_DISTANCE`, where the law's G ends [m/s^2, rad/s^2].
        fed: (N,) length of what model errors multiply, bearings times l [m/s^2].
        leader: (N,) length of the leader's acceleration as h'' feels it [m/s^2].
        leader_known: whether the law is told that acceleration.
        near: (N,) least distance [m].
        far: (N,) greatest distance [m].
    """

    exact: FloatArray
    fed: FloatArray
    leader: FloatArray
    leader_known: bool
    near: FloatArray
    far: FloatArray

    def disturbance(self, model_error: float, push: float) -> FloatArray:
        """rho of (30) per channel.

        Args:
            model_error: E, bound of |eps| and |eps'| (5) [1].
            push: length of pi of (4) at the camera point [m/s^2].

        Returns:
            (2, N) bounds of |P_bar| [m/s^2, rad/s^2].
        """
        length = model_error * self.fed + push
        return self.exact + np.stack((length, length / self.near))

    def coupling(self, model_error: float) -> FloatArray:
        """How much of the other channel's control each channel feels.

        Args:
            model_error: E [1].

        Returns:
            (2, N) bounds, reached at phi = 45 deg by errors of opposite sign [m, 1/m].
        """
        return model_error * np.stack((self.far, 1.0 / self.near))

    def untold(self, model_error: float) -> FloatArray:
        """What a law is not told of its leader's acceleration.

        Args:
            model_error: E, the leader's too [1].

        Returns:
            (N,) bounds, bearings times l [m/s^2].
        """
        return self.leader * (model_error if self.leader_known else 1.0)


def push_length(disturbance: Vector2, camera_offset: float) -> float:
    """Greatest push of the camera point in any direction, by (4) through G.

    Args:
        disturbance: bounds of pi_v and pi_omega [m/s^2, rad/s^2].
        camera_offset: d [m].

    Returns:
        max over phi of pi_v |cos phi| + d pi_omega |sin phi| [m/s^2].
    """
    return hypot(disturbance[0], camera_offset * disturbance[1])


def demands(
    course: PairCourse,
    reach: Reach,
    gains: SlidingGains,
    camera_offset: float,
    leader_known: bool,
    own: FloatArray | None = None,
) -> Demands:
    """Bounds of what a second-order law must reject, for errors within reach of a course.

    Args:
        course: the pair.
        reach: of errors about those of the course.
        gains: K and L.
        camera_offset: d [m].
        leader_known: whether the law is told the leader's acceleration; then model errors alone,
            the follower's and the leader's, keep it from being cancelled.
        own: (N,) length of the own-velocity terms where the follower's motion is known, else any
            they can have: |V|^2/d for a camera point at |V| [m/s^2].

    Returns:
        The bounds; `exact` and the coupling are reached.
    """
    l, apart = course.output[0, 0], course.output[0, 0].min() - reach[0][0]  # noqa: E741
    near, far = np.maximum(l - reach[0][0], MIN_DISTANCE), l + reach[0][0]
    a, alpha = course.leader.acceleration
    leader, unknown = np.abs(a) + far * np.abs(alpha), 0.0 if leader_known else 1.0
    exact = np.stack((
        _along(course, reach, gains.distance.proportional, near, far, unknown * a),
        _across(course, reach, gains.bearing.proportional, near, far, unknown * a, unknown * alpha),
    ))  # fmt: skip
    if own is None:
        v, omega = np.abs(course.leader.twist)
        l_rate, psi_rate = np.abs(course.output[1]) + np.array(reach[1])[:, None]
        own = (v + np.hypot(l_rate, far * (psi_rate + omega))) ** 2 / camera_offset
    fed = _pull(course, reach, gains, far) + own + 2.0 * (1.0 - unknown) * leader
    if not apart > MIN_DISTANCE:
        exact = np.full_like(exact, inf)
    return Demands(exact, fed, leader, leader_known, near, far)


def disturbance_rate(
    course: PairCourse, ideal: IdealFollower, camera_offset: float, model_error: float, told: bool
) -> float:
    """Greatest rate of what super-twisting must reject on the nominal path, pushes left out.

    G Delta u is a rotated Delta times (u_1, d u_2), in metres. Rates are differences of samples: a
    jump counts as its height over the time between two.

    Args:
        course: of the pair.
        ideal: the follower if it slides ideally.
        camera_offset: d [m].
        model_error: E [1].
        told: whether the law is told the leader's acceleration.

    Returns:
        The rate, bearings times l [m/s^3].
    """
    (l, psi), (a, alpha) = course.output[0], course.leader.acceleration  # noqa: E741
    asked = ideal.motion.acceleration * np.array([[1.0], [camera_offset]])
    turning = np.abs(np.diff(ideal.phi)) + np.abs(np.diff(np.log(l)))
    through_errors = np.hypot(*np.diff(asked)) + turning * np.hypot(*asked)[1:]
    pushed = np.stack((-a * np.cos(psi), a * np.sin(psi) - l * alpha))
    by_leader = (model_error if told else 1.0) * np.hypot(*np.diff(pushed))
    dt = float(course.times[1] - course.times[0])
    return float((model_error * through_errors + by_leader).max()) / dt


def _along(
    course: PairCourse, reach: Reach, damping: float, near: FloatArray, far: FloatArray,
    a: FloatArray,
) -> FloatArray:  # fmt: skip
    """Greatest |l z^2 - v w sin psi - a cos psi - K e_l'|: its parts share no error."""
    v, omega = course.leader.twist
    z, spread = np.abs(course.output[1, 1] + omega), reach[1][1]
    least, most = _wave(-v * omega, -a, course, reach)
    damped, give = -damping * course.error[1, 0], damping * reach[1][0]
    low = near * np.maximum(z - spread, 0.0) ** 2 + least + damped - give
    high = far * (z + spread) ** 2 + most + damped + give
    worst: FloatArray = np.maximum(np.abs(low), np.abs(high))
    return worst


def _across(
    course: PairCourse, reach: Reach, damping: float, near: FloatArray, far: FloatArray,
    a: FloatArray, alpha: FloatArray,
) -> FloatArray:  # fmt: skip
    """Greatest |(-2 l' z - v w cos psi + a sin psi)/l - w' - K e_psi'|: linear in each of e_l',
    e_psi', 1/l and the wave, so that it is greatest at a corner of them."""
    v, omega = course.leader.twist
    found = []
    for l, wave, i, j in product(  # noqa: E741 (the paper's l)
        (near, far), _wave(a, -v * omega, course, reach), (-1.0, 1.0), (-1.0, 1.0)
    ):
        e1_rate, e2_rate = course.error[1] + [[i * reach[1][0]], [j * reach[1][1]]]
        l_rate, z = course.wanted[1, 0] - e1_rate, course.wanted[1, 1] - e2_rate + omega
        found.append(np.abs((-2.0 * l_rate * z + wave) / l - alpha - damping * e2_rate))
    worst: FloatArray = np.max(found, axis=0)
    return worst


def _pull(course: PairCourse, reach: Reach, gains: SlidingGains, far: FloatArray) -> FloatArray:
    """Greatest length of L e + h^d'', bearings times l."""
    l2 = np.array([[gains.distance.integral], [gains.bearing.integral]])
    most = np.abs(l2 * course.error[0] + course.wanted[2]) + l2 * np.array(reach[0])[:, None]
    length: FloatArray = np.hypot(most[0], far * most[1])
    return length


def _wave(
    sine: FloatArray, cosine: FloatArray, course: PairCourse, reach: Reach
) -> tuple[FloatArray, FloatArray]:
    """Least and greatest sine sin psi + cosine cos psi within reach."""
    height, off = np.hypot(sine, cosine), course.output[0, 1] - np.arctan2(sine, cosine)
    return -height * _crest(off + np.pi, reach[0][1]), height * _crest(off, reach[0][1])


def _crest(middle: FloatArray, half: float) -> FloatArray:
    """Greatest cosine over middle +- half [rad]."""
    away = np.abs((middle + np.pi) % (2.0 * np.pi) - np.pi)  # from the nearest crest
    crest: FloatArray = np.cos(np.maximum(away - half, 0.0))
    return crest
