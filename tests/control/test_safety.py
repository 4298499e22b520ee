"""The filter that keeps bodies apart: idle when far, the least change when near, no contact."""

from math import cos, hypot, pi, sin

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from control.actuation import Actuation, DriveGain
from control.barriers import all_far, corner_rows
from control.errors import ControlError
from control.safety import Arena, Clearance, Floats, keep_apart
from control.unicycle import SpeedLimits, Twist, UnicycleState, advance_lagged
from datasets.bodies import pair_gaps
from vision.compiled import compiled

CLEARANCE, OPEN = Clearance(), Arena()
SIDE = 2.0 * CLEARANCE.half_side
LIMITS = np.array([1.5, 15.0])
fast = compiled(keep_apart)

SEEDS = st.integers(0, 2**32 - 1)


def crowd(seed: int, count: int, room: float) -> tuple[Floats, Floats]:
    """Robots that do not overlap within a square of a size [m], and velocities."""
    rng = np.random.default_rng(seed)
    for _ in range(200):
        poses = np.column_stack((rng.uniform(-room, room, (count, 2)), rng.uniform(-pi, pi, count)))
        if count == 1 or pair_gaps(poses, np.full(count, SIDE)).min() > 0.023:
            return poses, rng.uniform(-1.0, 1.0, (count, 2)) * (1.0, 8.0)
    raise AssertionError("no room")


def filtered(
    poses: Floats, twists: Floats, freedoms: Floats | None = None, arena: Arena = OPEN
) -> Floats:
    """The filter with wide limits; all give way alike unless told."""
    wide = np.broadcast_to(LIMITS, twists.shape).copy()
    free = np.ones(len(poses)) if freedoms is None else freedoms
    return fast(poses, twists, -wide, wide, free, CLEARANCE, arena)


def moved(poses: Floats, twists: Floats, dt: float) -> Floats:
    """Poses a short moment later."""
    x, y, theta = poses.T
    v, omega = twists.T
    middle = theta + 0.5 * dt * omega
    return np.column_stack(
        (x + dt * v * np.cos(middle), y + dt * v * np.sin(middle), theta + dt * omega)
    )


@given(SEEDS, st.integers(2, 5))
def test_no_gap_closes_faster_than_it_may(seed: int, count: int) -> None:
    poses, twists = crowd(seed, count, 0.25)
    safe, sides, dt = filtered(poses, twists), np.full(count, SIDE), 1e-6
    before, after = (pair_gaps(p, sides) for p in (poses, moved(poses, safe, dt)))
    allowed = -CLEARANCE.rate * np.maximum(before - CLEARANCE.distance, 0.0)
    assert ((after - before) / dt >= allowed - 1e-3).all()  # m/s
    assert (np.abs(safe) <= LIMITS + 1e-6).all()


@given(SEEDS, st.integers(2, 5))
def test_what_is_slow_enough_is_left_alone_to_the_last_bit(seed: int, count: int) -> None:
    poses, twists = crowd(seed, count, 0.4)
    gaps = pair_gaps(poses, np.full(count, SIDE))
    reach = np.abs(twists) @ (1.0, 0.054)  # of a corner [m/s]
    first, second = np.triu_indices(count, 1)
    assume((gaps - CLEARANCE.distance > (reach[first] + reach[second]) / CLEARANCE.rate).all())
    assert filtered(poses, twists).tobytes() == twists.tobytes()


@settings(max_examples=20)
@given(SEEDS)
def test_the_change_is_the_least(seed: int) -> None:
    poses, twists = crowd(seed, 3, 0.13)
    safe = filtered(poses, twists)
    weights = np.array([1.0, CLEARANCE.arm])

    def cost(flat: Floats) -> float:
        return float((((flat.reshape(-1, 2) - twists) * weights) ** 2).sum())

    def room(flat: Floats) -> Floats:
        return np.concatenate(
            [
                corner_rates(poses, flat.reshape(-1, 2)),
                (LIMITS - flat.reshape(-1, 2)).ravel(),
                (LIMITS + flat.reshape(-1, 2)).ravel(),
            ]
        )

    best = minimize(cost, np.zeros(6), constraints={"type": "ineq", "fun": room}, method="SLSQP")
    assume(best.success)
    assert cost(safe.ravel()) <= cost(best.x) * (1.0 + 1e-3) + 1e-6


def corner_rates(poses: Floats, twists: Floats) -> Floats:
    """h' + rate (h - clearance) of every corner against every other body, by differences."""
    dt = 1e-6
    now, then = corner_gaps(poses), corner_gaps(moved(poses, twists, dt))
    return (then - now) / dt + CLEARANCE.rate * np.maximum(now - CLEARANCE.distance, 0.0)


def corner_gaps(poses: Floats) -> Floats:
    """Distance of every corner to every other body [m]."""
    half, gaps = CLEARANCE.half_side, []
    for i, (x, y, theta) in enumerate(poses):
        for j, (u, v, phi) in enumerate(poses):
            for a, b in ((half, half), (half, -half), (-half, half), (-half, -half)):
                if i != j:
                    cx, cy = (
                        x + a * cos(theta) - b * sin(theta),
                        y + a * sin(theta) + b * cos(theta),
                    )
                    dx, dy = cx - u, cy - v
                    p, q = dx * cos(phi) + dy * sin(phi), dy * cos(phi) - dx * sin(phi)
                    gaps.append(hypot(max(abs(p) - half, 0.0), max(abs(q) - half, 0.0)))
    return np.array(gaps)


@given(SEEDS, st.floats(-pi, pi), st.booleans())
def test_turning_and_mirroring_the_scene_turns_and_mirrors_the_answer(
    seed: int, turn: float, mirror: bool
) -> None:
    poses, twists = crowd(seed, 3, 0.15)
    side = -1.0 if mirror else 1.0
    x, y, theta = poses[:, 0], side * poses[:, 1], side * poses[:, 2]
    c, s = cos(turn), sin(turn)
    other = np.column_stack((c * x - s * y + 0.3, s * x + c * y - 0.1, theta + turn))
    expected = filtered(poses, twists) * (1.0, side)
    np.testing.assert_allclose(
        filtered(other, twists * (1.0, side)), expected, atol=0.02
    )  # sweeps end


@settings(max_examples=20)
@given(SEEDS)
def test_python_and_machine_code_agree(seed: int) -> None:
    poses, twists = crowd(seed, 3, 0.15)
    wide, free = np.broadcast_to(LIMITS, (3, 2)).copy(), np.ones(3)
    slow = keep_apart(poses, twists, -wide, wide, free, CLEARANCE, OPEN)
    np.testing.assert_allclose(filtered(poses, twists), slow, atol=1e-9)


@settings(max_examples=30)
@given(SEEDS)
def test_motors_are_asked_for_what_they_can_reach(seed: int) -> None:
    poses, twists = crowd(seed, 3, 0.15)
    reach = np.array((0.05, 0.4))
    low, high = twists - reach, twists + reach
    safe = fast(poses, twists, low, high, np.ones(3), CLEARANCE, OPEN)
    slowed = np.abs(safe) < np.abs(twists)  # braking may go beyond what was hoped, towards 0
    assert (slowed | ((safe >= low - 1e-5) & (safe <= high + 1e-5))).all()


@given(SEEDS)
def test_who_cannot_give_way_is_left_alone_and_the_other_does(seed: int) -> None:
    poses, twists = crowd(seed, 2, 0.1)
    safe = filtered(poses, twists, np.array([0.0, 1.0]))
    assert (safe[0] == twists[0]).all()
    alone = np.array([[0.0, 0.0], twists[1]])
    safe = filtered(poses, alone, np.array([0.0, 1.0]))
    assert (corner_rates(poses, safe) > -1e-3).all()


@settings(max_examples=20)
@given(SEEDS, st.integers(1, 3))
def test_nobody_leaves_the_arena(seed: int, count: int) -> None:
    poses, _ = crowd(seed, count, 0.3)
    reach = SIDE * 0.71 + CLEARANCE.distance
    arena = Arena(
        poses[:, 0].min() - reach - 0.01, poses[:, 1].min() - reach,
        poses[:, 0].max() + reach, poses[:, 1].max() + reach + 0.02,
    )  # fmt: skip
    poses = drive(poses, 2.0, seed, arena)
    turned = np.abs(np.cos(poses[:, 2])) + np.abs(np.sin(poses[:, 2]))
    half = 0.5 * SIDE * turned
    assert (poses[:, 0] - half > arena.x_low + 0.018).all()
    assert (poses[:, 1] - half > arena.y_low + 0.018).all()
    assert (poses[:, 0] + half < arena.x_high - 0.018).all()
    assert (poses[:, 1] + half < arena.y_high - 0.018).all()


@settings(max_examples=20)
@given(SEEDS, st.integers(2, 4))
def test_bodies_never_touch_whatever_is_commanded(seed: int, count: int) -> None:
    poses, _ = crowd(seed, count, 0.2)
    drive(poses, 2.0, seed, OPEN)


def drive(poses: Floats, seconds: float, seed: int, arena: Arena) -> Floats:
    """Drive at random, twists new every 0.3 s, motors with a lag; bodies keep 18 mm."""
    rng, motors, dt = np.random.default_rng(seed), Actuation(0.05, SpeedLimits(1.5, 15.0)), 0.01
    states = [UnicycleState(*pose, 0.0, 0.0) for pose in poses.tolist()]
    sides, gain = np.full(len(states), SIDE), DriveGain()
    for k in range(round(seconds / dt)):
        if k % 30 == 0:
            wanted = rng.uniform(-1.0, 1.0, (len(states), 2)) * (1.0, 8.0)
        own = [state.twist for state in states]
        ways = [motors.reachable(twist, dt, gain) for twist in own]
        low, high = (np.array([(w[i].v, w[i].omega) for w in ways]) for i in (0, 1))
        now = np.array([(s.x, s.y, s.theta) for s in states])
        goal = np.clip(wanted, low, high)
        safe = fast(now, goal, low, high, np.ones(len(states)), CLEARANCE, arena)
        for i, (v, omega) in enumerate(safe.tolist()):
            u = (v - own[i].v) / dt, (omega - own[i].omega) / dt
            command, _ = motors.command(own[i], u, dt, gain)
            states[i] = advance_lagged(states[i], command, dt, motors.lag)
        poses = np.array([(s.x, s.y, s.theta) for s in states])
        if len(states) > 1:
            assert pair_gaps(poses, sides).min() > 0.018
    return poses


@given(
    st.floats(0.08, 0.6), st.floats(-pi, pi), st.floats(-pi, pi), st.floats(-pi, pi),
    *[st.floats(-1.5, 1.5)] * 2, *[st.floats(-6.0, 6.0)] * 2,
)  # fmt: skip
@settings(max_examples=2000)
def test_who_is_seen_to_be_far_breaks_no_row(
    apart: float, at: float, one: float, other: float, v: float, u: float, w: float, z: float
) -> None:
    poses = np.array([(0.0, 0.0, one), (apart * cos(at), apart * sin(at), other)])
    twists, free = np.array([(v, w), (u, z)]), np.ones(2)
    if all_far(poses, twists, free, CLEARANCE, OPEN):
        for i, j, iv, iw, jv, jw, least in corner_rows(poses, twists, free, CLEARANCE, OPEN):
            rate = iv * twists[i, 0] + iw * twists[i, 1] + jv * twists[j, 0] + jw * twists[j, 1]
            assert rate >= least - 1e-12


def test_bodies_too_near_may_part_but_not_come_closer() -> None:
    poses = np.array([[0.0, 0.0, 0.0], [0.08, 0.0, pi]])  # 5 mm between them
    apart = np.array([[-0.3, 0.0], [-0.3, 0.0]])
    assert (filtered(poses, apart) == apart).all()
    assert np.abs(filtered(poses, -apart)[:, 0]).max() < 1e-6


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Arena(1.0, 0.0, 0.0, 1.0), "low < high"),
        (lambda: Clearance(-0.01), "clearance >= 0"),
        (lambda: Clearance(rate=0.0), "clearance >= 0"),
    ],
)
def test_what_is_refused(make: object, message: str) -> None:
    with pytest.raises(ControlError, match=message):
        make()  # type: ignore[operator]


@given(st.floats(-1.5, 1.5), st.floats(-15, 15), st.floats(0.002, 0.1))
def test_what_motors_can_reach(v: float, omega: float, dt: float) -> None:
    motors, own, gain = Actuation(), Twist(v, omega), DriveGain(0.9, 1.1)
    low, high = motors.reachable(own, dt, gain)
    for sign, ends in ((-1.0, low), (1.0, high)):
        _, u = motors.command(own, (sign * 1e6, sign * 1e6), dt, gain)
        assert own.v + dt * u[0] == pytest.approx(ends.v, abs=1e-9)
        assert own.omega + dt * u[1] == pytest.approx(ends.omega, abs=1e-9)


def test_a_robot_that_cannot_obey_slows_those_it_is_near_and_nobody_else() -> None:
    """The first is over the border and cannot turn back within the period."""
    poses = np.array([[1.0, 0.0, 0.0], [0.85, 0.0, 0.0], [-1.0, 0.0, 0.3], [-1.0, 0.2, 0.3]])
    twists = np.array([[0.8, 0.0], [0.7, 0.0], [0.5, 1.0], [0.5, 0.0]])
    near = np.array([0.1, 1.0])
    arena = Arena(-2.0, -2.0, 1.03, 2.0)
    safe = fast(poses, twists, twists - near, twists + near, np.ones(4), CLEARANCE, arena)
    assert np.abs(safe[:2]).max() < 0.1 * np.abs(twists[:2]).max()
    np.testing.assert_array_equal(safe[2:], twists[2:])


def test_a_body_square_to_a_side_may_turn_away_from_it() -> None:
    """At the very border, along it: no corner may come nearer, but it must get away again."""
    arena = Arena(-1.0, -0.5, 1.0, 0.5)
    y = arena.y_low + CLEARANCE.half_side * 2**0.5 + CLEARANCE.distance
    away = filtered(np.array([[0.0, y, 0.0]]), np.array([[0.5, 4.0]]), arena=arena)
    np.testing.assert_array_equal(away, [[0.5, 4.0]])
    out = filtered(np.array([[0.0, y, -0.3]]), np.array([[0.5, 4.0]]), arena=arena)
    assert out[0, 0] == pytest.approx(0.0, abs=1e-6)
    assert out[0, 1] == pytest.approx(4.0)
