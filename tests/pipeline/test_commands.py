"""The command line against its contract: exit statuses, one clear line, JSON that is one object."""

import json
import os
import signal
import struct
import subprocess
import sys
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.pipeline.commands import ECHELON, ROOT, echelon

REAL = Path(os.environ.get("ECHELON_REAL_FRAMES", "../shared/real"))
KEYS = {"scenario", "frames", "duration_s", "wall_s", "followers", "leader", "min_clearance_m",
        "vision", "latency_ms", "commands_sent", "safety_events", "truth"}  # fmt: skip


@pytest.mark.parametrize(
    ("arguments", "status", "said"),
    [
        (("live", "nosuch"), 2, 'no scenario "nosuch"'),
        (("live", "--nosuch"), 2, "No such option"),
        (("live", "--set", "camera.fsp=1"), 2, 'did you mean "fps"?'),
        (("live", "--camera", "/dev/video97", "--radio", "none"), 3, "/dev/video97"),
        (("live", "--camera", "http://127.0.0.1:9/none"), 3, "127.0.0.1:9"),
        (("live", "--camera", "gone.mp4"), 3, "gone.mp4"),
        (("live", "--camera", "gone.mp4", "--fast"), 2, "--fast needs the rendered camera"),
        (("live", "--camera", "gone.mp4", "--radio", "simulated"), 2, "rendered camera only"),
        (("live", "--radio", "miabot:1=/dev/nosuch,2=/dev/a,3=/dev/b"), 3, "/dev/nosuch"),
        (("live", "--radio", "miabot:1=/dev/nosuch"), 2, "robot 2 of the scenario has no port"),
        (("live", "--radio", "firasim:127.0.0.1:9"), 3, "nobody listens there"),
        (("live", "--radio", "vsss:/dev/nosuch"), 3, "/dev/nosuch"),
        (("live", "--radio", "miabot-tcp:1=127.0.0.1:9"), 2, "robot 2 of the scenario has no port"),
        (("live", "--radio", "miabot-tcp-listen:9"), 2, "need HOST:PORT"),
        (("live", "--publish", "ros"), 2, "need ssl-vision"),
        (("live", "--radio", "tin-can"), 2, "tin-can"),
        (("live", "--view", "view.txt"), 2, "need none, rerun or FILE.rrd"),
        (("replay", "none.mp4"), 2, "none.mp4"),
        (("report", "none.mcap", "--out", "x"), 2, "none.mcap"),
        (("locate", "none.png"), 2, "none.png"),
        (("simulate", "nosuch"), 2, 'no scenario "nosuch"'),
        (("simulate", "--sweep", "sensor.blur_px=1,2"), 2, "sensor.blur_px"),
        (("simulate", "--runs", "2", "--trajectory", "t.csv"), 2, "--trajectory is of one run"),
        (("calibrate", "robots"), 2, "missing key safety.arena_m"),
        (("calibrate", "robots", "--radio", "none"), 2, "needs a radio"),
        (("calibrate", "robots", "--camera", "0"), 2, "needs a radio"),
    ],
)
def test_wrong_use_is_one_clear_line(arguments: tuple[str, ...], status: int, said: str) -> None:
    done = echelon(*arguments)
    assert done.returncode == status, done.stderr
    assert said in done.stderr
    assert "Traceback" not in done.stderr
    if "No such option" not in said:
        assert len(done.stderr.strip().splitlines()) == 1


def test_simulate_answers_as_live_does(tmp_path: Path) -> None:
    csv = tmp_path / "t.csv"
    done = echelon("simulate", "--duration", 1, "--seed", 3, "--trajectory", csv, "--json")
    result = json.loads(done.stdout)
    assert result.keys() >= KEYS
    assert result["truth"] is True
    assert result["vision"] is result["latency_ms"] is None
    assert set(result["followers"]) == {"2", "3"}
    assert csv.read_text().count("\n") == 1 + 100


def test_sweeps_answer_with_their_points() -> None:
    sweeps = ("--sweep", "camera.fps=15,30", "--sweep", "robots.*.lag_s=0.04,0.06")
    done = echelon("simulate", "--runs", 2, "--duration", 1, *sweeps, "--json")
    points = json.loads(done.stdout)["points"]
    assert [tuple(point["swept"].values()) for point in points] == [
        ("15", "0.04"), ("15", "0.06"), ("30", "0.04"), ("30", "0.06"),
    ]  # fmt: skip
    for point in points:
        assert point["runs"] == 2
        spread = point["worst_follower"]["distance_rms_m"]
        assert 0.0 < spread["mean"] <= spread["worst"]
    table = echelon("simulate", "--runs", 2, "--duration", 1, *sweeps).stdout
    assert "distance rms mm" in table
    assert table.count("\n") >= 4 + len(points)


def test_ctrl_c_ends_a_simulation_with_130() -> None:
    command = [*ECHELON, "simulate", "--runs", "1000000"]
    with subprocess.Popen(command, cwd=ROOT, stderr=subprocess.PIPE) as running:
        with pytest.raises(subprocess.TimeoutExpired):
            running.wait(timeout=8.0)
        running.send_signal(signal.SIGINT)
        assert running.wait(timeout=20.0) == 130


def test_live_answers_with_one_json_object(tmp_path: Path) -> None:
    csv = tmp_path / "t.csv"
    done = echelon("live", "--fast", "--duration", 1, "--seed", 3, "--trajectory", csv, "--json")
    result = json.loads(done.stdout)
    assert result.keys() >= KEYS
    assert set(result["followers"]) == {"2", "3"}
    assert result["followers"]["2"]["leader"] == 1
    assert result["seen"] == dict.fromkeys("123", result["frames"])
    lines = csv.read_text().splitlines()
    assert lines[0].startswith("t_s,true1_x_m,true1_y_m,true1_theta_rad")
    assert len(lines) == 101
    assert {line.count(",") for line in lines} == {lines[0].count(",")}


def test_render_then_locate(tmp_path: Path) -> None:
    done = echelon("render", "paper", "--out", tmp_path / "frames", "--duration", 0.2)
    assert done.returncode == 0, done.stderr
    truth = json.loads((tmp_path / "frames" / "truth.json").read_text())
    assert len(truth["frames"]) == 6
    image = tmp_path / "frames" / truth["frames"][5]["file"]
    done = echelon("locate", image, "--setup", "paper", "--overlay", tmp_path / "seen", "--json")
    (found,) = json.loads(done.stdout)["images"]
    by_id = {robot["id"]: robot for robot in truth["frames"][5]["robots"]}
    assert {d["id"] for d in found["detections"]} == set(by_id)
    for seen in found["detections"]:
        assert abs(seen["x_px"] - by_id[seen["id"]]["x_px"]) < 0.2
        assert abs(seen["heading_deg"] - by_id[seen["id"]]["heading_deg"]) < 3.0
    assert cv2.imread(str(tmp_path / "seen" / image.name)) is not None
    done = echelon("locate", tmp_path / "frames", "--json")  # a folder: all its images, in order
    files = [Path(found["file"]).name for found in json.loads(done.stdout)["images"]]
    assert files == [frame["file"] for frame in truth["frames"]]
    done = echelon("locate", tmp_path)
    assert done.returncode == 2
    assert "a folder without images" in done.stderr


def test_check_says_what_holds() -> None:
    done = echelon("check", "paper")
    assert done.returncode == 0, done.stdout
    assert done.stdout.count("ok ") >= 8
    broken = echelon("check", "paper", "--set", "camera.field_width_m=1.5")
    assert broken.returncode == 2
    assert "FAILS  field of view" in broken.stdout


def test_foreign_packages_of_the_same_name_are_noticed(tmp_path: Path) -> None:
    (tmp_path / "control").mkdir()
    (tmp_path / "control" / "__init__.py").write_text("")
    paths = [str(tmp_path), str(ROOT)]
    code = f"import sys; sys.path[:0] = {paths}; from pipeline.cli.start import main; main()"
    command = [sys.executable, "-P", "-c", code]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert f'"control" is not Echelon\'s but the one in {tmp_path}' in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1


@pytest.mark.skipif(not REAL.is_dir(), reason=f"no real frames in {REAL}")
@pytest.mark.parametrize(
    ("source", "frames"),
    [("agh_b", 13), ("rodetas", 3), ("empty", 3), ("video/still_plates.mpg", 50),
     ("video/exposure_settling.mpg", 220)],
)  # fmt: skip
def test_footage_nobody_here_made_plays_through(source: str, frames: int) -> None:
    done = echelon("replay", REAL.resolve() / source, "--json")
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout)
    assert result["frames"] == frames
    assert result["truth"] is False


def test_footage_of_another_size_is_refused_where_the_scenario_says_so(tmp_path: Path) -> None:
    folder = tmp_path / "small"
    folder.mkdir()
    cv2.imwrite(str(folder / "a.png"), np.zeros((90, 160, 3), np.uint8))
    refused = echelon("replay", folder, "paper", "--set", "camera.other_sizes=refuse")
    assert refused.returncode == 2
    assert "160 x 90 px" in refused.stderr
    assert "320 x 240 px" in refused.stderr
    assert echelon("replay", folder, "paper").returncode == 0


@pytest.mark.parametrize("kind", ["black", "noise", "yellow"])
def test_frames_without_robots_end_quietly(tmp_path: Path, kind: str) -> None:
    rng = np.random.default_rng(1)
    pictures = {
        "black": np.zeros((240, 320, 3)),
        "noise": rng.integers(0, 256, (240, 320, 3)),
        "yellow": np.full((240, 320, 3), (30, 220, 255)),
    }
    for number in range(3):
        cv2.imwrite(str(tmp_path / f"{number}.png"), pictures[kind].astype(np.uint8))
    done = echelon("replay", tmp_path, "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["commands_sent"] == 0


def test_broken_footage_is_named(tmp_path: Path) -> None:
    empty, folder, cut = tmp_path / "empty.mp4", tmp_path / "folder", tmp_path / "cut.png"
    empty.write_bytes(b"")
    folder.mkdir()
    chunk = struct.pack(">I", 13) + b"IHDR" + struct.pack(">IIBBBBB", 9, 9, 8, 2, 0, 0, 0)
    cut.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk + struct.pack(">I", zlib.crc32(chunk[4:])))
    for source, command in ((empty, "replay"), (folder, "replay"), (cut, "locate")):
        done = echelon(command, source)
        assert done.returncode == 2
        assert source.name in done.stderr
        assert len(done.stderr.strip().splitlines()) == 1
