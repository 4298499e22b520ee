"""Scenarios for looking only: located, rendered and checked without a formation."""

import json
from pathlib import Path

import pytest

from pipeline.checks import check_scenario
from pipeline.errors import ConfigError
from pipeline.scenario import load_scenario
from pipeline.setup import make_setup
from tests.pipeline.commands import echelon

LOOK = """
name = "look"
[camera]
width_px = 640
height_px = 480
[tags]
layout = "ssl_butterfly"
colors = { team = "blue" }
[[robots]]
id = 4
pattern = 4
start = { x_m = 0.1, y_m = 0.0 }
[[robots]]
id = "keeper"
pattern = 0
start = { x_m = 0.5, y_m = 0.3, theta_deg = 90 }
"""


@pytest.fixture
def look(tmp_path: Path) -> Path:
    path = tmp_path / "look.toml"
    path.write_text(LOOK)
    return path


def test_standing_robots_are_rendered_and_located(look: Path, tmp_path: Path) -> None:
    frames = tmp_path / "frames"
    done = echelon("render", look, "--out", frames, "--duration", 0.1)
    assert done.returncode == 0, done.stderr
    truth = json.loads((frames / "truth.json").read_text())
    assert len(truth["frames"]) == 3
    assert truth["frames"][0]["robots"] == truth["frames"][2]["robots"]
    done = echelon("locate", frames / truth["frames"][2]["file"], "--setup", look, "--json")
    (image,) = json.loads(done.stdout)["images"]
    assert [d["id"] for d in image["detections"]] == [4, "keeper"]
    assert image["detections"][1]["x_m"] == pytest.approx(0.5, abs=1e-3)
    assert image["detections"][1]["heading_deg"] == pytest.approx(90.0, abs=0.5)


def test_check_says_what_can_be_said(look: Path) -> None:
    findings = check_scenario(load_scenario(str(look)))
    assert [f.topic for f in findings] == ["formation", "tags", "robots in the picture", "colours"]
    assert all(f.holds for f in findings)


def test_driving_needs_the_missing_section(look: Path) -> None:
    done = echelon("live", look)
    assert done.returncode == 2
    assert "missing section [formation]" in done.stderr
    text = LOOK + "[[formation.pairs]]\nleader = 4\nfollower = 'keeper'\ndistance_m = 0.3\n"
    look.write_text(text + "bearing_deg = 90\n")
    with pytest.raises(ConfigError, match=r"missing section \[leader\]"):
        make_setup(load_scenario(str(look)))


def test_the_loop_through_printed_markers() -> None:
    done = echelon("live", "aruco", "--fast", "--duration", 5.2, "--json")
    result = json.loads(done.stdout)
    assert result["vision"]["recall"] == 1.0
    assert result["vision"]["false_ids"] == 0
    assert result["vision"]["position_rms_m"] < 0.1e-3
    assert result["vision"]["heading_rms_rad"] < 1.5e-3
    assert {event["kind"] for event in result["safety_events"]} <= {"kept-apart"}
    for follower in result["followers"].values():
        assert follower["distance_rms_m"] < 20e-3  # in place, by the contract's measure
