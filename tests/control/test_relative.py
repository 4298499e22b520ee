"""Equations (6)-(8) against simulated motion, the printed F, and the symmetries of the plane."""

from math import cos, hypot, pi, sin

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st

from control.geometry import Pose2D, compose, wrap_angle
from control.relative import (
    RelativeState,
    apply,
    drift,
    input_matrix,
    inverse_input_matrix,
    leader_matrix,
    own_velocity_terms,
    relative_rates,
    relative_state,
)
from control.unicycle import Twist, UnicycleState

D = 0.05
COORDINATE = st.floats(-2.0, 2.0)
ANGLE = st.floats(-3.1, 3.1)
POSE = st.builds(Pose2D, COORDINATE, COORDINATE, ANGLE)
TWIST = st.builds(Twist, st.floats(-1.0, 1.0), st.floats(-5.0, 5.0))
ACCELERATION = st.tuples(st.floats(-5.0, 5.0), st.floats(-50.0, 50.0))


def wedge(leader: Pose2D, follower: Pose2D) -> RelativeState:
    """Relative state of a pair that is neither too close nor far."""
    relative = relative_state(leader, follower, D)
    assume(0.1 < relative.distance < 3.0)
    return relative


def moved(pose: Pose2D, twist: Twist, u: tuple[float, float], t: float) -> UnicycleState:
    """A robot after t under constant accelerations, integrated finely (Simpson on the way)."""
    way = [0.0, 0.0]
    for weight, at in ((1, 0.0), (4, 0.5 * t), (1, t)):
        theta = pose.theta + twist.omega * at + 0.5 * u[1] * at * at
        speed = twist.v + u[0] * at
        way[0] += weight * t / 6 * speed * cos(theta)
        way[1] += weight * t / 6 * speed * sin(theta)
    theta = pose.theta + twist.omega * t + 0.5 * u[1] * t * t
    return UnicycleState(pose.x + way[0], pose.y + way[1], theta, 0.0, 0.0)


def test_bearing_is_pi_straight_behind_and_positive_on_the_left() -> None:
    leader = Pose2D(0.0, 0.0, 0.0)
    behind = relative_state(leader, Pose2D(-0.35, 0.0, 0.0), D)
    assert abs(behind.distance - 0.3) < 1e-12
    assert abs(abs(behind.bearing) - pi) < 1e-12
    left = relative_state(leader, Pose2D(-0.2 - D, 0.2, 0.0), D)
    assert abs(left.bearing - 3 * pi / 4) < 1e-12


@given(POSE, POSE, TWIST, TWIST)
def test_rates_against_finite_differences(p: Pose2D, q: Pose2D, vi: Twist, vk: Twist) -> None:
    relative, h = wedge(p, q), 1e-5
    rates = relative_rates(relative, vi, vk, D)
    ends = [
        relative_state(moved(p, vi, (0, 0), t).pose, moved(q, vk, (0, 0), t).pose, D)
        for t in (-h, h)
    ]
    scale = 1.0 + abs(vi.v) + abs(vk.v) + abs(vi.omega) + abs(vk.omega)
    assert abs((ends[1].distance - ends[0].distance) / (2 * h) - rates.distance) < 1e-7 * scale
    bearing = wrap_angle(ends[1].bearing - ends[0].bearing) / (2 * h)
    assert abs(bearing - rates.bearing) < 1e-6 * scale
    heading = wrap_angle(ends[1].heading - ends[0].heading) / (2 * h)
    assert abs(heading - rates.heading) < 1e-8 * scale


@given(POSE, POSE, TWIST, TWIST, ACCELERATION, ACCELERATION)
def test_second_derivative_is_g_u_plus_e_u_plus_f(
    p: Pose2D,
    q: Pose2D,
    vi: Twist,
    vk: Twist,
    ui: tuple[float, float],
    uk: tuple[float, float],
) -> None:
    relative, h = wedge(p, q), 1e-4
    terms = (
        apply(input_matrix(relative, D), uk),
        apply(leader_matrix(relative), ui),
        drift(relative, vi, vk, D),
    )
    wanted = np.sum(terms, axis=0)
    a, b, c = (
        relative_state(moved(p, vi, ui, t).pose, moved(q, vk, uk, t).pose, D) for t in (-h, 0.0, h)
    )
    l_pp = (a.distance - 2 * b.distance + c.distance) / h**2
    psi_pp = (wrap_angle(c.bearing - b.bearing) - wrap_angle(b.bearing - a.bearing)) / h**2
    scale = 1.0 + sum(abs(entry) for term in terms for entry in term)
    assert abs(l_pp - wanted[0]) < 2e-5 * scale
    assert abs(psi_pp - wanted[1]) < 2e-5 * scale


@given(POSE, POSE, TWIST, TWIST)
def test_drift_is_the_printed_f_with_one_over_l_on_row_two(
    p: Pose2D, q: Pose2D, vi: Twist, vk: Twist
) -> None:
    relative = wedge(p, q)
    l, psi = relative.distance, relative.bearing  # noqa: E741 (the paper's l)
    rates = relative_rates(relative, vi, vk, D)
    dl, dpsi, th_i, dth_i, dth_k = rates.distance, rates.bearing, p.theta, vi.omega, vk.omega
    dth_ik, dx, dy = dth_i - dth_k, vi.v * cos(th_i), vi.v * sin(th_i)
    row1 = dpsi**2 * l - dth_k * l * dpsi + dth_i * (dth_ik * l + 2 * dpsi * l)
    row1 += dth_ik * (cos(psi + th_i) * dy - sin(psi + th_i) * dx)
    row2 = -2 * dl * dpsi + dth_k * dl - 2 * dl * dth_i - sin(psi + th_i) * dth_ik * dy
    row2 = (row2 - cos(psi + th_i) * dth_ik * dx) / l
    f1, f2 = drift(relative, vi, vk, D)
    scale = 1.0 + abs(vi.omega) ** 2 + abs(vk.omega) ** 2 + 100.0
    assert abs(f1 - row1) < 1e-13 * scale
    assert abs(f2 - row2) < 1e-12 * scale


@given(POSE, POSE, TWIST)
def test_own_velocity_terms_leave_nothing_of_the_follower(p: Pose2D, q: Pose2D, vk: Twist) -> None:
    relative, at_rest = wedge(p, q), Twist(0.0, 0.0)
    f = drift(relative, at_rest, vk, D)
    own = apply(input_matrix(relative, D), own_velocity_terms(vk, D))
    # with a leader at rest what stays is the turning of the line of sight alone
    rates = relative_rates(relative, at_rest, vk, D)
    swing = relative.distance * rates.bearing**2, -2 * rates.distance * rates.bearing
    assert abs(f[0] + own[0] - swing[0]) < 1e-9
    assert abs(f[1] + own[1] - swing[1] / relative.distance) < 1e-9


@given(POSE, POSE)
def test_inverse_and_determinant_of_g(p: Pose2D, q: Pose2D) -> None:
    relative = wedge(p, q)
    g = np.array(input_matrix(relative, D))
    np.testing.assert_allclose(
        g @ np.array(inverse_input_matrix(relative, D)), np.eye(2), atol=1e-12
    )
    assert abs(np.linalg.det(g) * relative.distance / D - 1.0) < 1e-12


@given(POSE, POSE, POSE)
def test_invariant_under_rotation_and_translation(p: Pose2D, q: Pose2D, frame: Pose2D) -> None:
    here, there = wedge(p, q), relative_state(compose(frame, p), compose(frame, q), D)
    assert abs(there.distance - here.distance) < 1e-12
    assert abs(wrap_angle(there.bearing - here.bearing)) < 1e-10
    assert abs(wrap_angle(there.heading - here.heading)) < 1e-12


@given(POSE, POSE, TWIST, TWIST)
def test_a_mirror_turns_the_signs_of_angles(p: Pose2D, q: Pose2D, vi: Twist, vk: Twist) -> None:
    def mirrored(pose: Pose2D) -> Pose2D:
        return Pose2D(pose.x, -pose.y, -pose.theta)

    here, there = wedge(p, q), relative_state(mirrored(p), mirrored(q), D)
    assert abs(there.distance - here.distance) < 1e-12
    assert abs(wrap_angle(there.bearing + here.bearing)) < 1e-10
    f = drift(here, vi, vk, D)
    g = drift(there, Twist(vi.v, -vi.omega), Twist(vk.v, -vk.omega), D)
    assert hypot(g[0] - f[0], g[1] + f[1]) < 1e-8 * (1.0 + hypot(*f))
