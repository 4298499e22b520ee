"""Simulated robots: model (3), exact times, and independence of how the world is driven."""

from dataclasses import replace
from math import cos, exp, hypot, pi, sin

import numpy as np
import pytest

from control.geometry import Pose2D
from control.unicycle import SpeedLimits, Twist, UnicycleState
from datasets.errors import SimulationError
from datasets.world import MEMORY, Disturbance, RobotPlant, World

REST = UnicycleState(0.1, -0.2, 0.4, 0.0, 0.0)
PLANT = RobotPlant(1, REST, lag=0.05, mass_error=0.1, inertia_error=-0.1)


def only(world: World, t: float | None = None) -> UnicycleState:
    """State of the first robot."""
    return (world.truth() if t is None else world.states(t))[0].state


def test_velocities_follow_model_3() -> None:
    world = World((PLANT,))
    world.command(1, Twist(0.5, 2.0), 0.1234)
    world.advance(0.5)
    rise = 1.0 - exp(-(0.5 - 0.1234) / 0.05)
    assert only(world).v == pytest.approx(1.1 * 0.5 * rise, abs=1e-12)
    assert only(world).omega == pytest.approx(0.9 * 2.0 * rise, abs=1e-12)


def test_nothing_moves_before_the_command_arrives() -> None:
    world = World((PLANT,))
    world.command(1, Twist(0.5, 2.0), 0.1234)
    world.advance(0.1234)
    assert only(world) == REST


def test_positions_agree_with_a_fine_integration() -> None:
    """Against 10 us steps of model (3), commands changing off the grid."""
    world = World((PLANT,))
    commands = [(0.0111, Twist(1.2, 9.0)), (0.2037, Twist(-0.7, -14.0)), (0.4, Twist(1.5, 3.0))]
    for t, twist in commands:
        world.command(1, twist, t)
    world.advance(0.6)
    x, y, theta, v, omega, h = 0.1, -0.2, 0.4, 0.0, 0.0, 1e-5
    target = Twist(0.0, 0.0)
    for k in range(60_000):
        target = next((c for t, c in reversed(commands) if t <= k * h + 1e-9), target)
        dv, dw = (1.1 * target.v - v) / 0.05, (0.9 * target.omega - omega) / 0.05
        vm, wm = v + 0.5 * h * dv, omega + 0.5 * h * dw  # midpoint rule
        middle = theta + 0.5 * h * omega
        x, y, theta = x + h * vm * cos(middle), y + h * vm * sin(middle), theta + h * wm
        v, omega = (
            v + h * (1.1 * target.v - vm) / 0.05,
            omega + h * (0.9 * target.omega - wm) / 0.05,
        )
    end = only(world)
    assert hypot(end.x - x, end.y - y) < 1e-6  # m; the midpoint rule's own error
    assert end.theta == pytest.approx(theta, abs=1e-6)


def test_circle_closes() -> None:
    state = UnicycleState(0.0, 0.0, 0.0, 0.5, 2.0)
    world = World((RobotPlant(1, state),))
    world.advance(pi)
    assert hypot(only(world).x, only(world).y) < 1e-9


def test_initial_twist_lasts_until_the_first_command() -> None:
    world = World((replace(PLANT, start=replace(REST, v=0.3, omega=-1.0)),))
    world.command(1, Twist(0.3, -1.0), 2.0)
    world.advance(2.0)
    assert only(world).twist == Twist(0.3, -1.0)  # no gain error: nobody has commanded it
    world.advance(3.0)
    assert only(world).v == pytest.approx(0.33, abs=1e-8)


@pytest.mark.parametrize("step", [0.001, 0.0073, 0.033, 1.0])
def test_motion_does_not_depend_on_the_steps(step: float) -> None:
    """Bit for bit, disturbances included."""

    def end(steps: list[float]) -> UnicycleState:
        world = World((replace(PLANT, disturbance=Disturbance(1.0, 5.0)),), seed=4)
        for k in range(40):
            world.command(1, Twist(sin(k), 3.0 * cos(k)), 0.025 * k + 0.0031)
        for t in steps:
            world.advance(t)
        return only(world)

    assert end([*np.arange(step, 1.0, step).tolist(), 1.0]) == end([1.0])


def test_commands_never_act_in_the_past() -> None:
    world = World((PLANT,))
    world.advance(0.5021)
    world.command(1, Twist(1.0, 0.0), 0.1)
    before = only(world)
    world.advance(0.5321)
    assert before.v == 0.0
    assert only(world).v == pytest.approx(1.1 * (1.0 - exp(-0.03 / 0.05)), abs=1e-12)


def test_later_arrival_supersedes_whatever_the_order_of_sending() -> None:
    world = World((PLANT,))
    world.command(1, Twist(0.2, 0.0), 0.2)
    world.command(1, Twist(-0.5, 0.0), 0.1)
    world.advance(2.0)
    assert only(world).v == pytest.approx(0.22, abs=1e-9)


def test_states_of_the_recent_past() -> None:
    world = World((PLANT,))
    world.command(1, Twist(1.0, 3.0), 0.0)
    seen = []
    for k in range(1, 400):
        world.advance(0.005 * k)
        seen.append((0.005 * k, only(world)))
    for t, state in seen[-150:]:
        assert only(world, t) == state
    world.advance(world.t + 0.0042)
    assert only(world, seen[-1][0]) == seen[-1][1]
    with pytest.raises(SimulationError, match="asked for"):
        world.states(world.t + 0.1)
    with pytest.raises(SimulationError, match="asked for"):
        world.states(world.t - MEMORY - 0.1)


def test_wheels_limit_the_commands() -> None:
    world = World((replace(PLANT, limits=SpeedLimits(1.0, 5.0)),))
    world.command(1, Twist(9.0, -90.0), 0.0)
    world.advance(2.0)
    assert only(world).v == pytest.approx(1.1, abs=1e-9)
    assert only(world).omega == pytest.approx(-4.5, abs=1e-9)


def test_without_lag_velocities_jump() -> None:
    world = World((replace(PLANT, lag=0.0),))
    world.command(1, Twist(0.5, 0.0), 0.1)
    world.advance(1.1)
    assert only(world).v == pytest.approx(0.55)
    assert hypot(only(world).x - 0.1, only(world).y + 0.2) == pytest.approx(0.55, abs=1e-12)


def test_disturbances_are_seeded_felt_and_bounded() -> None:
    def speeds(seed: int, bound: float) -> np.ndarray:
        world = World((replace(PLANT, disturbance=Disturbance(bound, 0.0)),), seed)
        world.command(1, Twist(0.5, 0.0), 0.0)
        values = []
        for k in range(1, 800):
            world.advance(0.005 * k)
            values.append(only(world).v)
        return np.array(values)

    calm, pushed = speeds(1, 0.0), speeds(1, 2.0)
    assert 0.02 < np.abs(pushed - calm).max() <= 2.0 * 0.05  # |pi| lag [m/s]
    np.testing.assert_array_equal(pushed, speeds(1, 2.0))
    assert np.abs(pushed - speeds(2, 2.0)).max() > 0.01


def test_contacts_are_reported_and_not_undone() -> None:
    ahead = replace(PLANT, robot_id=2, start=UnicycleState(0.15, 0.0, 0.0, 0.0, 0.0))
    world = World((replace(PLANT, start=UnicycleState(0.0, 0.0, 0.0, 0.5, 0.0)), ahead))
    assert world.clearance() == pytest.approx(0.075, abs=1e-12)
    world.advance(0.2)
    assert world.clearance() == pytest.approx(-0.025, abs=1e-9)
    assert only(world).x == pytest.approx(0.1, abs=1e-9)


def test_wrong_use_is_refused() -> None:
    world = World((PLANT,))
    with pytest.raises(SimulationError, match="no robot 7"):
        world.command(7, Twist(0.0, 0.0), 0.0)
    with pytest.raises(SimulationError, match="command"):
        world.command(1, Twist(float("nan"), 0.0), 0.0)
    with pytest.raises(SimulationError, match="no id twice"):
        World((PLANT, PLANT))
    with pytest.raises(SimulationError, match="lag -1"):
        replace(PLANT, lag=-1.0)
    with pytest.raises(SimulationError, match="timeout 0"):
        replace(PLANT, timeout=0.0)


def test_a_robot_without_commands_stops_itself_at_its_timeout() -> None:
    obeying, deaf = World((replace(PLANT, timeout=0.3),)), World((PLANT,))
    for world in (obeying, deaf):
        world.command(1, Twist(0.5, 2.0), 0.1)
        world.command(1, Twist(0.5, 1.0), 0.2234)
        world.advance(0.5234)
    assert only(obeying) == only(deaf)  # to the last bit, until then
    told = World((PLANT,))
    for t, twist in ((0.1, Twist(0.5, 2.0)), (0.2234, Twist(0.5, 1.0)), (0.5234, Twist(0.0, 0.0))):
        told.command(1, twist, t)
    for world in (obeying, deaf, told):
        world.advance(1.4)
    assert only(obeying).v == pytest.approx(only(told).v, abs=1e-12)
    assert abs(only(obeying).v) < 1e-6
    assert only(obeying).x == pytest.approx(only(told).x, abs=1e-9)
    assert only(deaf).v == pytest.approx(0.55)


def test_commands_that_keep_coming_keep_a_robot_driving() -> None:
    world = World((replace(PLANT, timeout=0.3),))
    for k in range(10):
        world.command(1, Twist(0.5, 0.0), 0.3 * k)  # each at the very end of the patience
    world.advance(2.95)
    assert only(world).v == pytest.approx(0.55)


def test_a_robot_that_is_put_elsewhere_stands_there_and_was_where_it_was() -> None:
    world = World((PLANT,))
    world.command(1, Twist(0.5, 0.0), 0.0)
    world.advance(0.5)
    before = only(world, 0.49)
    world.place(1, Pose2D(1.0, 2.0, -0.5))
    assert only(world) == UnicycleState(1.0, 2.0, -0.5, 0.0, 0.0)
    assert only(world, 0.49) == before
    world.command(1, Twist(0.0, 0.0), 0.5)
    world.advance(0.7)
    assert (only(world).x, only(world).y) == (1.0, 2.0)
    with pytest.raises(SimulationError, match="no robot 7"):
        world.place(7, Pose2D(0.0, 0.0, 0.0))
