"""Scenario files: what is read, and how errors name file, line, key and the nearest right one."""

from pathlib import Path

import pytest

from pipeline.errors import ConfigError
from pipeline.scenario import load_scenario, parse_scenario, scenario_names, scenario_path
from pipeline.setup import make_setup

PAPER = scenario_path("paper").read_text()


def complaint(folder: Path, text: str, *overrides: str) -> str:
    """The one line a user reads about a wrong scenario."""
    path = folder / "mine.toml"
    path.write_text(text)
    with pytest.raises(ConfigError) as error:
        make_setup(load_scenario(str(path), overrides))
    message = str(error.value)
    assert "\n" not in message
    return message.replace(str(folder) + "/", "")


@pytest.mark.parametrize("name", scenario_names())
def test_shipped_scenarios_build(name: str) -> None:
    assert make_setup(load_scenario(name)).name == name


@pytest.mark.parametrize(
    ("right", "wrong", "expected"),
    [
        ("width_px", "widht_px", 'mine.toml:{line}: unknown key "camera.widht_px"; '
         'did you mean "width_px"?'),
        ("latency_s = 0.040", "latency_ms = 40", 'unknown key "camera.latency_ms"; '
         'did you mean "latency_s"?'),
        ("latency_s = 0.040", "latency_s = 40", "camera.latency_s: input should be less than"),
        ("follower = 3", "folower = 3", 'unknown key "formation.pairs.1.folower"; '
         'did you mean "follower"?'),
        ("turn_deg = 180.0", "turn = 180.0", 'unknown key "leader.segments.1.turn"'),
        ("follower = 3", "follower = 4", "robot 4, which is not among the robots"),
        ("id = 3\n", "id = 2\n", "robot id given twice: 2"),
        ("rear = \"blue\"", 'rear = "red"', "robots 1 and 3 wear the same tag"),
        ("rear = \"blue\"", 'rear = "mauve"', '"mauve" is not among'),
        ('layout = "two_patch"', 'layout = "tow_patch"', 'no tag layout "tow_patch"'),
        ("mu = 20.0", "mu = 2.0", "mu (2.0) must be greater than nu (4.0)"),
    ],
)  # fmt: skip
def test_a_wrong_key_is_named(tmp_path: Path, right: str, wrong: str, expected: str) -> None:
    assert right in PAPER
    text = PAPER.replace(right, wrong)
    line = next(n for n, row in enumerate(text.splitlines(), 1) if wrong.strip() in row)
    message = complaint(tmp_path, text)
    assert message.startswith(("mine.toml", "scenario", "robot"))
    assert expected.format(line=line) in message


def test_a_formation_with_a_cycle_is_refused(tmp_path: Path) -> None:
    text = PAPER.replace("leader = 1\nfollower = 2", "leader = 3\nfollower = 2")
    text = text.replace("leader = 1\nfollower = 3", "leader = 2\nfollower = 3")
    assert "follow each other in a circle: 2, 3" in complaint(tmp_path, text)


def test_not_toml_and_missing_files(tmp_path: Path) -> None:
    assert "not valid TOML" in complaint(tmp_path, "x = ")
    assert 'unknown key "camra"; did you mean "camera"?' in complaint(tmp_path, "[camra]\nw = 3\n")
    for name, hint in (("papr", 'did you mean "paper"?'), ("gone.toml", "no such file")):
        with pytest.raises(ConfigError, match=r"papr|gone") as error:
            load_scenario(name)
        assert hint in str(error.value)


def test_overrides_are_checked_like_the_file(tmp_path: Path) -> None:
    scenario = load_scenario("paper", ["camera.fps=60", "robots.2.lag_s=0.07"])
    assert scenario.camera.fps == 60.0
    assert [robot.lag_s for robot in scenario.robots] == [0.05, 0.07, 0.05]
    wrong = {
        "camera.fsp=60": 'did you mean "fps"?',
        "robots.9.lag_s=1": 'no member of robots with id "9"',
        "camera": 'need "section.key=value"',
    }
    for text, expected in wrong.items():
        assert expected in complaint(tmp_path, PAPER, text)


def test_includes_are_laid_under_the_file(tmp_path: Path) -> None:
    (tmp_path / "base.toml").write_text(PAPER)
    (tmp_path / "mine.toml").write_text(
        'include = ["base.toml"]\nname = "mine"\n[camera]\nfps = 15\n'
    )
    scenario = load_scenario(str(tmp_path / "mine.toml"))
    assert (scenario.name, scenario.camera.fps, scenario.camera.width_px) == ("mine", 15.0, 320)
    (tmp_path / "mine.toml").write_text('include = ["mine.toml"]\n')
    with pytest.raises(ConfigError, match="includes itself"):
        load_scenario(str(tmp_path / "mine.toml"))


def test_a_session_carries_its_scenario_whole() -> None:
    scenario = load_scenario("paper", ["control.mu=15"])
    assert parse_scenario(scenario.model_dump_json()) == scenario
