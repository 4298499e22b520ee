"""The rendered camera: exact instants, the declared latency, the newest picture and only it."""

from typing import Any, cast

import numpy as np
import pytest

from control.unicycle import Twist, UnicycleState
from datasets.cycle import RobotState
from datasets.render import Renderer
from datasets.world import RobotPlant, World
from pipeline.cameras.rendered import RenderedCamera
from pipeline.clock import MonotonicClock, VirtualClock
from pipeline.ports import EndOfStream

FPS, LATENCY = 30.0, 0.04


class Sketch:
    """Stands in for the renderer: remembers what it was asked to draw."""

    def __init__(self) -> None:
        self.drawn: list[tuple[float, tuple[RobotState, ...]]] = []

    def render(self, states: tuple[RobotState, ...], t: float) -> Any:
        self.drawn.append((t, states))
        return np.zeros((3, 4, 3), np.uint8)


def scene(duration: float | None = None) -> tuple[World, Sketch, RenderedCamera]:
    world = World((RobotPlant(1, UnicycleState(0.0, 0.0, 0.0, 0.3, 1.0)),))
    sketch = Sketch()
    camera = RenderedCamera(world, cast(Renderer, sketch), FPS, LATENCY, duration)
    return world, sketch, camera


@pytest.mark.parametrize("period", [0.005, 0.001, 1.0 / 30.0, 0.0123])
def test_every_picture_is_taken_at_its_instant_and_comes_after_the_latency(period: float) -> None:
    _, sketch, camera = scene()
    given = []
    for n in range(round(2.0 / period)):
        frame = camera.latest(n * period)
        if frame is not None:
            assert -1e-9 <= n * period - frame.t_capture - LATENCY < period + 1e-9
            given.append(frame)
    assert [frame.t_capture for frame in given] == [n / FPS for n in range(len(given))]
    assert [frame.sequence for frame in given] == list(range(len(given)))
    assert len(given) in (58, 59)
    assert camera.report.dropped == 0
    assert len(sketch.drawn) == len(given)


def test_the_picture_shows_the_world_at_its_instant_although_time_went_on() -> None:
    world, sketch, camera = scene()
    for n in range(1, 200):
        world.command(1, Twist(0.2 * (n % 3), 1.0 - n % 2), n * 0.005)
        camera.latest(n * 0.005)
    alone = World((RobotPlant(1, UnicycleState(0.0, 0.0, 0.0, 0.3, 1.0)),))
    for n in range(1, 200):
        alone.command(1, Twist(0.2 * (n % 3), 1.0 - n % 2), n * 0.005)
    for t, states in sketch.drawn:
        alone.advance(t)
        for name in ("x", "y", "theta", "v", "omega"):
            seen, true = (getattr(s[0].state, name) for s in (states, alone.truth()))
            assert seen == pytest.approx(true, abs=1e-9)  # m, rad, per s


def test_who_comes_late_gets_the_newest_and_only_that_one_is_drawn() -> None:
    _, sketch, camera = scene()
    frame = camera.latest(0.5)
    assert frame is not None
    assert frame.t_capture == 13 / FPS
    assert camera.latest(0.501) is None
    assert camera.report.dropped == 13
    assert len(sketch.drawn) == 1


def test_the_end_comes_after_the_last_picture() -> None:
    _, _, camera = scene(duration=0.1)
    given = [camera.latest(n * 0.005) for n in range(23)]
    with pytest.raises(EndOfStream):
        camera.latest(23 * 0.005)
    times = [frame.t_capture for frame in given if frame is not None]
    assert times == [0.0, 1 / FPS, 2 / FPS]


@pytest.mark.realtime
def test_the_virtual_clock_jumps_and_the_real_one_waits() -> None:
    virtual = VirtualClock()
    assert virtual.wait_until(5.0) == 5.0
    assert virtual.wait_until(4.0) == -1.0
    assert virtual.now() == 5.0
    real = MonotonicClock()
    before = real.now()
    assert before >= 0.0
    slack = real.wait_until(before + 0.02)
    assert 0.0 < slack <= 0.02
    assert real.now() >= before + 0.02
    assert real.wait_until(before) < 0.0
