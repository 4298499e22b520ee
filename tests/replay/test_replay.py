"""Recorded sessions through the same step: bit for bit, and seen to differ when something did."""

import json
import os
import signal
import subprocess
import time
from pathlib import Path

import pytest

from datasets.recorded import read_session
from pipeline.replay import replay
from pipeline.scenario import parse_scenario
from pipeline.setup import make_setup
from tests.pipeline.commands import ECHELON, ROOT, echelon_process


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("session") / "run.mcap"
    done = echelon_process(
        "live", "paper", "--fast", "--seed", 4, "--duration", 2, "--record", path
    )
    assert done.returncode == 0, done.stderr
    return path


def test_commands_are_equal_bit_for_bit(session: Path) -> None:
    done = echelon_process("replay", session, "--compare", "--json")
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout)
    assert result["commands_equal"]
    assert result["frames"] == 59
    assert result["truth"]


def test_a_step_that_changed_is_noticed(session: Path) -> None:
    recorded = read_session(session)
    scenario = parse_scenario(recorded.header.scenario)
    control = scenario.control.model_copy(update={"nu": 4.000001})
    changed = make_setup(scenario.model_copy(update={"control": control}))
    differences = replay(changed, recorded, ())
    assert differences
    assert differences[0].recorded != differences[0].recomputed


def test_another_scenario_answers_what_if(session: Path) -> None:
    done = echelon_process("replay", session, "paper", "--set", "control.mu=10", "--json")
    assert done.returncode == 0, done.stderr
    assert "commands_equal" not in json.loads(done.stdout)
    refused = echelon_process("replay", session, "paper", "--compare")
    assert refused.returncode == 2
    assert "own scenario" in refused.stderr


@pytest.mark.realtime
def test_sigkill_leaves_a_session_that_replays(tmp_path: Path) -> None:
    path = tmp_path / "killed.mcap"
    process = subprocess.Popen(
        [*ECHELON, "live", "paper", "--record", str(path)], cwd=ROOT, start_new_session=True
    )
    try:
        last_size, deadline = 0, time.monotonic() + 60.0
        while last_size < 8_000_000 and time.monotonic() < deadline:  # about two seconds of frames
            time.sleep(0.05)
            last_size = path.stat().st_size if path.exists() else 0
    finally:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
    moments = list(read_session(path))
    frames = [m.tick.frame.sequence for m in moments if m.tick.frame is not None]
    assert len(frames) > 40
    assert frames == sorted(frames)
    done = echelon_process("replay", path, "--compare")
    assert done.returncode == 0, done.stderr
    assert "cut off" in done.stdout


@pytest.mark.realtime
def test_ctrl_c_stops_robots_and_closes_the_recording(tmp_path: Path) -> None:
    path = tmp_path / "interrupted.mcap"
    process = subprocess.Popen(
        [*ECHELON, "live", "paper", "--record", str(path)],
        cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    deadline = time.monotonic() + 60.0
    while time.monotonic() < deadline and not (path.exists() and path.stat().st_size > 2_000_000):
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    out, errors = process.communicate(timeout=30.0)
    assert process.returncode == 130, errors
    assert "Traceback" not in errors
    assert "stop was sent to every robot three times" in out
    session = read_session(path)
    assert sum(1 for _ in session) > 20
    assert session.end.complete
