"""The unicycle is flat in (x, y): its motion, and its followers', from a curve.

Along P(S), with e = P'/|P'| and a x b = a_x b_y - a_y b_x, the leader drives

    u = |P'|           u' = e . P''                         per S
    w = (e x P'')/u    w' = (e x P''' - 2 w u')/u

and with S(t) in time v = S' u, omega = S' w, v' = S'^2 u' + S'' u, omega' = S'^2 w' + S'' w: a
robot at rest, S' = 0, is no exception.

A point (x, y) that is rigid in the leader's frame moves with (u - w y, w x) in that frame. Its
speed is m, the length of that; its direction turns at w + x (u w' - w u')/m^2. In time both
take a factor S'. That is what its follower has to drive.
"""

import numpy as np

from control.motion_model import Array

_LEAST = 1e-9  # speeds count for at least that: directions need one [m/s]


def motion(p1: Array, p2: Array, p3: Array) -> Array:
    """Velocities and accelerations along a curve, per S.

    Args:
        p1: (2, n) first derivative, not 0 [m/s].
        p2: (2, n) second derivative [m/s^2].
        p3: (2, n) third derivative [m/s^3].

    Returns:
        (4, n): u, w, u', w' [m/s, rad/s, m/s^2, rad/s^2].
    """
    u = np.maximum(np.hypot(*p1), _LEAST)
    e = p1 / u
    u1, w = (e * p2).sum(axis=0), _cross(e, p2) / u
    return np.array([u, w, u1, (_cross(e, p3) - 2.0 * w * u1) / u])


def motion_gradient(p1: Array, p2: Array, p3: Array) -> Array:
    """Derivatives of ``motion`` for the derivatives of the curve.

    Args:
        p1: (2, n) first derivative, not 0 [m/s].
        p2: (2, n) second derivative [m/s^2].
        p3: (2, n) third derivative [m/s^3].

    Returns:
        (4, 3, 2, n): of u, w, u', w' for p1, p2, p3, their x and y.
    """
    u, w, u1, w1 = motion(p1, p2, p3)
    e, zero = p1 / u, np.zeros_like(p1)
    left = _turned(e) / u
    d_u1 = (p2 - u1 * e) / u
    d_w = -_turned(p2) / u**2 - 2.0 * w / u * e
    d_w1 = -_turned(p3) / u**2 - 2.0 / u * ((w1 + w * u1 / u) * e + w * d_u1 + u1 * d_w)
    return np.array(
        [
            (e, zero, zero),
            (d_w, left, zero),
            (d_u1, e, zero),
            (d_w1, -2.0 / u * (w * e + u1 * left), left),
        ]
    )


def in_time(along: Array, pace: Array, slope: Array) -> Array:
    """Motion in time from motion along a curve; linear, so its derivatives go the same way.

    Args:
        along: (4, ..., n) u, w, u', w' per S, or derivatives of them.
        pace: (n,) S' [1].
        slope: (n,) S'' [1/s].

    Returns:
        (4, ..., n): v, omega, v', omega' [m/s, rad/s, m/s^2, rad/s^2], or derivatives of them.
    """
    u, w, u1, w1 = along
    return np.array([pace * u, pace * w, pace**2 * u1 + slope * u, pace**2 * w1 + slope * w])


def point_motion(along: Array, x: float, y: float) -> Array:
    """Motion of a point that is rigid in the leader's frame, per S, with derivatives.

    Args:
        along: (4, n) u, w, u', w' of the leader [m/s, rad/s, m/s^2, rad/s^2].
        x: the point, forwards [m].
        y: the point, to the left [m].

    Returns:
        (2, 5, n): speed of the point and turning rate of its direction, each followed by its
        derivatives for u, w, u', w' [m/s, rad/s].
    """
    u, w, u1, w1 = along
    ahead, aside = u - w * y, w * x
    m = np.maximum(np.hypot(ahead, aside), _LEAST)
    m_u, m_w, zero = ahead / m, (aside * x - ahead * y) / m, np.zeros_like(u)
    q = x / m**2
    bend = q * (u * w1 - w * u1)
    turn_u, turn_w = q * w1 - 2.0 * bend * m_u / m, 1.0 - q * u1 - 2.0 * bend * m_w / m
    speed = (m, m_u, m_w, zero, zero)
    return np.array([speed, (w + bend, turn_u, turn_w, -q * w, q * u)])


def _cross(a: Array, b: Array) -> Array:
    product: Array = a[0] * b[1] - a[1] * b[0]
    return product


def _turned(a: Array) -> Array:
    """Vectors turned by a quarter to the left."""
    return np.array([-a[1], a[0]])
