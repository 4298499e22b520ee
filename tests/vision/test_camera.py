"""Laws of the camera model: inverses, derivatives, resolution, parallax."""

from math import cos, hypot, pi, radians, sin

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from control.geometry import Pose2D, wrap_angle
from vision.camera import CameraModel, overhead_camera
from vision.errors import VisionError
from vision.scene import PixelPose

LENS = (-0.21, 0.06, 0.0012, -0.0008, -0.01)


def tilted_camera(distortion: tuple[float, ...] = LENS) -> CameraModel:
    """A camera tilted by 25 degrees, turned by 35, off the centre, with unequal focal lengths."""
    a, b = radians(155.0), radians(35.0)
    tilt = np.array([[1, 0, 0], [0, cos(a), -sin(a)], [0, sin(a), cos(a)]])
    turn = np.array([[cos(b), -sin(b), 0], [sin(b), cos(b), 0], [0, 0, 1]])
    rotation = tilt @ turn
    matrix = np.array([[517.3, 0.4, 341.2], [0, 498.6, 221.7], [0, 0, 1.0]])
    position = np.array([0.7, -1.1, 2.3])
    return CameraModel(
        (640, 480), matrix, np.array(distortion), rotation, -rotation @ position, 0.075
    )


CAMERAS = [
    overhead_camera((320, 240), 2.4, (0.5, 0.4), 2.5, 0.075),
    overhead_camera((641, 479), 1.7, (-0.3, 0.9), 1.9, 0.05, LENS),
    tilted_camera(),
]


@pytest.mark.parametrize("camera", CAMERAS)
@pytest.mark.parametrize("height", [0.0, 0.075])
def test_projecting_the_unprojected_pixel_gives_it_back(camera: CameraModel, height: float) -> None:
    w, h = camera.size_px
    grid = np.stack(np.meshgrid(np.linspace(0, w - 1, 13), np.linspace(0, h - 1, 11)), -1)
    pixels = grid.reshape(-1, 2)
    floor = camera.to_floor(pixels, height)
    again = camera.project(np.column_stack((floor, np.full(len(floor), height))))
    np.testing.assert_allclose(again, pixels, atol=1e-8)


@pytest.mark.parametrize("camera", CAMERAS)
def test_projection_agrees_with_opencv(camera: CameraModel) -> None:
    points = np.random.default_rng(1).uniform((-0.2, -0.2, 0), (1.2, 1.0, 0.2), (50, 3))
    rvec, _ = cv2.Rodrigues(camera.rotation)
    wanted, _ = cv2.projectPoints(
        points, rvec, camera.translation, camera.matrix, camera.distortion
    )
    skew = camera.matrix[0, 1] * (wanted[:, 0, 1] - camera.matrix[1, 2]) / camera.matrix[1, 1]
    wanted[:, 0, 0] += skew  # OpenCV has no skew
    np.testing.assert_allclose(camera.project(points), wanted[:, 0], atol=1e-6)


@given(
    x=st.floats(-0.3, 1.3),
    y=st.floats(-0.3, 1.1),
    theta=st.floats(-pi, pi),
    which=st.sampled_from(range(len(CAMERAS))),
)
def test_poses_survive_the_screen(x: float, y: float, theta: float, which: int) -> None:
    camera = CAMERAS[which]
    back = camera.floor_pose(camera.pixel_pose(Pose2D(x, y, theta)))
    assert hypot(back.x - x, back.y - y) < 1e-9
    assert abs(wrap_angle(back.theta - theta)) < 1e-9


@pytest.mark.parametrize("camera", CAMERAS)
def test_local_affine_is_the_derivative(camera: CameraModel) -> None:
    for x, y in ((0.5, 0.4), (-0.2, 0.9), (1.1, 0.1)):
        step = 1e-6
        ends = [(x + step, y), (x - step, y), (x, y + step), (x, y - step)]
        px = camera.project(np.array([(*end, camera.tag_height) for end in ends]))
        slope = np.column_stack((px[0] - px[1], px[2] - px[3])) / (2 * step)
        np.testing.assert_allclose(camera.local_affine(Pose2D(x, y, 1.0)), slope, atol=1e-4)


def test_overhead_camera_sees_the_field_the_right_way_round() -> None:
    camera = CAMERAS[0]
    floor = camera.to_floor(np.array([[-0.5, -0.5], [319.5, 239.5]]), 0.0)
    np.testing.assert_allclose(floor, [[-0.7, 1.3], [1.7, -0.5]], atol=1e-12)
    assert camera.pixel_pose(Pose2D(0.6, 0.5, 0.5)).heading == pytest.approx(0.5)


def test_height_of_the_tag_matters_at_the_border() -> None:
    camera = CAMERAS[0]
    on_floor, on_top = camera.project(np.array([[1.6, 0.4, 0.0], [1.6, 0.4, 0.075]]))
    assert on_top[0] - on_floor[0] == pytest.approx(1.1 / 0.0075 * (2.5 / 2.425 - 1.0))


@pytest.mark.parametrize("camera", CAMERAS)
def test_resizing_moves_pixel_centres_with_the_picture(camera: CameraModel) -> None:
    small = camera.scaled_to((320, 180))
    points = np.array([[0.3, 0.2, 0.075], [1.0, 0.7, 0.0]])
    scale = np.array([320 / camera.size_px[0], 180 / camera.size_px[1]])
    wanted = (camera.project(points) + 0.5) * scale - 0.5
    np.testing.assert_allclose(small.project(points), wanted, atol=1e-9)


def test_pixels_above_the_horizon_have_no_floor() -> None:
    level = tilted_camera()
    turned = CameraModel(
        level.size_px, level.matrix, np.zeros(5), np.array([[1, 0, 0], [0, 0, -1], [0, 1.0, 0]]),
        np.array([0, 1.0, 0]), 0.0,
    )  # fmt: skip
    floor = turned.to_floor(np.array([[300.0, 10.0], [300.0, 400.0]]), 0.0)
    assert np.isnan(floor[0]).all()
    assert np.isfinite(floor[1]).all()


def test_unusable_cameras_are_refused_with_the_numbers() -> None:
    with pytest.raises(VisionError, match=r"0\.3 m"):
        overhead_camera((320, 240), 2.4, (0, 0), 0.2, 0.3)
    good = CAMERAS[0]
    with pytest.raises(VisionError, match="distortion"):
        CameraModel(good.size_px, good.matrix, np.zeros(4), good.rotation, good.translation, 0.0)
    with pytest.raises(VisionError, match="not a rotation"):
        CameraModel(good.size_px, good.matrix, good.distortion, 2 * np.eye(3), np.zeros(3), 0.0)


def test_arrays_are_read_only() -> None:
    with pytest.raises(ValueError, match="read-only"):
        CAMERAS[0].matrix[0, 0] = 1.0
    assert isinstance(CAMERAS[0].pixel_pose(Pose2D(0, 0, 0)), PixelPose)
