"""The Rerun view: what is drawn, and that no viewer, dead or stuck, touches the run."""

import os
import signal
import socket
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from control.formation import ShapeReference
from control.geometry import Pose2D
from control.relative import RelativeState, relative_state
from control.unicycle import UnicycleState
from datasets.cycle import Moment, PairState, RobotState, SafetyEvent
from datasets.errors import RecordingError
from pipeline.errors import ConfigError
from pipeline.scenario import load_scenario
from pipeline.setup import make_setup
from pipeline.viewers.open import open_viewer, stage_of
from pipeline.viewers.rerun import RerunViewer
from pipeline.viewers.stage import Stage, circle, dashes, grid, name_of
from tests.datasets.recorded_moments import moments

RERUN = Path(sys.executable).with_name("rerun")


@pytest.fixture(scope="module")
def stage() -> Stage:
    return stage_of(make_setup(load_scenario("paper")))


@pytest.fixture(scope="module")
def run() -> list[Moment]:
    return list(moments(1.0))


def test_file_holds_every_picture_and_curve(
    stage: Stage, run: list[Moment], tmp_path: Path
) -> None:
    path = tmp_path / "run.rrd"
    viewer = RerunViewer(str(path), stage, wait=True)
    for moment in run:
        viewer.observe(moment)
    viewer.close()
    viewer.close()
    assert viewer.dropped == 0
    subprocess.run([RERUN, "rrd", "verify", path], check=True, capture_output=True)
    text = subprocess.run(
        [RERUN, "rrd", "print", "-v", path], check=True, capture_output=True, text=True
    ).stdout
    for entity in (
        "/camera/image", "/camera/tags", "/camera/names", "/camera/rejected", "/floor/robots",
        "/floor/headings", "/floor/track", "/floor/wanted", "/floor/truth", "/floor/path",
        "/plots/distance_error/R2", "/plots/bearing_error/R3", "/plots/speed/R1",
        "/plots/latency/vision", "/events",
    ):  # fmt: skip
        assert entity in text, entity


def test_draws_at_the_rate_of_the_pictures(stage: Stage, run: list[Moment], tmp_path: Path) -> None:
    """30 pictures a second among 200 cycles; an event in between is not lost."""
    drawn: list[Moment] = []
    viewer = RerunViewer(str(tmp_path / "run.rrd"), stage, wait=True)
    put = viewer._queue.put
    viewer._queue.put = lambda m, *a, **k: (m and drawn.append(m), put(m, *a, **k))[1]  # type: ignore[method-assign]
    event = SafetyEvent(0.0, "robot-stopped", 2, "not seen for 0.31 s")
    for k, moment in enumerate(run):
        odd = k == 51 and replace(moment, cycle=replace(moment.cycle, events=(event,)))
        viewer.observe(odd or moment)
    viewer.close()
    frames = sum(moment.tick.frame is not None for moment in run)
    assert [m.tick.frame is not None for m in drawn].count(True) == frames
    assert len(drawn) <= frames + 3
    assert any(event in m.cycle.events for m in drawn)


def test_goes_on_when_the_camera_is_silent(stage: Stage, run: list[Moment], tmp_path: Path) -> None:
    viewer = RerunViewer(str(tmp_path / "run.rrd"), stage, wait=True)
    for moment in run:
        viewer.observe(replace(moment, tick=replace(moment.tick, frame=None)))
    taken = viewer._next
    viewer.close()
    assert taken > 0.8  # s: the last drawn is near the end


@pytest.mark.realtime
@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGSTOP])
def test_dead_or_stuck_viewer_is_left_behind(
    stage: Stage, run: list[Moment], tmp_path: Path, how: signal.Signals,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.setattr("pipeline.viewers.rerun._FILE_END_LIMIT", 0.5)
    viewer = RerunViewer(str(tmp_path / "run.rrd"), stage)
    os.kill(viewer._process.pid, how)
    for moment in run:
        viewer.observe(moment)
        time.sleep(0.001)
    assert viewer.dropped > 10  # the queue is short: no memory fills up
    viewer.close()
    assert viewer._process.poll() is not None
    viewer.observe(run[0])  # after the end: nothing happens


def listening() -> bool:
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", 9876)) == 0


@pytest.mark.realtime
def test_live_viewer_gets_the_run(stage: Stage, run: list[Moment]) -> None:
    """Rerun's own server stands in for the window, which needs a screen."""
    import rerun_cli

    server = Path(rerun_cli.__file__).with_name("rerun")
    if not server.exists() or listening():
        pytest.skip("needs the rerun server, and port 9876")
    command = [server, "--serve-grpc", "--port", "9876"]
    with subprocess.Popen(command, stderr=subprocess.DEVNULL) as process:
        while not listening():
            assert process.poll() is None
            time.sleep(0.05)
        viewer = RerunViewer("rerun", stage, wait=True)
        for moment in run[:100]:
            viewer.observe(moment)
        viewer.close()
        process.kill()
    assert viewer.dropped == 0
    assert viewer._process.returncode == 0


def test_unusable_views_are_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    setup = make_setup(load_scenario("paper"))
    with pytest.raises(RecordingError, match=r"no/run\.rrd: cannot be written"):
        open_viewer(str(tmp_path / "no" / "run.rrd"), setup)
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    if sys.platform == "linux":
        with pytest.raises(ConfigError, match=r"no screen.*\.rrd"):
            open_viewer("rerun", setup)


def test_wanted_pose_has_the_wanted_relative_state(stage: Stage) -> None:
    """Put the follower where it is wanted: (6) and (7) give the reference back."""
    leader, follower = Pose2D(0.4, -0.2, 2.1), Pose2D(0.1, 0.3, -1.2)
    robots = tuple(
        RobotState(i, UnicycleState(p.x, p.y, p.theta, 0.0, 0.0))
        for i, p in ((1, leader), (2, follower))
    )
    pair = PairState(1, 2, RelativeState(1.0, 0.0, 0.0), ShapeReference(0.23, 2.4))
    wanted = stage.wanted_pose([pair], robots)
    assert wanted is not None
    back = relative_state(leader, wanted, stage.camera_offset)
    assert (back.distance, back.bearing) == pytest.approx((0.23, 2.4))
    assert stage.wanted_pose([replace(pair, leader=9)], robots) is None


def test_outline_surrounds_the_robot_and_projects_onto_its_tag(stage: Stage) -> None:
    pose = Pose2D(0.5, 0.3, 0.6)
    outline = stage.outline(2, pose)
    assert outline[0] == pytest.approx(outline[-1])
    assert outline[:-1].mean(axis=0) == pytest.approx((0.5, 0.3))
    seen = stage.on_screen(outline[:-1]).mean(axis=0)
    pixel = stage.camera.pixel_pose(pose)
    assert seen == pytest.approx((pixel.x, pixel.y), abs=1e-6)
    assert stage.outline("stranger", pose).shape == (5, 2)


def test_every_robot_has_its_colour(stage: Stage) -> None:
    assert len({stage.color(i) for i in (1, 2, 3, "stranger")}) == 4
    assert [name_of(2), name_of("red")] == ["R2", "red"]


def test_shapes() -> None:
    ring = circle(1.0, 2.0, 0.5)
    assert np.hypot(*(ring - (1.0, 2.0)).T) == pytest.approx(np.full(25, 0.5))
    path = np.array([(0.0, 0.0), (0.3, 0.0), (0.3, 0.1)])
    pieces = dashes(path, 0.03)
    assert len(pieces) == 7  # 0.40 m in steps of 0.06 m
    assert all(np.hypot(*np.diff(p, axis=0).T).sum() <= 0.03 + 1e-9 for p in pieces)
    assert dashes(path[:1]) == []
    lines = grid(np.array([-0.7, -0.2]), np.array([1.1, 0.6]))
    assert len(lines) == 4 + 2  # x = -0.5, 0, 0.5, 1; y = 0, 0.5
