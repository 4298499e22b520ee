"""Simulated runs against the loop of `live`, tick by tick; and what they do not depend on.

The loop in Python gets the same poses as the machine code. Both add up in different orders, so the
last bits differ, and a closed loop carries them on: states agree to 1e-9 m, rad and per s.
"""

from dataclasses import astuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from control.actuation import DriveGain
from control.estimation import roll
from control.history import SentCommands
from control.motion_model import MotionModel
from control.unicycle import Twist, UnicycleState
from datasets.cycle import Moment
from datasets.simulation.filters import roll_ahead
from datasets.simulation.inputs import Floats
from pipeline.errors import ConfigError
from pipeline.scenario import load_scenario
from pipeline.simulation.draw import Drawer
from pipeline.simulation.experiment import Experiment, make_experiment
from pipeline.simulation.moments import moments_of
from pipeline.simulation.result import FIGURES, run_result
from pipeline.simulation.runs import batches, run_some
from pipeline.simulation.sweep import combinations, parse_axes
from tests.pipeline.poses_only import run_in_python
from vision.compiled import compiled

PAPER = load_scenario("paper")
SAME = 1e-9
ROUGH = (
    "camera.dropped_share=0.5",
    "camera.stamp_jitter_s=0.004",
    "robots.2.disturbance_mps2=1.0",
    "robots.3.turn_disturbance_radps2=2.0",
)
HELD = ("camera.dropped_share=0.75", "safety.arena_m=[-0.6, -0.5, 0.9, 0.8]", "radio.loss=0.05")
LAWS = (
    "robots.2.law=super-twisting", "robots.3.law=first-order-implicit", "leader.law=saturated",
    "control.command_period_s=0.033", "radio.delay_s=0.012",
)  # fmt: skip


def states(experiment: Experiment, moments: list[Moment]) -> Floats:
    """True states of the formation's robots, shape (T, R, 5)."""
    ids = experiment.setup.formation.robots
    return np.array([
        [
            (s.x, s.y, s.theta, s.v, s.omega)
            for s in ({r.robot_id: r.state for r in moment.truth}[robot] for robot in ids)
        ]
        for moment in moments
    ])  # fmt: skip


@pytest.mark.parametrize(
    ("name", "seed", "changes", "duration"),
    [
        ("paper", 0, (), 6.0),
        ("paper", 1, ROUGH, 4.0),
        ("paper", 2, HELD, 6.0),
        ("paper", 3, LAWS, None),
        ("diamond", 4, ("radio.loss=0.2",), 2.0),
        ("moving-start", 5, ("camera.repeated_share=0.2",), 2.0),
        ("obstacle", 6, (), 2.0),
    ],
)
def test_a_run_is_the_run_of_the_live_loop(
    name: str, seed: int, changes: tuple[str, ...], duration: float | None
) -> None:
    experiment = make_experiment(load_scenario(name, changes), duration)
    drawn = Drawer(experiment).draw([seed])
    batch = run_some(experiment, drawn)
    wanted, moments = run_in_python(experiment, drawn, seed)
    assert batch.drawn.timetables[0].ticks == len(moments)
    true = states(experiment, moments)
    assert np.abs(batch.trace.states[0, : len(true)] - true).max() < SAME
    for mine, its in zip(moments_of(experiment, batch), moments, strict=True):
        assert mine.cycle.phase == its.cycle.phase
        assert len(mine.cycle.commands) == len(its.cycle.commands)
        for one, other in zip(mine.cycle.commands, its.cycle.commands, strict=True):
            assert one.robot_id == other.robot_id
            assert one.t_effective == pytest.approx(other.t_effective, abs=1e-12)
            assert one.twist.omega == pytest.approx(other.twist.omega, abs=SAME)
    result = run_result(experiment, batch, 0.0)
    assert result.safety_events == wanted.safety_events
    assert (result.frames, result.commands_sent) == (wanted.frames, wanted.commands_sent)
    assert result.notes == wanted.notes
    for mine_, its_ in zip(result.followers, wanted.followers, strict=True):
        for figure in FIGURES:
            one_, other_ = getattr(mine_, figure), getattr(its_, figure)
            assert (one_ or 0.0) == pytest.approx(other_ or 0.0, abs=SAME), figure
            assert (one_ is None) == (other_ is None), figure
    assert result.leader is not None
    assert wanted.leader is not None
    assert result.leader.position_rms_m == pytest.approx(wanted.leader.position_rms_m, abs=SAME)
    assert result.min_clearance_m == pytest.approx(wanted.min_clearance_m, abs=SAME)


def test_a_run_is_its_seed_whatever_runs_beside_it() -> None:
    experiment = make_experiment(load_scenario("paper", ROUGH), 1.0)
    together = [batch.trace for batch in batches(experiment, range(5))]
    (alone,) = batches(experiment, [3])
    for one, *some in zip(alone.trace, *together, strict=True):
        assert one[0].tobytes() == np.concatenate(some)[3].tobytes()
    true = np.concatenate([trace.states for trace in together])
    assert true[2].tobytes() != true[3].tobytes()


fast_roll, HOST = compiled(roll_ahead), make_experiment(PAPER).host


@settings(deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.0, 0.3), st.floats(0.0, 0.2), st.integers(0, 12))
def test_rolling_through_a_table_is_rolling_through_sent_commands(
    seed: int, t0: float, length: float, first: int
) -> None:
    rng, host = np.random.default_rng(seed), HOST
    sent, table = SentCommands(), rng.normal(size=(30, 2, 2))
    for tick in range(first, 30):
        sent = sent.append(tick * host.period + host.delay, Twist(*table[tick, 1].tolist()))
    ahead, means = rng.normal(size=(2, 5)), np.tile((0.0, 0.0, 0.0, 0.0, 0.0, 1.1, 0.9), (2, 1))
    state, gain = UnicycleState(*ahead[1].tolist()), DriveGain(1.1, 0.9)
    slow = roll(state, t0, t0 + length, sent, MotionModel(host.motion.lag), gain)
    fast_roll(ahead, means, host, t0, t0 + length, table, (first, 30))
    assert ahead[1].tolist() == pytest.approx(astuple(slow), rel=1e-12, abs=1e-12)


def test_combinations_of_sweeps() -> None:
    axes = parse_axes(["camera.latency_s=0.04, 0.08", "control.proportional=[2,2],[4,4]"])
    assert [tuple(swept.values()) for swept in combinations(axes)] == [
        ("0.04", "[2,2]"),
        ("0.04", "[4,4]"),
        ("0.08", "[2,2]"),
        ("0.08", "[4,4]"),
    ]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("camera.latency_s", "need"),
        ("camera.latency_s=0.04,", "need"),
        ("sensor.read_noise=1,2", 'reads no key "sensor.read_noise"'),
        ("camera.latency=0.1", 'did you mean "camera.latency_s"?'),
        ("robots.2.colors=red", 'reads no key "robots.2.colors"'),
    ],
)
def test_what_cannot_be_swept_is_named(text: str, said: str) -> None:
    with pytest.raises(ConfigError, match=r"^--sweep .*" + said.replace("?", r"\?")):
        parse_axes([text])


def test_a_key_is_swept_once() -> None:
    with pytest.raises(ConfigError, match=r"camera\.fps: given twice"):
        parse_axes(["camera.fps=15", "camera.fps=30"])


def test_a_star_is_every_member() -> None:
    lags = [robot.lag_s for robot in load_scenario("paper", ("robots.*.lag_s=0.07",)).robots]
    assert lags == [0.07] * 3
    with pytest.raises(ConfigError, match="no member of robots"):
        load_scenario("paper", ("robots.9.lag_s=0.07",))
