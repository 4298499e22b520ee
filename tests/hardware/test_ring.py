"""The outside world in its own process: its stream shows the robots, its ptys move them."""

import json
from pathlib import Path

import numpy as np
import pytest

from control.command import Command
from control.unicycle import Twist
from pipeline.cameras.stream import open_stream
from pipeline.clock import MonotonicClock
from pipeline.radios.miabot_line import MiabotSettings
from pipeline.radios.open import RadioSettings, open_radio
from tests.hardware.ring import lateness, ring


@pytest.mark.realtime
@pytest.mark.alone
@pytest.mark.parametrize("stream", ["mjpeg", "udp"])
def test_robots_driven_through_the_air_are_seen_to_move(stream: str, tmp_path: Path) -> None:
    clock = MonotonicClock()
    with ring(tmp_path, stream=stream) as outside:
        camera = open_stream(outside.url, clock)
        radio = open_radio(
            outside.radio, clock, RadioSettings(MiabotSettings(ask_who=True)), (1, 2, 3)
        )
        frames, start = [], clock.now()
        while clock.now() < start + 2.0:
            now = clock.now()
            frame = camera.latest(now)
            frames += [] if frame is None else [frame]
            commands = (Command(r, Twist(0.2, 0.0), now, now + 0.1) for r in (1, 2, 3))
            assert radio.send(tuple(commands), now) == ()
            clock.wait_until(now + 0.01)
        radio.stop(clock.now())
        radio.close()
        camera.close()
        assert outside.truth()["robots"]
        truth = outside.finish()
    assert len(frames) > 20
    assert frames[0].size_px == (320, 240)
    changed = np.abs(frames[-1].image.astype(int) - frames[0].image).max(axis=2) > 60
    assert changed.sum() > 100  # px: three robots of 10 px side have gone elsewhere
    for robot in truth["robots"]:
        assert robot["timeout_s"] == 0.3
        assert (robot["errors"], robot["timeouts"], robot["wheels"]) == (0, 0, [0, 0])
        assert len(robot["stops"]) >= 3
        assert {tuple(wheels) for _, *wheels in robot["commands"]} == {(200, 200)}
    first, last = (truth["frames"][n]["robots"][0] for n in (0, -1))
    assert 0.25 < last["x_m"] - first["x_m"] < 0.55
    json.dumps(truth)


def test_only_lateness_while_robots_are_driven_is_the_machines() -> None:
    frames = [
        {"t": float(t), "published_t": t + (0.5 if t in (2, 29) else 0.01)} for t in range(30)
    ]
    truth = {"frames": frames, "robots": [{"commands": [(10.0, 0, 0), (20.0, 0, 0)]}]}
    assert abs(lateness(truth) - 0.01) < 1e-9
    frames[15]["published_t"] = 15.3
    assert abs(lateness(truth) - 0.3) < 1e-9
