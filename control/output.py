"""The output h of a follower and how its accelerations change it: what every law acts on.

h'' = G (u - own) + F_i + E u_i, where own are the accelerations that cancel the follower's part of
F and F_i is what the leaders' velocities cause. h is distance and bearing about one leader (6)-(8),
or the distances to two leaders (Remark 3).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, sin

from control.compilable import compilable
from control.formation import ShapeReference
from control.geometry import wrap_angle
from control.relative import (
    Matrix2,
    RelativeState,
    Vector2,
    apply,
    drift,
    input_matrix,
    inverse_input_matrix,
    leader_matrix,
    own_velocity_terms,
    relative_rates,
)
from control.unicycle import Twist
from control.value import value

MIN_DISTANCE = 0.05
"""Distances below this are taken for this in G, which is singular at 0 [m]."""

MIN_SINE = 0.15
"""A follower in line with its two leaders is taken for one this far beside: G is singular there."""


@value
@dataclass(frozen=True, slots=True)
class LeaderMotion:
    """What a follower's law may know of its leader.

    Attributes:
        twist: estimated velocities; for the first-order laws alone [m/s, rad/s].
        acceleration: forward and angular, if the leader's commands are known (a leader of a cascade
            is itself a follower); (0, 0) as published [m/s^2, rad/s^2].
    """

    twist: Twist
    acceleration: Vector2


@value
@dataclass(frozen=True, slots=True)
class FollowerOutput:
    """h at one moment, and the parts of h''.

    Attributes:
        h: distance and bearing, or two distances [m, rad or m].
        rate: h' by the estimated velocities of all [m/s, rad/s or m/s].
        input_matrix: G.
        inverse: of G, kept away from singular.
        drift: F_i, by the leaders' estimated velocities [m/s^2, rad/s^2 or m/s^2].
        push: E u_i, by the leaders' known accelerations [m/s^2, rad/s^2 or m/s^2].
        own: u that cancels the follower's part of F [m/s^2, rad/s^2].
        size: metres per unit of the second entry: l, or 1.
        turns: whether the second entry is an angle, whose errors are wrapped.
    """

    h: Vector2
    rate: Vector2
    input_matrix: Matrix2
    inverse: Matrix2
    drift: Vector2
    push: Vector2
    own: Vector2
    size: float
    turns: bool


@value
@dataclass(frozen=True, slots=True)
class WantedOutput:
    """h^d at one moment.

    Attributes:
        h: wanted value [m, rad or m].
        rate: first derivative [per s].
        acceleration: second derivative [per s^2].
    """

    h: Vector2
    rate: Vector2 = (0.0, 0.0)
    acceleration: Vector2 = (0.0, 0.0)


@compilable
def pair_output(
    relative: RelativeState, own: Twist, leader: LeaderMotion, camera_offset: float
) -> FollowerOutput:
    """h = (l, psi) of a leader-follower pair, equation (8).

    Args:
        relative: relative state [m, rad, rad].
        own: the follower's velocities [m/s, rad/s].
        leader: what is known of the leader.
        camera_offset: d, > 0 [m].

    Returns:
        The output; its matrices are those of `MIN_DISTANCE` where the robots are nearer.
    """
    far = RelativeState(max(relative.distance, MIN_DISTANCE), relative.bearing, relative.heading)
    g = input_matrix(far, camera_offset)
    o1, o2 = own_velocity_terms(own, camera_offset)
    cancelled = apply(g, (o1, o2))
    f = drift(far, leader.twist, own, camera_offset)
    rates = relative_rates(far, leader.twist, own, camera_offset)
    return FollowerOutput(
        (relative.distance, relative.bearing),
        (rates.distance, rates.bearing),
        g,
        inverse_input_matrix(far, camera_offset),
        (f[0] + cancelled[0], f[1] + cancelled[1]),
        apply(leader_matrix(far), leader.acceleration),
        (o1, o2),
        far.distance,
        True,
    )


@compilable
def two_leaders_output(
    relatives: tuple[RelativeState, RelativeState],
    own: Twist,
    leaders: tuple[LeaderMotion, LeaderMotion],
    camera_offset: float,
) -> FollowerOutput:
    """h = (l_ik, l_jk): the distances to two leaders, Remark 3.

    With phi = psi + theta of each, G = [[cos phi_i, d sin phi_i], [cos phi_j, d sin phi_j]] and
    det G = d sin(phi_j - phi_i): the first rows of the two pairs.

    Args:
        relatives: relative states to both leaders [m, rad, rad].
        own: the follower's velocities [m/s, rad/s].
        leaders: what is known of both.
        camera_offset: d, > 0 [m].

    Returns:
        The output; the inverse is that of `MIN_SINE` where the three robots are in line.
    """
    one = pair_output(relatives[0], own, leaders[0], camera_offset)
    two = pair_output(relatives[1], own, leaders[1], camera_offset)
    return FollowerOutput(
        (one.h[0], two.h[0]),
        (one.rate[0], two.rate[0]),
        (one.input_matrix[0], two.input_matrix[0]),
        _two_leaders_inverse(relatives, camera_offset),
        (one.drift[0], two.drift[0]),
        (one.push[0], two.push[0]),
        one.own,
        1.0,
        False,
    )


def wanted_output(references: Sequence[ShapeReference]) -> WantedOutput:
    """h^d of a follower from the references to its leaders.

    Args:
        references: one: distance and bearing; two: the distances to two leaders.

    Returns:
        h^d with derivatives.
    """
    one, two = references[0], references[-1]
    if one is two:
        return WantedOutput(
            (one.distance, one.bearing),
            (one.distance_rate, one.bearing_rate),
            (one.distance_acceleration, one.bearing_acceleration),
        )
    return WantedOutput(
        (one.distance, two.distance),
        (one.distance_rate, two.distance_rate),
        (one.distance_acceleration, two.distance_acceleration),
    )


def follower_output(
    relatives: Sequence[RelativeState],
    own: Twist,
    leaders: Sequence[LeaderMotion],
    camera_offset: float,
) -> FollowerOutput:
    """h of a follower of one leader or of two.

    Args:
        relatives: relative states to its leaders, one or two [m, rad, rad].
        own: the follower's velocities [m/s, rad/s].
        leaders: what is known of them.
        camera_offset: d, > 0 [m].

    Returns:
        The output.
    """
    if len(relatives) == 1:
        return pair_output(relatives[0], own, leaders[0], camera_offset)
    both = relatives[0], relatives[1]
    return two_leaders_output(both, own, (leaders[0], leaders[1]), camera_offset)


@compilable
def output_error(output: FollowerOutput, wanted: WantedOutput) -> Vector2:
    """e_1 of (11), an angle wrapped.

    Args:
        output: h.
        wanted: h^d.

    Returns:
        h^d - h [m, rad or m].
    """
    second = wanted.h[1] - output.h[1]
    return wanted.h[0] - output.h[0], wrap_angle(second) if output.turns else second


@compilable
def _two_leaders_inverse(
    relatives: tuple[RelativeState, RelativeState], camera_offset: float
) -> Matrix2:
    """G^-1 with |sin(phi_j - phi_i)| of at least MIN_SINE."""
    one = relatives[0].bearing + relatives[0].heading
    two = relatives[1].bearing + relatives[1].heading
    sine = sin(two - one)
    away = max(sine, MIN_SINE) if sine >= 0.0 else min(sine, -MIN_SINE)
    a, d = 1.0 / away, camera_offset
    return (a * sin(two), -a * sin(one)), (-a * cos(two) / d, a * cos(one) / d)
