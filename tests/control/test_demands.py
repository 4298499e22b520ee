"""Bounds of (28)-(30): never exceeded by robots drawn at random, and reached."""

from dataclasses import replace
from math import cos, pi, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from control.course import PairCourse
from control.demands import ON_COURSE, Reach, demands, push_length
from control.geometry import wrap_angle
from control.relative import (
    RelativeState,
    Vector2,
    apply,
    drift,
    input_matrix,
    inverse_input_matrix,
    leader_matrix,
    own_velocity_terms,
)
from control.unicycle import Twist
from tests.control.courses import GAINS, moments

D = 0.05
SHARE = st.floats(-1.0, 1.0)
PHI = st.floats(-pi, pi)


def p_bar(
    course: PairCourse, error: np.ndarray, phi: float, eps: Vector2, push: Vector2, known: bool
) -> np.ndarray:
    """P_bar of (28) from h'' of (8), for the law with v = 0 and whatever it is told."""
    (h, h_rate, _), (_, _, h_bend) = course.wanted[..., 0] - error, course.wanted[..., 0]
    psi = wrap_angle(h[1])
    relative = RelativeState(h[0], psi, wrap_angle(phi - psi))
    (v, omega), pushed = (
        course.leader.twist[:, 0],
        apply(leader_matrix(relative), tuple(course.leader.acceleration[:, 0])),
    )
    lead = apply(leader_matrix(relative), (v, omega))
    inverse = inverse_input_matrix(relative, D)
    own = Twist(*apply(inverse, (h_rate[0] - lead[0], h_rate[1] - lead[1])))
    l_e = GAINS.distance.integral * error[0, 0], GAINS.bearing.integral * error[0, 1]
    told = pushed if known else (0.0, 0.0)
    u = np.add(apply(inverse, tuple(l_e + h_bend - told)), own_velocity_terms(own, D))
    g = input_matrix(relative, D)
    f = drift(relative, Twist(v, omega), own, D)
    bend = np.add(apply(g, tuple((1.0 + np.array(eps)) * u + push)), pushed) + f
    k_e = GAINS.distance.proportional * error[1, 0], GAINS.bearing.proportional * error[1, 1]
    return np.asarray(bend - k_e - l_e - h_bend)  # v = 0: s'' = -P_bar (26), (28)


def error_at(course: PairCourse, reach: Reach, shares: tuple[float, ...]) -> np.ndarray:
    """An error within reach."""
    error = course.error[..., 0].copy()
    error[:2] += np.array(shares).reshape(2, 2) * reach
    return error


@given(moments(), st.tuples(SHARE, SHARE, SHARE, SHARE), PHI, st.tuples(SHARE, SHARE),
       st.tuples(SHARE, SHARE), st.booleans())  # fmt: skip
def test_no_robot_asks_for_more(
    moment: tuple[PairCourse, Reach], shares: tuple[float, ...], phi: float, eps: Vector2,
    push: Vector2, known: bool,
) -> None:  # fmt: skip
    course, reach = moment
    found = demands(course, reach, GAINS, D, known)
    model_error, pushes = 0.3, (0.4, 3.0)
    rho = found.disturbance(model_error, push_length(pushes, D))[:, 0]
    error = error_at(course, reach, shares)
    errors = model_error * eps[0], model_error * eps[1]
    asked = p_bar(course, error, phi, errors, (pushes[0] * push[0], pushes[1] * push[1]), known)
    assert (np.abs(asked) <= rho * (1.0 + 1e-9) + 1e-12).all()


@given(moments(), PHI, st.booleans())
def test_exact_bounds_are_reached(
    moment: tuple[PairCourse, Reach], phi: float, known: bool
) -> None:
    course, reach = moment
    bound = demands(course, reach, GAINS, D, known).exact[:, 0]
    worst = np.zeros(2)
    for turned in np.linspace(-1.0, 1.0, 25):
        for near in (-1.0, 1.0):
            for i in (-1.0, 0.0, 1.0):
                for j in np.linspace(-1.0, 1.0, 5):
                    error = error_at(course, reach, (near, turned, i, j))
                    asked = np.abs(p_bar(course, error, phi, (0.0, 0.0), (0.0, 0.0), known))
                    worst = np.maximum(worst, asked)
    if known:  # then the leader's acceleration is exactly cancelled
        course = replace(course, leader=replace(course.leader, acceleration=np.zeros((2, 2))))
        assert bound == pytest.approx(demands(course, reach, GAINS, D, False).exact[:, 0])
    assert worst == pytest.approx(bound, rel=0.03, abs=0.01)


@given(moments(), PHI, st.tuples(SHARE, SHARE))
def test_gain_and_coupling_are_bounded(
    moment: tuple[PairCourse, Reach], phi: float, eps: Vector2
) -> None:
    course, reach = moment
    found = demands(course, reach, GAINS, D, leader_known=False)
    most = max(abs(eps[0]), abs(eps[1]))
    for l in (found.near[0], found.far[0]):  # noqa: E741 (the paper's l)
        m = model_error_matrix(l, phi, eps)
        assert np.abs(np.diagonal(m)).max() <= most + 1e-12  # delta, delta' = 1 -+ most
        assert abs(m[0, 1]) <= found.coupling(most)[0, 0] + 1e-12
        assert abs(m[1, 0]) <= found.coupling(most)[1, 0] + 1e-12
    reached = model_error_matrix(found.far[0], 0.25 * pi, (-most, most))
    assert abs(reached[0, 1]) == pytest.approx(found.coupling(most)[0, 0])
    assert model_error_matrix(1.0, 0.0, (most, 0.0))[0, 0] == pytest.approx(most)


def model_error_matrix(l: float, phi: float, eps: Vector2) -> np.ndarray:  # noqa: E741 (the paper's)
    """G Delta G^-1."""
    relative = RelativeState(l, phi, 0.0)
    g, inverse = input_matrix(relative, D), inverse_input_matrix(relative, D)
    return np.array(g) @ np.diag(eps) @ np.array(inverse)


def test_a_push_is_as_long_as_its_worst_direction() -> None:
    phi = np.linspace(-pi, pi, 10001)
    along = 0.4 * np.abs(np.cos(phi)) + D * 3.0 * np.abs(np.sin(phi))
    assert push_length((0.4, 3.0), D) == pytest.approx(along.max(), rel=1e-6)
    across = D * 3.0 * abs(cos(0.3)) + 0.4 * abs(sin(0.3))
    assert push_length((0.4, 3.0), D) >= across


@given(moments())
def test_where_the_leader_may_be_reached_there_is_no_bound(
    moment: tuple[PairCourse, Reach],
) -> None:
    course, reach = moment
    to_leader = float(course.output[0, 0, 0]) - 0.049
    found = demands(course, ((to_leader, 0.1), reach[1]), GAINS, D, leader_known=False)
    assert np.isinf(found.exact).all()
    assert np.isfinite(demands(course, ON_COURSE, GAINS, D, leader_known=False).exact).all()
