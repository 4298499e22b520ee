"""The fit against rendered truth: an error ladder over noise and codecs, and laws of the fit."""

from math import degrees, radians

import numpy as np
import pytest

from control.geometry import Pose2D
from datasets.sensor import SensorModel
from tests.vision.test_camera import tilted_camera
from tests.vision.worlds import TRIANGLE, World, errors_of, make_world, paper_camera, two_patch_tags
from vision.camera import CameraModel, overhead_camera
from vision.errors import VisionError
from vision.eye import ChromaModel, Optics
from vision.fit import Fit
from vision.locate import Prediction, locate
from vision.pose import fit_poses
from vision.tags import TagSet

FRAMES = 12


def fitted(world: World, seed: int, frames: int = FRAMES) -> tuple[np.ndarray, np.ndarray]:
    """Errors (N, 3) and their squares normalised by the covariance (N,), from disturbed starts."""
    rng = np.random.default_rng(seed)
    errors, normalised = [], []
    shapes = world.eye.looks.shape_of
    for number in range(frames):
        truth = world.scattered(rng)
        start = truth + rng.normal(0.0, 1.0, truth.shape) * (0.003, 0.003, 0.06)
        fit = fitted_from(world, world.frame(truth, number).image, shapes, start)
        error = fit.poses - truth
        error[:, 2] = (error[:, 2] + np.pi) % (2 * np.pi) - np.pi
        errors.append(error)
        normalised.append(np.einsum("ni,nij,nj->n", error, np.linalg.inv(fit.covariances), error))
    return np.concatenate(errors), np.concatenate(normalised)


def fitted_from(world: World, image: np.ndarray, shapes: np.ndarray, start: np.ndarray) -> Fit:
    """Fit tags from starting poses (R, 3)."""
    camera = world.eye.camera
    points = np.column_stack((start[:, :2], np.full(len(start), camera.tag_height)))
    return fit_poses(image, world.eye.gauge, shapes, start, camera.project(points), 12)


def rms(errors: np.ndarray) -> tuple[float, float]:
    """Root mean square of position [mm] and heading [deg]."""
    position = np.sqrt((errors[:, :2] ** 2).sum(axis=1).mean())
    return 1e3 * float(position), degrees(float(np.sqrt((errors[:, 2] ** 2).mean())))


# Sensor, position [mm], heading [deg], NEES: 1.15 times what is measured. NEES is 3 if the
# covariance tells the truth. Light that falls off across a plate (0.3) is no noise and unknown
# to the fit; it moves poses by 0.05 mm, 0.007 px, which shows where noise is less than that.
LADDER = [
    (SensorModel(0.0, 0.6, 0.0, chroma="444"), 0.043, 0.029, 4.3),
    (SensorModel(0.0, 0.6, 0.3), 0.066, 0.046, 14.7),
    (SensorModel(1.5, 0.6, 0.3), 0.083, 0.066, 6.3),
    (SensorModel(3.0, 0.6, 0.3), 0.109, 0.132, 4.0),
    (SensorModel(3.0, 0.6, 0.3, chroma="422"), 0.111, 0.129, 4.2),
    (SensorModel(3.0, 0.6, 0.3, chroma_upsampling="nearest"), 0.125, 0.143, 5.7),
    (SensorModel(6.0, 0.6, 0.3), 0.173, 0.252, 3.2),
    (SensorModel(3.0, 1.2, 0.3), 0.239, 0.273, 5.0),
    (SensorModel(3.0, 0.6, 0.3, jpeg_quality=85), 0.171, 0.276, 3.1),
]


@pytest.mark.parametrize(("sensor", "position_mm", "heading_deg", "nees"), LADDER)
def test_error_ladder(
    sensor: SensorModel, position_mm: float, heading_deg: float, nees: float
) -> None:
    errors, normalised = fitted(make_world(sensor=sensor), seed=11)
    position, heading = rms(errors)
    assert position < position_mm
    assert heading < heading_deg
    assert 1.5 < normalised.mean() < nees


# Where pixels see the floor foreshortened, at the border of a wide lens or under a tilted camera,
# the fit knows their mean width only: NEES is 8 and 14 there, under even light, too.
CAMERAS = [
    (
        overhead_camera((322, 182), 2.1, (-0.3, 1.9), 1.6, 0.05, (-0.18, 0.03, 0.001, 0.0, 0)),
        0.14,
        0.38,
    ),
    (overhead_camera((640, 480), 2.4, (0.5, 0.4), 2.5, 0.075), 0.037, 0.038),
    (tilted_camera(), 0.206, 0.65),  # seen at up to 48 degrees: pixels are no longer square
]


@pytest.mark.parametrize(("camera", "position_mm", "heading_deg"), CAMERAS)
def test_other_cameras(camera: CameraModel, position_mm: float, heading_deg: float) -> None:
    errors, _ = fitted(make_world(camera=camera), seed=12)
    position, heading = rms(errors)
    assert position < position_mm
    assert heading < heading_deg


def test_chroma_siting_is_a_property_of_the_camera() -> None:
    shifted = SensorModel(3.0, 0.6, 0.3, chroma_offset_px=(0.5, -0.5))
    errors, _ = fitted(make_world(sensor=shifted), seed=13)
    assert rms(errors)[0] < 0.108
    right, wrong = make_world(), make_world(sensor=shifted)
    errors, _ = fitted(World(right.eye, wrong.renderer), seed=13)
    assert np.hypot(*errors[:, :2].mean(axis=0)) > 0.5e-3  # unknown, it is a bias


def test_other_layouts_need_no_other_code() -> None:
    pairs = (("red", "green"), ("violet", "red"), ("green", "red"))
    worn = (TRIANGLE.worn_by(n, (("$left", a), ("$back", b))) for n, (a, b) in enumerate(pairs))
    tags = TagSet(tuple(worn), mirror_twins=True)
    errors, _ = fitted(make_world(tags=tags), seed=14)
    position, heading = rms(errors)
    assert position < 0.128
    assert heading < 0.167


def test_colours_are_unmixed() -> None:
    world = make_world(sensor=SensorModel(0.0, 0.6, 0.0, chroma="444"))
    truth = np.array([[0.2, 0.3, 0.4], [0.6, 0.5, 2.0], [1.1, 0.2, -1.0]])
    fit = fitted_from(world, world.frame(truth).image, world.eye.looks.shape_of, truth)
    wanted = np.array([(12, 12, 12), (30, 225, 255), (40, 20, 190)])
    np.testing.assert_allclose(fit.colors[0, 1:3], wanted[1:], atol=6.0)
    np.testing.assert_allclose(fit.colors[0, 0], wanted[0], atol=15.0)  # a rim of 0.7 px


def test_a_robot_does_not_depend_on_who_is_fitted_with_it() -> None:
    world = make_world()
    truth = world.scattered(np.random.default_rng(1))
    image = world.frame(truth).image
    together = fitted_from(world, image, world.eye.looks.shape_of, truth)
    for n in range(3):
        alone = fitted_from(world, image, world.eye.looks.shape_of[n : n + 1], truth[n : n + 1])
        np.testing.assert_allclose(alone.poses[0], together.poses[n], atol=1e-7)


def test_the_same_picture_gives_the_same_bits() -> None:
    world = make_world()
    truth = world.scattered(np.random.default_rng(2))
    frame = world.frame(truth)

    def run() -> Fit:
        return fitted_from(world, frame.image, world.eye.looks.shape_of, truth)

    assert run().poses.tobytes() == run().poses.tobytes()


def test_thinning_large_tags_keeps_the_accuracy() -> None:
    camera = overhead_camera((640, 480), 0.9, (0.1, 0.2), 2.0, 0.075)
    world = make_world(camera=camera)
    pixels = world.eye.gauge.pixels
    assert (pixels.shares[..., 1:] / pixels.strides.prod(axis=3, keepdims=True)).max() < 0.7 * 2**32
    errors, _ = fitted(world, seed=15, frames=40)
    position, heading = rms(errors)
    assert position < 0.036
    assert heading < 0.026


def test_unknown_chroma_is_refused() -> None:
    with pytest.raises(VisionError, match="chroma 411"):
        ChromaModel("411")
    assert Optics(chroma=ChromaModel("420", upsampling="nearest")).chroma.extra_blur_px == 0.0


def test_predictions_some_millimetres_off_are_followed() -> None:
    world = make_world(camera=paper_camera(), tags=two_patch_tags(3))
    rng = np.random.default_rng(16)
    for number in range(6):
        truth = world.scattered(rng)
        near = truth + rng.uniform(-1.0, 1.0, truth.shape) * (0.004, 0.004, radians(8))
        expected = tuple(
            Prediction(robot_id, Pose2D(*row), np.eye(3))
            for robot_id, row in zip(world.eye.tags.ids, near.tolist(), strict=True)
        )
        scene = locate(world.frame(truth, number), world.eye, expected)
        errors = errors_of(scene.detections, dict(zip(world.eye.tags.ids, truth, strict=True)))
        assert len(errors) == 3
        assert 1e3 * np.abs(errors[:, :2]).max() < 0.8


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e300, -1e9])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_starts_that_are_nowhere_end_nowhere(value: float, axis: int) -> None:
    world = make_world()
    start = np.full((1, 3), 0.4)
    start[0, axis] = value
    image, gauge, shape = (
        np.full((240, 320, 3), 90, np.uint8),
        world.eye.gauge,
        np.zeros(1, np.intp),
    )
    for center in ((100.0, 80.0), (np.nan, 5.0), (1e300, -1e300)):
        for steps in (1, 2, 12):
            fit = fit_poses(image, gauge, shape, start, np.array([center]), steps)
            told = fit.covariances[0, 0, 0] + fit.covariances[0, 1, 1]
            assert not (fit.residual_px[0] < 0.5 and told < 0.01**2)
