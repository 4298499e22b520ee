"""True motion between ticks: accurate enough to judge sub-pixel vision by."""

import numpy as np
import pytest

from control.unicycle import Twist, UnicycleState
from datasets.errors import SimulationError
from datasets.track import TruthTrack
from datasets.world import RobotPlant, World


def test_circle_at_full_speed_to_a_fiftieth_of_a_millimetre() -> None:
    v, omega = 1.0, 10.0

    def circle(t: np.ndarray) -> np.ndarray:
        angle = omega * t
        flat = np.ones_like(t)
        x, y = v / omega * np.sin(angle), v / omega * (1.0 - np.cos(angle))
        return np.column_stack((x, y, angle, v * flat, omega * flat))[:, None]

    ticks, between = np.arange(0.0, 1.0, 0.005), np.linspace(0.0, 0.994, 1777)
    off = TruthTrack(ticks, circle(ticks)).at(between) - circle(between)[..., :3]
    assert np.hypot(off[..., 0], off[..., 1]).max() < 2e-5  # m
    assert np.abs(off[..., 2]).max() < 1e-9  # rad


def test_lagged_robot_with_jumping_commands() -> None:
    """Accelerations jump at every tick, as under a real law."""
    world = World((RobotPlant(1, UnicycleState(0.0, 0.0, 0.0, 0.0, 0.0)),))
    rng = np.random.default_rng(1)
    times, states, asked, true = [], [], [], []
    for k in range(400):
        world.advance(0.005 * k)
        s = world.truth()[0].state
        times.append(0.005 * k)
        states.append([(s.x, s.y, s.theta, s.v, s.omega)])
        world.command(1, Twist(rng.uniform(0.0, 1.5), rng.uniform(-15.0, 15.0)), 0.005 * k)
        world.advance(0.005 * k + 0.0023)
        s = world.truth()[0].state
        asked.append(0.005 * k + 0.0023)
        true.append((s.x, s.y, s.theta))
    poses = TruthTrack(np.array(times), np.array(states)).at(np.array(asked[:-1]))[:, 0]
    off = poses - np.array(true[:-1])
    assert np.hypot(off[:, 0], off[:, 1]).max() < 2e-5  # m
    assert np.abs(off[:, 2]).max() < 5e-4  # rad


def test_ends_hold_and_single_states_work() -> None:
    track = TruthTrack(np.array([1.0]), np.array([[[0.1, 0.2, 0.3, 1.0, 1.0]]]))
    np.testing.assert_allclose(track.at(np.array([0.0, 5.0]))[:, 0], [[0.1, 0.2, 0.3]] * 2)


def test_shapes_and_times_are_checked() -> None:
    with pytest.raises(SimulationError, match="must ascend"):
        TruthTrack(np.array([0.0, 0.0]), np.zeros((2, 1, 5)))
    with pytest.raises(SimulationError, match="track of 2"):
        TruthTrack(np.array([0.0, 1.0]), np.zeros((3, 1, 5)))
