"""The unicycle is flat in (x, y): its motion, and its followers', from a curve and a time law.

Of the curve P(sigma): pace u = |P'|, its rate a = u', curvature kappa = (P' x P'')/u^3 and its
rate k = kappa'. With sigma = S(t) these four shape numbers give every velocity without dividing
by the speed, so a robot at rest is no exception:

    v = S' u          v'     = S'^2 a + S'' u
    omega = kappa v   omega' = S'^2 u k + kappa v'

A point (x, y) rigid in the leader's frame has the speed v m, m^2 = (1 - kappa y)^2 + (kappa x)^2,
and its direction turns at S' (u kappa + x k/m^2): what its follower has to drive.
"""

from dataclasses import dataclass

import numpy as np

from control.motion_model import Array
from control.plan_request import FollowerPlace

_LEAST = 1e-6  # of u [m/s] and m [1]: below it the shape is not defined


@dataclass(frozen=True, slots=True)
class Shape:
    """The four shape numbers of a curve at n places.

    Attributes:
        u: (n,) pace along the curve [m/s].
        a: (n,) its derivative [m/s^2].
        kappa: (n,) curvature, positive to the left [1/m].
        k: (n,) its derivative [1/(m s)].
    """

    u: Array
    a: Array
    kappa: Array
    k: Array


def shape(p1: Array, p2: Array, p3: Array) -> Shape:
    """Shape numbers from the derivatives of a curve.

    Args:
        p1: (2, n) first derivative [m/s].
        p2: (2, n) second derivative [m/s^2].
        p3: (2, n) third derivative [m/s^3].

    Returns:
        The four numbers at each place.
    """
    u = np.maximum(np.hypot(p1[0], p1[1]), _LEAST)
    a = (p1[0] * p2[0] + p1[1] * p2[1]) / u
    kappa = (p1[0] * p2[1] - p1[1] * p2[0]) / u**3
    return Shape(u, a, kappa, (p1[0] * p3[1] - p1[1] * p3[0]) / u**3 - 3.0 * kappa * a / u)


def shape_gradient(p1: Array, p2: Array, p3: Array, at: Shape) -> Array:
    """Derivatives of the four shape numbers for those of the curve.

    Args:
        p1: (2, n) first derivative [m/s].
        p2: (2, n) second derivative [m/s^2].
        p3: (2, n) third derivative [m/s^3].
        at: the numbers there.

    Returns:
        (4, 3, 2, n): of u, a, kappa, k for p1, p2, p3, their x and y.
    """
    u, a, kappa = at.u, at.a, at.kappa
    zero = np.zeros_like(p1)
    du = p1 / u
    da1, da2 = p2 / u - a / u * du, du
    dkappa1 = _turned(p2, -1.0) / u**3 - 3.0 * kappa / u * du
    dkappa2 = _turned(p1, 1.0) / u**3
    cross = at.k + 3.0 * kappa * a / u  # (P' x P''')/u^3
    dk1 = _turned(p3, -1.0) / u**3 - 3.0 / u * (cross - kappa * a / u) * du
    dk1 -= 3.0 / u * (a * dkappa1 + kappa * da1)
    dk2 = -3.0 / u * (a * dkappa2 + kappa * da2)
    return np.array(
        [(du, zero, zero), (da1, da2, zero), (dkappa1, dkappa2, zero), (dk1, dk2, dkappa2)]
    )


def _turned(vector: Array, quarter: float) -> Array:
    """A vector turned by a quarter, to the left for +1."""
    return quarter * np.array([-vector[1], vector[0]])


def leader_rows(at: Shape, law: Array) -> Array:
    """v, omega and their rates, each with its derivatives for the shape numbers.

    Args:
        at: shape of the curve.
        law: (4, n) S and its derivatives.

    Returns:
        (4, 5, n): for v, omega, v', omega' the value and its derivatives for u, a, kappa, k
        [m/s, rad/s, m/s^2, rad/s^2].
    """
    _, s1, s2, _ = law
    u, a, kappa, k = at.u, at.a, at.kappa, at.k
    o, q = np.zeros_like(u), s1 * s1
    v_rate = q * a + s2 * u
    turn_rate = q * u * k + kappa * v_rate
    return np.array(
        [
            (s1 * u, s1, o, o, o),
            (s1 * u * kappa, s1 * kappa, o, s1 * u, o),
            (v_rate, s2, q, o, o),
            (turn_rate, q * k + kappa * s2, kappa * q, v_rate, q * u),
        ]
    )


def follower_rows(at: Shape, law: Array, place: FollowerPlace) -> Array:
    """Speed and turning rate of a point that is rigid in the leader's frame.

    Args:
        at: shape of the leader's curve.
        law: (4, n) S and its derivatives.
        place: the point.

    Returns:
        (2, 5, n), as in ``leader_rows``: the speed |p_k'|, and the turning rate of its direction
        [m/s, rad/s].
    """
    s1, x, y = law[1], place.x, place.y
    u, kappa, k = at.u, at.kappa, at.k
    o = np.zeros_like(u)
    m = np.maximum(np.hypot(1.0 - kappa * y, kappa * x), _LEAST)
    slope = (kappa * (x * x + y * y) - y) / m  # dm/dkappa
    bend = x / (m * m)
    turn = s1 * (u * kappa + bend * k)
    turn_slope = s1 * (u - 2.0 * bend * k * slope / m)
    return np.array(
        [
            (s1 * u * m, s1 * m, o, s1 * u * slope, o),
            (turn, s1 * kappa, o, turn_slope, s1 * bend),
        ]
    )
