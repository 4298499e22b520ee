"""SSL-Vision: what a client reads by hand is what was seen; refusals hold up nobody."""

import math
import time
from dataclasses import replace

import pytest

from datasets.cycle import Moment
from pipeline.errors import ConfigError
from pipeline.publishers.open import open_publisher
from pipeline.publishers.ssl_vision import SslVision
from tests.hardware.ssl_client import SslClient
from tests.pipeline.commands import echelon
from tests.pipeline.radios import until
from tests.pipeline.runs import run_scenario


@pytest.fixture(scope="module")
def moments() -> list[Moment]:
    """Half a second of the paper's experiment."""
    return run_scenario("paper", duration=0.6)[2]


def test_every_frames_detections_arrive_in_mm_rad_and_px(moments: list[Moment]) -> None:
    with SslClient() as client:
        publisher = SslVision(client.place)
        for moment in moments:
            publisher.observe(moment)
        seen = [m for m in moments if m.cycle.scene is not None and m.tick.frame is not None]
        assert until(lambda: len(client.frames) == len(seen))
        publisher.close()
        publisher.close()
    assert len(seen) > 10
    assert client.errors == 0
    for moment, frame in zip(seen, client.frames, strict=True):
        assert moment.cycle.scene is not None
        assert moment.tick.frame is not None
        assert frame.head["frame_number"] == moment.tick.frame.sequence
        assert frame.head["camera_id"] == 0
        age = frame.head["t_sent"] - frame.head["t_capture"]
        meant = moment.tick.t + moment.timing.frame_to_command - moment.cycle.scene.t_capture
        assert age == pytest.approx(meant, abs=1e-5)
        assert frame.yellow == []
        assert len(frame.blue) == len(moment.cycle.scene.detections)
        for told, found in zip(frame.blue, moment.cycle.scene.detections, strict=True):
            assert told["robot_id"] == found.robot_id
            assert told["x"] == pytest.approx(1000.0 * found.pose.x, rel=1e-6)
            assert told["y"] == pytest.approx(1000.0 * found.pose.y, rel=1e-6)
            assert told["orientation"] == pytest.approx(found.pose.theta, rel=1e-6)
            assert told["pixel_x"] == pytest.approx(found.pixel.x, rel=1e-6)
            assert told["pixel_y"] == pytest.approx(found.pixel.y, rel=1e-6)
            assert told["confidence"] == pytest.approx(found.confidence, rel=1e-6)
    assert abs(client.frames[0].head["t_sent"] - time.time()) < 60.0  # s, since 1970
    between = [frame.head["t_capture"] for frame in client.frames[:2]]
    first, second = (m.cycle.scene.t_capture for m in seen[:2] if m.cycle.scene)
    assert between[1] - between[0] == pytest.approx(second - first, abs=1e-5)


def test_the_yellow_team_and_robots_with_names(moments: list[Moment]) -> None:
    seen = next(m for m in moments if m.cycle.scene and m.cycle.scene.detections)
    assert seen.cycle.scene is not None
    named = replace(seen.cycle.scene.detections[0], robot_id="red")
    scene = replace(seen.cycle.scene, detections=(named,))
    with SslClient() as client:
        publisher = SslVision(client.place, yellow=True)
        publisher.observe(replace(seen, cycle=replace(seen.cycle, scene=scene)))
        assert until(lambda: client.frames)
        publisher.close()
    assert client.frames[0].blue == []
    assert "robot_id" not in client.frames[0].yellow[0]


def test_what_cannot_be_sent_is_counted_and_told(moments: list[Moment]) -> None:
    publisher = SslVision("127.0.0.1:9")
    assert publisher.notes == ()
    publisher.close()
    for moment in moments:
        publisher.observe(moment)
    assert publisher.sent == 0
    assert publisher.failed > 10
    (note,) = publisher.notes
    assert note.startswith("ssl-vision 127.0.0.1:9: ")
    assert f"{publisher.failed} of {publisher.failed} packets were not sent (Bad file" in note


def test_a_cycle_without_a_new_frame_sends_nothing(moments: list[Moment]) -> None:
    publisher = SslVision("127.0.0.1:9")
    blind = next(m for m in moments if m.tick.frame is None)
    publisher.observe(blind)
    assert (publisher.sent, publisher.failed) == (0, 0)
    publisher.close()


@pytest.mark.parametrize(
    "spec", ["", "ros", "ssl-vision:", "ssl-vision:224.5.23.2", "ssl-vision:a..b:1"]
)
def test_specs_that_cannot_be_used(spec: str) -> None:
    with pytest.raises(ConfigError, match="--publish"):
        open_publisher(spec, False)


@pytest.mark.parametrize("command", ["live", "replay"])
def test_from_the_command_line(command: str, tmp_path: object) -> None:
    session = f"{tmp_path}/short.mcap"
    with SslClient() as client:
        where = ("--publish", f"ssl-vision:{client.place}")
        run = ("live", "paper", "--fast", "--duration", 0.5, "--set", "radio.team=yellow")
        done = echelon(*run, "--record", session, *(where if command == "live" else ()))
        if command == "replay":
            done = echelon("replay", session, *where)
        assert done.returncode == 0, done.stderr
        assert until(lambda: len(client.frames) > 10)
    assert client.errors == 0
    assert {robot["robot_id"] for robot in client.frames[-1].yellow} == {1, 2, 3}
    assert all(math.isfinite(robot["x"]) for robot in client.frames[-1].yellow)
