"""`echelon calibrate robots` in real time: a streamed picture, Miabots on ptys, hidden drives."""

import json
import os
import signal
import subprocess
from pathlib import Path
from typing import Any

import pytest

from pipeline.scenario import load_scenario
from tests.hardware.ring import Ring, lateness, ring
from tests.pipeline.commands import ECHELON, ROOT, echelon_process

pytestmark = [pytest.mark.realtime, pytest.mark.alone]

LATE, TRIES = 0.03, 3  # of the world's frames: then the machine was at fault [s]
ROOM = """\
name = "room"
[camera]
center_m = [0.6, 0.4]
latency_s = {latency}
[sensor]
read_noise = 3.0
blur_px = 0.6
[colors]
yellow = "#ffdc1e"
red = "#d2282d"
green = "#1e963c"
[radio]
delay_s = {delay}
speed_scale_per_mps = {scale}
track_width_m = {track}
[safety]
arena_m = [-0.4, -0.3, 1.6, 1.1]
[[robots]]
id = 1
colors = {{ rear = "red" }}
start = {{ x_m = 0.2, y_m = 0.2 }}
lag_s = {lag}
[[robots]]
id = 2
colors = {{ rear = "green" }}
start = {{ x_m = 0.9, y_m = 0.6, theta_deg = 110 }}
lag_s = {lag}
"""
BELIEVED = {"latency": 0.0, "delay": 0.0, "scale": 1000.0, "track": 0.068, "lag": 0.05}
TRUE = {"latency": 0.0, "delay": 0.03, "scale": 800.0, "track": 0.072, "lag": 0.08}
SENDING = 0.006  # from the world's picture to its arrival: rendered, coded, sent, about [s]


def rooms(folder: Path) -> tuple[Path, Path]:
    """What is true, and what is believed."""
    true, believed = folder / "true.toml", folder / "believed.toml"
    true.write_text(ROOM.format(**TRUE))
    believed.write_text(ROOM.format(**BELIEVED))
    return true, believed


def crossed(outside: Ring) -> str:
    """The `--radio` argument of somebody who has mixed up the two ports."""
    return f"miabot:1={outside.ports['2']},2={outside.ports['1']}"


def calibrated(folder: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """What the program says, and the truth; again if the world itself came too late."""
    true, believed = rooms(folder)
    for _ in range(TRIES):
        with ring(folder, str(true)) as outside:
            done = echelon_process(
                "calibrate", "robots", believed, "--camera", outside.url, "--radio",
                crossed(outside), "--out", folder / "robots.toml", "--json",
            )  # fmt: skip
            ports, truth = outside.ports, outside.finish()
        if lateness(truth) < LATE:
            break
    assert done.returncode == 0, done.stderr
    return {**json.loads(done.stdout), "ports": ports}, truth


def test_hidden_drives_are_found_through_real_links(tmp_path: Path) -> None:
    told, truth = calibrated(tmp_path)
    assert told["pairing"] == [{"radio": 1, "tag": 2}, {"radio": 2, "tag": 1}]
    ports = told["ports"]
    assert told["radio"] == f"miabot:2={ports['2']},1={ports['1']}"
    common = told["common"]
    assert common["speed_scale_per_mps"]["value"] == pytest.approx(TRUE["scale"], rel=0.02)
    assert common["track_width_m"]["value"] == pytest.approx(TRUE["track"], rel=0.03)
    assert common["lag_s"]["value"] == pytest.approx(TRUE["lag"], rel=0.2)
    assert common["delay_s"]["value"] == pytest.approx(TRUE["delay"] + SENDING, abs=0.01)
    fragment = load_scenario(str(_including(tmp_path)))
    assert fragment.radio.speed_scale_per_mps == pytest.approx(TRUE["scale"], rel=0.02)
    for robot in truth["robots"]:
        assert robot["timeout_s"] == 0.3  # the robots' own deadman was set
        assert (robot["errors"], robot["timeouts"], robot["wheels"]) == (0, 0, [0, 0])
        assert len(robot["stops"]) >= 3


def test_ctrl_c_stops_the_robots_three_times(tmp_path: Path) -> None:
    true, believed = rooms(tmp_path)
    with ring(tmp_path, str(true)) as outside:
        command = (*ECHELON, "calibrate", "robots", str(believed), "--camera", outside.url,
                   "--radio", outside.radio, "--out", str(tmp_path / "robots.toml"))  # fmt: skip
        process = subprocess.Popen(
            command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
            env={**os.environ, "PYTHONUNBUFFERED": "1"},
        )  # fmt: skip
        assert process.stdout is not None
        told = ""
        while "robot 1 (1 of 2): drives" not in told:
            told = process.stdout.readline()
            assert told, "it ended before anybody drove"
        process.send_signal(signal.SIGINT)
        said = process.stdout.read()
        assert process.wait(10.0) == 130
        truth = outside.finish()
    assert "interrupted: stop was sent to every robot three times" in said
    assert not (tmp_path / "robots.toml").exists()
    for robot in truth["robots"]:
        last = max((t for t, *_ in robot["commands"]), default=0.0)
        assert len([t for t in robot["stops"] if t > last]) >= 3
        assert robot["wheels"] == [0, 0]


def _including(folder: Path) -> Path:
    mine = folder / "mine.toml"
    mine.write_text('include = ["believed.toml", "robots.toml"]\n')
    return mine
