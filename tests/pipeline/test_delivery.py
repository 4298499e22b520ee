"""Frames on their way: lost, repeated, wrongly stamped; the truth stays the true one."""

import json
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest

from control.unicycle import UnicycleState
from datasets.cycle import RobotState
from datasets.render import Renderer
from datasets.world import RobotPlant, World
from pipeline.cameras.delivery import Delivery
from pipeline.cameras.rendered import RenderedCamera
from pipeline.cli.rendering import render_run
from pipeline.ports import EndOfStream
from vision.frame import Frame

FPS = 30.0


class Clockface:
    """Stands in for the renderer: a picture tells its own time."""

    def render(self, states: tuple[RobotState, ...], t: float) -> Any:  # noqa: ARG002 (as a renderer)
        return np.full((3, 4, 3), round(t * FPS) % 256, np.uint8)


def filmed(delivery: Delivery, seconds: float = 8.0) -> tuple[list[Frame], RenderedCamera]:
    """All frames of a while, asked for every 5 ms."""
    world = World((RobotPlant(1, UnicycleState(0.0, 0.0, 0.0, 0.3, 1.0)),))
    renderer = cast(Renderer, Clockface())
    camera = RenderedCamera(world, renderer, FPS, 0.04, seconds, delivery)
    frames = []
    for n in range(round(seconds / 0.005) + 20):
        try:
            frame = camera.latest(n * 0.005)
        except EndOfStream:
            break
        if frame is not None:
            frames.append(frame)
    return frames, camera


def test_some_frames_never_arrive_and_nobody_knows() -> None:
    frames, camera = filmed(Delivery(dropped=0.2, seed=1))
    assert len(frames) / 240 == pytest.approx(0.8, abs=0.06)
    assert camera.report.dropped == 0
    assert all(f.t_capture == f.sequence / FPS for f in frames)
    assert [f.sequence for f in frames] == sorted({f.sequence for f in frames})


def test_the_end_comes_even_if_the_last_frames_are_lost() -> None:
    assert filmed(Delivery(dropped=0.999999))[0] == []


def test_repeated_frames_show_the_picture_before_under_a_stamp_of_their_own() -> None:
    frames, camera = filmed(Delivery(repeated=0.15, seed=2))
    shown = np.array([int(f.image[0, 0, 0]) for f in frames])
    own = np.array([f.sequence for f in frames])
    assert (shown != own).mean() == pytest.approx(0.15, abs=0.06)
    assert (np.diff(shown) >= 0).all()
    for frame, picture in zip(frames, shown, strict=True):
        assert frame.t_capture == frame.sequence / FPS
        assert camera.taken_at(frame.sequence) == picture / FPS


def test_stamps_err_as_declared_keep_their_order_and_never_come_from_the_future() -> None:
    frames, camera = filmed(Delivery(jitter=0.004, latency=0.04, seed=3), 30.0)
    errors = np.array([f.t_capture - camera.taken_at(f.sequence) for f in frames])
    assert errors.std() == pytest.approx(0.004, rel=0.07)
    assert abs(errors.mean()) < 0.0004
    assert (np.diff([f.t_capture for f in frames]) > 0.0).all()
    early = Delivery(jitter=0.004, latency=0.001, seed=3)
    assert max(early.stamp(n, 1.0, 1 / FPS) for n in range(300)) <= 1.001
    wild = Delivery(jitter=0.1, latency=1.0, seed=4)
    stamps = [wild.stamp(n, n / FPS, 1 / FPS) for n in range(300)]
    assert (np.diff(stamps) > 0.0).all()


def test_a_frames_lot_repeats_by_seed() -> None:
    for delivery in (Delivery(dropped=0.3, seed=5), Delivery(jitter=0.003, latency=0.1, seed=5)):
        one, same = filmed(delivery)[0], filmed(delivery)[0]
        assert [f.t_capture for f in one] == [f.t_capture for f in same]


def test_the_truth_file_tells_when_pictures_were_really_taken(tmp_path: Path) -> None:
    overrides = ("camera.stamp_jitter_s=0.005", "camera.repeated_share=0.3")
    render_run("paper", overrides, tmp_path / "out", 1.0, 0)
    truth = json.loads((tmp_path / "out" / "truth.json").read_text())
    numbers = np.array([frame["t"] for frame in truth["frames"]]) * FPS
    np.testing.assert_allclose(numbers, np.round(numbers), atol=1e-6)
    assert 0 < sum(np.diff(np.round(numbers)) == 0) < 20  # repeated: the same moment
