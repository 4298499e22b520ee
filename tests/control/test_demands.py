"""Bounds of (28)-(30): never exceeded by robots drawn at random, and reached."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from math import cos, pi, sin

import numpy as np
import pytest
from hypothesis import example, given, settings
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
from tests.control.courses import GAINS, moments, still

D = 0.05
Shares = Sequence[tuple[float, ...]]
SHARE = st.floats(-1.0, 1.0)
PHI = st.floats(-pi, pi)


@dataclass(frozen=True)
class Robots:
    """What is not known of two robots: phi, eps and eps' of both, a push through the wheels."""

    phi: float = 0.0
    eps: Vector2 = (0.0, 0.0)
    push: Vector2 = (0.0, 0.0)
    leader_eps: Vector2 = (0.0, 0.0)


EXACT = Robots()


def p_bar(course: PairCourse, error: np.ndarray, robots: Robots, known: bool) -> np.ndarray:
    """P_bar of (28) from h'' of (8), for the law with v = 0 and whatever it is told."""
    (h, h_rate, _), (_, _, h_bend) = course.wanted[..., 0] - error, course.wanted[..., 0]
    psi = wrap_angle(h[1])
    relative = RelativeState(h[0], psi, wrap_angle(robots.phi - psi))
    (v, omega), u_i = course.leader.twist[:, 0], course.leader.acceleration[:, 0]
    lead = apply(leader_matrix(relative), (v, omega))
    inverse, g = inverse_input_matrix(relative, D), input_matrix(relative, D)
    own = Twist(*apply(inverse, (h_rate[0] - lead[0], h_rate[1] - lead[1])))
    l_e = GAINS.distance.integral * error[0, 0], GAINS.bearing.integral * error[0, 1]
    told = apply(leader_matrix(relative), tuple(u_i)) if known else (0.0, 0.0)
    u = np.add(apply(inverse, tuple(l_e + h_bend - told)), own_velocity_terms(own, D))
    pushed = apply(leader_matrix(relative), tuple((1.0 + np.array(robots.leader_eps)) * u_i))
    bend = np.add(apply(g, tuple((1.0 + np.array(robots.eps)) * u + robots.push)), pushed)
    bend += drift(relative, Twist(v, omega), own, D)
    k_e = GAINS.distance.proportional * error[1, 0], GAINS.bearing.proportional * error[1, 1]
    return np.asarray(bend - k_e - l_e - h_bend)  # v = 0: s'' = -P_bar (26), (28)


def error_at(course: PairCourse, reach: Reach, shares: tuple[float, ...]) -> np.ndarray:
    """An error within reach."""
    error = course.error[..., 0].copy()
    error[:2] += np.array(shares).reshape(2, 2) * reach
    return error


def scaled(shares: tuple[float, float], most: tuple[float, float]) -> Vector2:
    """Both entries within their bounds."""
    return shares[0] * most[0], shares[1] * most[1]


TWO = st.tuples(SHARE, SHARE)


@given(moments(), st.tuples(SHARE, SHARE, SHARE, SHARE), PHI, TWO, TWO, TWO, st.booleans())
def test_no_robot_asks_for_more(
    moment: tuple[PairCourse, Reach], shares: tuple[float, ...], phi: float, eps: Vector2,
    push: Vector2, leader_eps: Vector2, known: bool,
) -> None:  # fmt: skip
    course, reach = moment
    pushes, most = (0.4, 3.0), (0.3, 0.3)
    leader = scaled(leader_eps, most) if known else (0.0, 0.0)  # else it drives as planned
    robots = Robots(phi, scaled(eps, most), scaled(push, pushes), leader)
    rho = demands(course, reach, GAINS, D, known).disturbance(0.3, push_length(pushes, D))[:, 0]
    asked = p_bar(course, error_at(course, reach, shares), robots, known)
    assert (np.abs(asked) <= rho * (1.0 + 1e-9) + 1e-12).all()


ENDS = [(1.0, 0.0, 0.0, 0.0), (-1.0, 0.0, 0.0, 0.0)]
GRID = [
    *product((-1.0, 1.0), np.linspace(-1.0, 1.0, 13).tolist(), (-1.0, 0.0, 1.0), (-1.0, 0.0, 1.0))
]


def worst(
    course: PairCourse, reach: Reach, errors: Shares, robots: Sequence[Robots], known: bool
) -> np.ndarray:
    """Greatest |P_bar| found for some errors within reach and some robots."""
    found = np.zeros(2)
    for share in errors:
        error = error_at(course, reach, share)
        for one in robots:
            found = np.maximum(found, np.abs(p_bar(course, error, one, known)))
    return found


STANDING_SIGHT = still(0.5 * pi, (1.0, 2.0, 0.0, 0.0), -2.0)  # z = 0: l z^2 has its low end


@settings(max_examples=40)
@example((STANDING_SIGHT, ((0.1, 0.0), (0.0, 0.5))), False)
@given(moments(), st.booleans())
def test_exact_bounds_are_reached(moment: tuple[PairCourse, Reach], known: bool) -> None:
    bound = demands(*moment, GAINS, D, known).exact[:, 0]
    assert worst(*moment, GRID, [EXACT], known) == pytest.approx(bound, rel=0.04, abs=0.01)


CORNERS = [
    Robots(float(phi), (0.3 * a, 0.3 * b), leader_eps=(0.3 * c, 0.3 * c))
    for phi in np.linspace(-pi, pi, 73)
    for a, b, c in product((-1.0, 1.0), repeat=3)
]


def test_what_model_errors_do_to_the_law_is_reached() -> None:
    course, reach = still(), ((0.1, 0.0), (0.0, 0.0))
    rho = demands(course, reach, GAINS, D, leader_known=False).disturbance(0.3, 0.0)[:, 0]
    found = worst(course, reach, ENDS, CORNERS, known=False)
    assert found[0] == pytest.approx(rho[0], rel=0.01)


def test_a_told_acceleration_may_be_wrong_twice() -> None:
    course = still(pi, (0.0, 0.0, 0.8, 0.0))  # straight behind: all of it is along the sight
    rho = demands(course, ON_COURSE, GAINS, D, leader_known=True).disturbance(0.3, 0.0)[:, 0]
    found = worst(course, ON_COURSE, ENDS, CORNERS, known=True)
    assert rho[0] == pytest.approx(2.0 * 0.3 * 0.8)
    assert found[0] == pytest.approx(rho[0], rel=0.01)


def test_what_pushes_do_is_reached() -> None:
    course, reach, length = still(), ((0.2, 0.0), (0.0, 0.0)), push_length((0.4, 3.0), D)
    pushed = [
        Robots(float(phi), push=(0.4 * a, 3.0 * b))
        for phi in np.linspace(-pi, pi, 181)
        for a, b in product((-1.0, 1.0), repeat=2)
    ]
    rho = demands(course, reach, GAINS, D, leader_known=False).disturbance(0.0, length)
    found = worst(course, reach, ENDS, pushed, known=False)
    assert found == pytest.approx(rho[:, 0], rel=1e-3)


@given(moments(), PHI, TWO)
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
    opposite = 0.25 * pi, (-most, most)
    far = model_error_matrix(found.far[0], *opposite)
    near = model_error_matrix(found.near[0], *opposite)
    assert (abs(far[0, 1]), abs(near[1, 0])) == pytest.approx(tuple(found.coupling(most)[:, 0]))
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
