"""Rendered regression: rendered frames with known truth through the production path of vision.

Robots at random sub-pixel places with random headings; tolerances in mm and degrees, 1.15
times what is measured.
"""

from dataclasses import replace
from itertools import pairwise
from math import cos, sin

import numpy as np
import pytest

from datasets.sensor import SensorModel
from tests.scenes.measured import Measured, measure
from vision.camera import CameraModel, overhead_camera

PAPER = overhead_camera((320, 240), 2.4, (0.5, 0.4), 2.5, 0.075)  # a robot is 10 px wide
SENSOR = SensorModel(read_noise=3.0, blur_px=0.6, uneven_light=0.3, chroma="420")
LOW, HIGH = (-0.55, -0.35), (1.55, 1.15)  # where robots are wholly in the paper's picture [m]
LADDER = (  # noise of 255, position mm, heading deg
    (0.0, 0.070, 0.058),
    (1.0, 0.079, 0.079),
    (3.0, 0.108, 0.153),
    (6.0, 0.181, 0.278),
    (10.0, 0.29, 0.453),
)


def tilted(camera: CameraModel, tilt: float, turn: float) -> CameraModel:
    """The camera moved aside and tilted to look at the same place, and turned about its axis."""
    aside = np.array([[1, 0, 0], [0, cos(tilt), -sin(tilt)], [0, sin(tilt), cos(tilt)]])
    about = np.array([[cos(turn), -sin(turn), 0], [sin(turn), cos(turn), 0], [0, 0, 1]])
    rotation = aside @ camera.rotation @ about
    height = camera.position[2]
    target = np.array([*camera.position[:2], 0.0])
    return replace(
        camera,
        rotation=rotation,
        translation=-rotation @ (target - height * rotation.T @ (0.0, 0.0, 1.0)),
    )


def check(seen: Measured, position_mm: float, heading_deg: float) -> None:
    """Hold against a tolerance."""
    assert seen.recall >= 0.999
    assert seen.false_ids == 0
    assert seen.position_mm <= position_mm
    assert seen.heading_deg <= heading_deg
    assert np.hypot(*seen.bias_mm) <= 0.7 * position_mm


def test_noise_ladder() -> None:
    ladder = [measure(PAPER, replace(SENSOR, read_noise=n), LOW, HIGH) for n, _, _ in LADDER]
    for seen, (_, position_mm, heading_deg) in zip(ladder, LADDER, strict=True):
        check(seen, position_mm, heading_deg)
    for quiet, loud in pairwise(ladder):
        assert quiet.position_mm < loud.position_mm * 1.02
        assert quiet.heading_deg < loud.heading_deg * 1.02


def test_tracked_is_as_exact_as_searched() -> None:
    check(measure(PAPER, SENSOR, LOW, HIGH, predicted=True), 0.097, 0.152)


@pytest.mark.parametrize(
    ("change", "position_mm", "heading_deg"),
    [
        ({"chroma": "444"}, 0.109, 0.129),
        ({"chroma": "422"}, 0.108, 0.148),
        ({"chroma_upsampling": "nearest"}, 0.117, 0.170),
        ({"chroma_offset_px": (0.5, -0.5)}, 0.121, 0.171),
        ({"jpeg_quality": 85}, 0.170, 0.309),
        ({"jpeg_quality": 95, "chroma": "422"}, 0.111, 0.160),
        ({"blur_px": 1.2}, 0.220, 0.362),
        ({"blur_px": 0.3}, 0.081, 0.116),
        ({"uneven_light": 0.6}, 0.194, 0.190),
    ],
    ids=str,
)
def test_sensors(change: dict[str, object], position_mm: float, heading_deg: float) -> None:
    check(measure(PAPER, replace(SENSOR, **change), LOW, HIGH), position_mm, heading_deg)


def test_distorted_lens_odd_size_off_centre() -> None:
    lens = (-0.15, 0.03, 0.001, -0.001, 0.0)
    camera = overhead_camera((401, 223), 2.6, (0.1, -0.3), 2.0, 0.075, lens)
    check(measure(camera, SENSOR, (-1.0, -0.8), (1.2, 0.2)), 0.076, 0.138)


def test_tilted_and_turned_camera() -> None:
    camera = tilted(overhead_camera((400, 300), 2.4, (0.1, -0.3), 2.1, 0.075), 0.3, 0.7)
    check(measure(camera, SENSOR, (-0.4, -0.7), (0.6, 0.1)), 0.091, 0.130)


def test_larger_pictures_are_finer() -> None:
    """A robot of 20 px in a 640x480 picture."""
    camera = overhead_camera((640, 480), 2.4, (0.5, 0.4), 2.5, 0.075)
    check(measure(camera, SENSOR, LOW, HIGH, robots=7, frames=15), 0.039, 0.037)


def test_a_fifth_of_a_pixel_does_not_go_unnoticed() -> None:
    """The regression can fail: believing in a principal point 0.2 px off costs 1.5 mm."""
    matrix = PAPER.matrix.copy()
    matrix[0, 2] += 0.2
    seen = measure(PAPER, SENSOR, LOW, HIGH, believed=replace(PAPER, matrix=matrix))
    expected = -0.2 * 2.4e3 / 320 * (2.5 - 0.075) / 2.5  # mm
    assert seen.bias_mm[0] == pytest.approx(expected, abs=0.1)
