"""The output of a follower: h'' = G (u - own) + F_i + E u_i, for one leader and for two."""

from math import cos, pi, sin

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from control.output import (
    MIN_SINE,
    FollowerOutput,
    LeaderMotion,
    follower_output,
    two_leaders_output,
)
from control.relative import RelativeState, Vector2, apply, relative_state
from control.unicycle import Twist, UnicycleState

D = 0.05
Accelerations = tuple[Vector2, Vector2, Vector2]  # of the leaders i and j, and of the follower
PLACE = st.builds(
    UnicycleState, st.floats(-0.2, 0.2), st.floats(-0.2, 0.2), st.floats(-pi, pi),
    st.floats(-1.0, 1.0), st.floats(-3.0, 3.0),
)  # fmt: skip
ACCELERATION = st.tuples(st.floats(-2, 2), st.floats(-10, 10))


def later(state: UnicycleState, u: Vector2, t: float) -> UnicycleState:
    """State after a short time under constant accelerations, by small exact steps."""

    def rates(_: float, q: list[float]) -> list[float]:
        return [q[3] * cos(q[2]), q[3] * sin(q[2]), q[4], *u]

    start = [state.x, state.y, state.theta, state.v, state.omega]
    end = solve_ivp(rates, (0.0, t), start, rtol=1e-12, atol=1e-14).y[:, -1]
    return UnicycleState(*end.tolist())


def output_of(
    leaders: list[UnicycleState], follower: UnicycleState, u: list[Vector2]
) -> FollowerOutput:
    """Output of a follower with known leaders."""
    relatives = [relative_state(i.pose, follower.pose, D) for i in leaders]
    motions = [LeaderMotion(i.twist, a) for i, a in zip(leaders, u, strict=True)]
    return follower_output(relatives, follower.twist, motions, D)


def apart(state: UnicycleState, x: float, y: float) -> UnicycleState:
    """The state moved on the floor."""
    return UnicycleState(state.x + x, state.y + y, state.theta, state.v, state.omega)


@pytest.mark.parametrize("count", [1, 2])
@given(PLACE, PLACE, PLACE, ACCELERATION, ACCELERATION, ACCELERATION)
def test_h_moves_as_its_parts_say(
    count: int, i: UnicycleState, j: UnicycleState, k: UnicycleState,
    ui: Vector2, uj: Vector2, uk: Vector2,
) -> None:  # fmt: skip
    leaders, pushes = [apart(i, 0.8, 0.3), apart(j, 0.6, -0.9)][:count], [ui, uj][:count]
    o = output_of(leaders, k, pushes)
    step = 1e-3
    after, before = (
        output_of(
            [later(a, u, t) for a, u in zip(leaders, pushes, strict=True)], later(k, uk, t), pushes
        ).h
        for t in (step, -step)
    )
    g = apply(o.input_matrix, (uk[0] - o.own[0], uk[1] - o.own[1]))
    for n in (0, 1):
        ahead, behind = after[n] - o.h[n], o.h[n] - before[n]
        if o.turns and n == 1:  # across the cut at pi
            ahead, behind = (a - 2 * pi * round(a / (2 * pi)) for a in (ahead, behind))
        assert (ahead + behind) / (2 * step) == pytest.approx(o.rate[n], abs=2e-3)
        bend = (ahead - behind) / step**2
        assert bend == pytest.approx(g[n] + o.drift[n] + o.push[n], abs=2e-2, rel=1e-3)


@given(PLACE, PLACE, PLACE)
def test_the_inverse_inverts(i: UnicycleState, j: UnicycleState, k: UnicycleState) -> None:
    for count in (1, 2):
        leaders = [apart(i, 0.8, 0.3), apart(j, 0.6, -0.9)][:count]
        o = output_of(leaders, k, [(0.0, 0.0)] * count)
        x, y = apply(o.inverse, apply(o.input_matrix, (0.3, -0.7)))
        assert (x, y) == pytest.approx((0.3, -0.7), abs=1e-9)


@given(st.floats(-pi, pi), st.floats(-pi, pi))
def test_in_line_with_both_leaders_the_inverse_stays_bounded(psi: float, heading: float) -> None:
    states = RelativeState(0.3, psi, heading), RelativeState(0.5, psi, heading)
    standing = LeaderMotion(Twist(0, 0), (0.0, 0.0))
    o = two_leaders_output(states, Twist(0, 0), (standing, standing), D)
    assert max(abs(x) for row in o.inverse for x in row) <= 1.0 / (MIN_SINE * D) + 1e-9


def test_a_robot_on_its_leader_has_finite_parts() -> None:
    o = output_of([UnicycleState(0.05, 0, 0, 0.5, 1.0)], UnicycleState(0, 0, 0, 0.5, 9.0), [(1, 1)])
    assert o.h[0] == 0.0
    assert max(map(abs, (*o.rate, *o.drift, *o.push))) < 100.0
