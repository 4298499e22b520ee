"""The whole way: rendered frames in, commands out, simulated robots in the next frame.

Bounds are the project's targets (mm, deg), not what a run happens to give.
"""

import re
from math import degrees
from pathlib import Path

import pytest

from control.command import RobotId
from control.relative import relative_rates, relative_state
from control.unicycle import UnicycleState
from datasets.cycle import Moment
from datasets.truth import RunResult
from pipeline.scenario import scenario_path
from tests.pipeline.runs import run_scenario


def worst(result: RunResult) -> tuple[float, float]:
    """Largest distance rms [mm] and bearing rms [deg] of all followers."""
    assert result.truth
    scores = result.followers
    distances = [f.distance_rms_m for f in scores if f.distance_rms_m is not None]
    bearings = [f.bearing_rms_rad for f in scores if f.bearing_rms_rad is not None]
    assert len(distances) == len(bearings) == len(scores)
    return 1e3 * max(distances), degrees(max(bearings))


def truth_of(moment: Moment, robot: RobotId) -> UnicycleState:
    """True state of a robot."""
    return next(r.state for r in moment.truth if r.robot_id == robot)


@pytest.mark.parametrize("seed", [0, 11])
def test_the_papers_experiment(seed: int) -> None:
    _, result, moments = run_scenario("paper", seed)
    distance, bearing = worst(result)
    assert distance <= 2.0
    assert bearing <= 1.2
    assert all(f.settled_at_s is not None and f.settled_at_s <= 5.5 for f in result.followers)
    assert result.vision is not None
    assert result.vision.recall >= 0.999
    assert result.vision.false_ids == 0
    assert 1e3 * result.vision.position_rms_m <= 0.8
    assert degrees(result.vision.heading_rms_rad) <= 0.8
    assert result.leader is not None
    assert result.leader.position_rms_m is not None
    assert 1e3 * result.leader.position_rms_m <= 5.0
    assert result.min_clearance_m is not None
    assert 1e3 * result.min_clearance_m >= 20.0
    assert {event.kind for event in result.safety_events} == {"kept-apart"}  # R2 and R3 at first
    assert all(event.t < 1.5 for event in result.safety_events)
    turn = [m for m in moments if 2.65 < m.tick.t < 5.15]
    speeds: dict[object, list[float]] = {r.robot_id: [] for r in turn[0].truth}
    for moment in turn:
        for robot in moment.truth:
            speeds[robot.robot_id].append(robot.state.v)
    assert 0.85 <= max(speeds[3]) <= 1.05  # "until 1 m/s"
    assert min(speeds[2]) < 0.4  # "slows down"


def test_the_papers_own_sampling_time() -> None:
    _, result, _ = run_scenario("paper", 1, ("control.command_period_s=0.06",))
    distance, bearing = worst(result)
    assert distance <= 12.0
    assert bearing <= 4.0


def test_robots_that_already_move_are_engaged_without_a_bump() -> None:
    setup, result, moments = run_scenario("moving-start", 2)
    distance, bearing = worst(result)
    assert distance <= 3.0
    assert bearing <= 1.5
    assert [m.cycle.phase for m in moments[:40:39]] == ["idle", "armed"]
    engaged = next(m for m in moments if m.cycle.notes)
    assert 0.5 <= engaged.tick.t <= 0.6
    for pair, note in zip(setup.formation.pairs, engaged.cycle.notes, strict=True):
        found = re.findall(r"rate (-?[\d.]+) \+-", note)
        leader, follower = (truth_of(engaged, robot) for robot in (pair.leader, pair.follower))
        seen = relative_state(leader.pose, follower.pose, 0.05)
        true = relative_rates(seen, leader.twist, follower.twist, 0.05)
        assert float(found[0]) == pytest.approx(1e3 * true.distance, abs=10.0)  # mm/s
        assert float(found[1]) == pytest.approx(degrees(true.bearing), abs=4.0)  # deg/s
    before, after = moments[moments.index(engaged) - 1], moments[moments.index(engaged) + 10]
    assert not before.cycle.commands  # nobody is told anything while being watched
    for old, new in zip(before.truth, after.truth, strict=True):
        assert abs(new.state.v - old.state.v) < 0.12  # m/s within 0.1 s


def test_seven_robots_in_three_layers() -> None:
    _, result, _ = run_scenario("cascade", 3)
    layers = {2: 3.0, 3: 3.0, 4: 3.0, 5: 3.0, 6: 10.0, 7: 10.0}  # deg
    for follower in result.followers:
        assert follower.distance_rms_m is not None
        assert follower.bearing_rms_rad is not None
        assert 1e3 * follower.distance_rms_m <= 6.0
        assert degrees(follower.bearing_rms_rad) <= layers[int(follower.follower)]


def test_same_seed_same_commands_bit_for_bit() -> None:
    one, other = (run_scenario("paper", 5, duration=1.0)[2] for _ in range(2))
    assert [m.cycle.commands for m in one] == [m.cycle.commands for m in other]
    different = run_scenario("paper", 6, duration=1.0)[2]
    assert [m.cycle.commands for m in one] != [m.cycle.commands for m in different]


ARROW = """
include = ["{paper}"]
name = "arrow"
colors = {{ white = "#f0f0f0" }}
[tags]
layout = "arrow"
[layouts.arrow]
side_m = 0.08
parts = [
  {{ name = "plate", color = "black", polygon_m = [[0.04, 0.04], [-0.04, 0.04], [-0.04, -0.04], [0.04, -0.04]] }},
  {{ name = "tip", color = "white", polygon_m = [[0.035, 0.0], [0.005, 0.03], [0.005, -0.03]] }},
  {{ name = "tail", color = "$tail", polygon_m = [[-0.005, 0.03], [-0.035, 0.03], [-0.035, -0.03], [-0.005, -0.03]] }},
]
"""  # noqa: E501 (as in docs/scenarios.md)
ROBOT = '[[robots]]\nid = {0}\ncolors = {{ tail = "{1}" }}\nstart = {{ x_m = {2}, y_m = 0.0 }}\n'


def test_a_layout_of_the_users_own_needs_no_code(tmp_path: Path) -> None:
    robots = ((1, "red", 0.0), (2, "green", -0.4), (3, "blue", -0.3))
    text = ARROW.format(paper=scenario_path("paper")) + "".join(ROBOT.format(*r) for r in robots)
    (tmp_path / "arrow.toml").write_text(text)
    _, result, _ = run_scenario(str(tmp_path / "arrow.toml"), duration=1.0)
    assert result.vision is not None
    assert (result.vision.recall, result.vision.false_ids) == (1.0, 0)
    assert result.vision.position_rms_m is not None
    assert 1e3 * result.vision.position_rms_m < 0.8
