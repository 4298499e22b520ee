"""A leader that nobody drives: carried by a hand in a rendered world, or driven by keys."""

from math import degrees, pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from control.actuation import Actuation
from control.errors import ControlError
from control.geometry import Pose2D
from control.keyed import KeyDrive, keyed_step
from control.plan import PathSegment, PlannedPath
from control.unicycle import Twist, UnicycleState
from datasets.carried import carried_way
from pipeline.errors import ConfigError
from pipeline.scenario import load_scenario
from pipeline.simulation.experiment import make_experiment
from tests.pipeline.runs import run_scenario

DRIVE = KeyDrive(speed=0.5, turn=2.0, ramp=1.0)


def test_robots_keep_their_places_behind_a_hand() -> None:
    _, result, moments = run_scenario("hand-led", 1)
    carried = [(r.state.x, r.state.y) for m in moments for r in m.truth if r.robot_id == 1]
    assert np.linalg.norm(np.array(carried[-1]) - carried[0]) > 0.8
    assert all(c.robot_id != 1 for m in moments for c in m.cycle.commands)
    assert result.leader is None
    for follower in result.followers:
        assert follower.settled_at_s is not None
        assert follower.distance_rms_m is not None
        assert follower.bearing_rms_rad is not None
        assert 1e3 * follower.distance_rms_m < 3.0
        assert degrees(follower.bearing_rms_rad) < 2.0
    assert result.min_clearance_m is not None
    assert 1e3 * result.min_clearance_m >= 20.0
    assert {event.kind for event in result.safety_events} <= {"kept-apart"}


def test_the_carried_are_not_driven() -> None:
    assert load_scenario("hand-led").commanded == (2, 3)
    assert load_scenario("paper", ("leader.driven_by=hand",)).commanded == (2, 3)
    assert load_scenario("paper", ("leader.driven_by=keys",)).commanded == (1, 2, 3)
    for change in ("robots.2.carried={segments=[{straight_m=1.0}]}", "leader.driven_by=plan"):
        with pytest.raises(ConfigError, match="is carried and cannot be driven"):
            load_scenario("hand-led", (change,))


def test_a_batch_knows_plans_only() -> None:
    with pytest.raises(ConfigError, match="robot 1 is carried"):
        make_experiment(load_scenario("hand-led"))
    with pytest.raises(ConfigError, match="a person drives the leader"):
        make_experiment(load_scenario("paper", ("leader.driven_by=keys",)))
    with pytest.raises(ConfigError, match="must arm it"):
        make_experiment(load_scenario("paper", ("safety.hold=true",)))


@given(st.floats(0.05, 1.0), st.floats(0.05, 3.0), st.floats(0.0, 3.0))
def test_a_carried_way_moves_as_it_says(speed: float, ramp: float, begins: float) -> None:
    path = PlannedPath(
        Pose2D(0.1, 0.2, 0.3), (PathSegment(0.4), PathSegment(0.5, 2.0)), cruise_speed=1.0
    )
    way = carried_way(path, speed, ramp, begins)
    end = begins + way.law.duration
    assert way.at(begins - 1.0) == way.at(begins)
    assert way.at(begins).v == way.at(end + 1.0).v == 0.0
    last = path.at(0.9).state
    assert (way.at(end + 1.0).x, way.at(end).y) == pytest.approx((last.x, last.y), abs=1e-9)
    h = 1e-5
    for t in np.linspace(begins, end, 17)[1:-1].tolist():
        a, here, b = way.at(t - h), way.at(t), way.at(t + h)
        assert here.v <= speed + 1e-9
        assert np.hypot(b.x - a.x, b.y - a.y) == pytest.approx(2.0 * h * here.v, abs=1e-8)
        turned = (b.theta - a.theta) / (2.0 * h)
        corner = abs(turned - here.omega) > 1e-3  # the arc begins between a and b
        assert not corner or 0.0 < turned / (2.0 * speed) < 1.0


@given(
    st.floats(-1.0, 1.0), st.floats(-4.0, 4.0), st.floats(-3.0, 3.0), st.floats(-9.0, 9.0),
    st.sampled_from((0.005, 0.01, 0.06)),
)  # fmt: skip
def test_keys_speed_up_gently_and_get_there(
    v: float, omega: float, to_v: float, to_omega: float, dt: float
) -> None:
    motors, wanted = Actuation(0.05), Twist(to_v, to_omega)
    state = UnicycleState(0.0, 0.0, pi, v, omega)
    memory, command = keyed_step(state, wanted, dt, DRIVE, motors)
    assert abs(memory.acceleration[0]) <= 0.5 + 1e-9
    assert abs(memory.acceleration[1]) <= 2.0 + 1e-9
    assert motors.acceleration(state.twist, command, dt) == pytest.approx(memory.acceleration)
    for _ in range(round(5.0 / dt)):
        memory, _ = keyed_step(state, wanted, dt, DRIVE, motors)
        a, alpha = memory.acceleration
        state = UnicycleState(0.0, 0.0, pi, state.v + a * dt, state.omega + alpha * dt)
    aim = DRIVE.limited(wanted)
    assert (state.v, state.omega) == pytest.approx((aim.v, aim.omega), abs=1e-3)


def test_keys_want_numbers() -> None:
    state = UnicycleState(0.0, 0.0, 0.0, 0.0, 0.0)
    with pytest.raises(ControlError, match="leader"):
        keyed_step(state, Twist(float("nan"), 0.0), 0.01, DRIVE, Actuation(0.05))
    with pytest.raises(ControlError, match="dt > 0"):
        keyed_step(state, Twist(0.1, 0.0), 0.0, DRIVE, Actuation(0.05))
    with pytest.raises(ControlError, match="positive"):
        KeyDrive(0.5, 0.0, 1.0)
