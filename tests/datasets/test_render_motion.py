"""Robots that move while the shutter is open: motion blur, rolling shutter."""

from dataclasses import replace

import numpy as np
import pytest

from control.geometry import Pose2D
from control.unicycle import Twist, UnicycleState, advance_pose
from datasets.cycle import RobotState
from datasets.floor import Floor
from datasets.motion import moved
from datasets.render import Renderer
from datasets.sensor import SensorModel
from datasets.sensor.shutter import Shutter
from tests.scenes.field import SIDE, two_patch_tags
from vision.camera import CameraModel, overhead_camera
from vision.palette import NamedColor

CAMERA = overhead_camera((320, 240), 2.4, (0.5, 0.4), 2.5, SIDE)
SCALE = 320 / 2.4 * 2.5 / (2.5 - SIDE)  # at the tags' height [px/m]
CLEAN = SensorModel(read_noise=0.0, blur_px=0.0, chroma="444")
DARK = Floor(bgr=(0.0, 0.0, 0.0), texture=0.0, line_width=0.0)
WHITE = tuple(NamedColor(name, (200, 200, 200)) for name in ("black", *two_patch_tags(1).colors))


def coverage(state: UnicycleState, sensor: SensorModel, camera: CameraModel = CAMERA) -> np.ndarray:
    """Coverage of a white plate on black."""
    renderer = Renderer(camera, two_patch_tags(1), WHITE, sensor, 0, DARK)
    return renderer.render((RobotState(1, state),), 0.0)[..., 0].astype(float) / 200.0


def moments(weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Centre x, y and variances along x and y [px, px^2]."""
    places = np.indices(weights.shape)[::-1]
    mean = np.array([(weights * p).sum() for p in places]) / weights.sum()
    spread = [(weights * (p - m) ** 2).sum() for p, m in zip(places, mean, strict=True)]
    return mean, np.array(spread) / weights.sum()


def test_arcs_are_those_of_the_unicycle() -> None:
    rng = np.random.default_rng(2)
    motions, dt = rng.uniform(-2.0, 2.0, (50, 5)), rng.uniform(-0.05, 0.05, 50)
    for row, step, pose in zip(motions, dt, moved(motions, dt), strict=True):
        exact = advance_pose(Pose2D(*row[:3]), Twist(*row[3:]), float(step))
        assert pose[:2] == pytest.approx((exact.x, exact.y), abs=1e-9)
        assert np.cos(pose[2] - exact.theta) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("v", [0.4, 1.5, -1.0])
def test_motion_blur_keeps_light_and_place_and_widens_by_the_way(v: float) -> None:
    state = UnicycleState(0.513, 0.427, 0.0, v, 0.0)
    sharp = coverage(replace(state, v=0.0), CLEAN)
    blurred = coverage(state, replace(CLEAN, exposure_time=0.020))
    assert blurred.sum() == pytest.approx(sharp.sum(), abs=0.2)  # px^2; 8-bit rounding
    (_, wide), (smeared, wider) = moments(sharp), moments(blurred)
    pixel = CAMERA.pixel_pose(state.pose)
    np.testing.assert_allclose(smeared, (pixel.x, pixel.y), atol=0.013)  # as standing robots
    way = v * 0.020 * SCALE  # px; a box of this width adds way^2 / 12
    assert wider[0] - wide[0] == pytest.approx(way**2 / 12.0, abs=0.03)
    assert wider[1] == pytest.approx(wide[1], abs=0.02)
    columns = np.flatnonzero(blurred.max(axis=0) > 0.01), np.flatnonzero(sharp.max(axis=0) > 0.01)
    assert np.ptp(columns[0]) - np.ptp(columns[1]) == pytest.approx(abs(way), abs=1.5)


def test_turning_blurs_too() -> None:
    state = UnicycleState(0.5, 0.4, 0.3, 0.0, 15.0)
    sharp, blurred = (coverage(state, replace(CLEAN, exposure_time=t)) for t in (0.0, 0.030))
    assert blurred.sum() == pytest.approx(sharp.sum(), abs=0.3)
    assert (sharp > 0.99).sum() - (blurred > 0.99).sum() >= 8  # px; corners are rounded off


@pytest.mark.parametrize("y", [1.1, 0.4, -0.3])
@pytest.mark.parametrize("theta", [0.0, 0.5 * np.pi, 2.2])
def test_rolling_shutter_shows_a_robot_at_the_time_of_its_row(y: float, theta: float) -> None:
    state = UnicycleState(0.5, y, theta, 1.0, 0.0)
    rolling = replace(CLEAN, readout_time=0.030)
    center, _ = moments(coverage(state, rolling))
    t = (center[1] / 239.0 - 0.5) * 0.030
    then = advance_pose(state.pose, state.twist, float(t))
    pixel = CAMERA.pixel_pose(then)
    np.testing.assert_allclose(center, (pixel.x, pixel.y), atol=0.03)


def test_rolling_shutter_shears_by_the_way_of_one_row() -> None:
    state = UnicycleState(0.5, 0.4, 0.0, 1.5, 0.0)  # to the right, in the middle row
    seen = coverage(state, replace(CLEAN, readout_time=0.1))
    rows = [row for row in seen if row.max() > 0.99]
    middles = [(row * np.arange(320)).sum() / row.sum() for row in rows]
    per_row = 1.5 * 0.1 / 239.0 * SCALE  # px: v times row time
    np.testing.assert_allclose(np.diff(middles), per_row, atol=0.02)


def test_a_shutter_at_once_changes_nothing_and_standing_robots_are_sharp() -> None:
    state = UnicycleState(0.5, 0.4, 0.7, 0.0, 0.0)
    slow = replace(CLEAN, exposure_time=0.03, readout_time=0.03)
    np.testing.assert_array_equal(coverage(state, CLEAN), coverage(state, slow))
    assert Shutter().instant
    assert not Shutter(readout=0.01).instant
