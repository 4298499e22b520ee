"""A leader with a goal: its way is planned from the scenario and driven through pixels."""

from math import cos, hypot, sin
from pathlib import Path

import pytest

from control.spline_plan import SplinePlan
from datasets.cycle import Moment
from pipeline.errors import ConfigError
from pipeline.scenario import load_scenario, scenario_path
from pipeline.setup import Setup, make_setup
from tests.pipeline.runs import run_scenario

OBSTACLE = scenario_path("obstacle").read_text()
SEGMENTS = "segments = [{ straight_m = 1.0 }]"
GOAL = "goal = { x_m = 1.5, y_m = 0.0, heading_deg = 0.0 }"


def gap(setup: Setup, moments: list[Moment]) -> float:
    """Least distance of a body, taken as its circle, to an obstacle's edge in the run [m]."""
    assert setup.errand
    (o,) = setup.errand.obstacles
    around = setup.tags.tags[0].side / 2.0**0.5
    states = [robot.state for moment in moments for robot in moment.truth]
    return min(hypot(s.x - o.x, s.y - o.y) for s in states) - o.radius - around


def test_the_formation_drives_round_an_obstacle_to_its_goal() -> None:
    setup, result, moments = run_scenario("obstacle")
    assert isinstance(setup.path, SplinePlan)
    assert gap(setup, moments) >= 0.0  # m
    leader = next(r.state for r in moments[-1].truth if r.robot_id == 1)
    assert hypot(leader.x - 1.5, leader.y) <= 0.01  # m
    assert not result.safety_events
    assert result.leader is not None
    assert result.leader.position_rms_m is not None
    assert result.leader.position_rms_m <= 0.005


def test_a_straight_way_would_not_do() -> None:
    setup = make_setup(load_scenario("obstacle"))
    assert setup.errand
    (o,) = setup.errand.obstacles
    assert abs(o.y) < o.radius  # it stands on the line from start to goal
    poses = [setup.path.at(0.05 * k).state for k in range(161)]
    assert max(abs(s.y) for s in poses) > 0.3
    assert all(cos(s.theta) > 0.0 and abs(sin(s.theta)) < 1.0 for s in poses)


@pytest.mark.parametrize(
    ("right", "wrong", "expected"),
    [
        (GOAL, f"{GOAL}\n{SEGMENTS}", "leader: give either segments or goal"),
        (GOAL, "", "leader: give either segments or goal"),
        (GOAL, SEGMENTS, "obstacles are for a leader with a goal"),
        ("heading_deg = 0.0 }", "heading = 0.0 }", 'unknown key "leader.goal.heading"'),
        (
            "radius_m = 0.1",
            "radius_m = 0.0",
            "obstacles.0.radius_m: input should be greater than 0",
        ),
        ("x_m = 1.5", "x_m = 0.9", r"leader.goal: the goal (0.9, 0) m is 0."),
        ("radius_m = 0.1", "radius_m = 0.1\nvx_mps = nan", "obstacles.0.vx_mps"),
    ],
)
def test_a_wrong_key_is_named(tmp_path: Path, right: str, wrong: str, expected: str) -> None:
    assert right in OBSTACLE
    file = tmp_path / "mine.toml"
    file.write_text(OBSTACLE.replace(right, wrong))
    with pytest.raises(ConfigError) as caught:
        make_setup(load_scenario(str(file)))
    assert expected in str(caught.value)
    assert "\n" not in str(caught.value)
