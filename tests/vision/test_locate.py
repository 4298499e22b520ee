"""Frame in, scene out: who is found, who is refused and why, and that nothing makes it fall."""

from dataclasses import replace
from math import degrees, hypot, pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from control.geometry import Pose2D, wrap_angle
from control.unicycle import UnicycleState
from datasets.cycle import RobotState
from datasets.sensor import SensorModel
from tests.vision.worlds import (
    PAPER_SENSOR,
    TRIANGLE,
    World,
    errors_of,
    make_world,
    paper_camera,
    pose_of,
    two_patch_tags,
)
from vision.errors import VisionError
from vision.eye import Thresholds
from vision.frame import Frame, as_frame
from vision.locate import Prediction, locate
from vision.scene import Scene
from vision.tags import TagSet

SHARP = np.diag((1e-6, 1e-6, 1e-4))


@pytest.fixture(scope="module")
def paper() -> World:
    return make_world()


def predicted(world: World, poses: np.ndarray) -> tuple[Prediction, ...]:
    pairs = zip(world.eye.tags.ids, poses, strict=True)
    return tuple(Prediction(robot_id, pose_of(row), SHARP) for robot_id, row in pairs)


def found(scene: Scene) -> list[int | str]:
    return [detection.robot_id for detection in scene.detections]


JPEG = replace(PAPER_SENSOR, jpeg_quality=85)
CASES = [  # size, robots, sensor, largest rms [mm], [deg]; the task's limits are 0.8 mm, 0.8 deg
    ((320, 240), 3, PAPER_SENSOR, 0.25, 0.40),
    ((640, 480), 7, PAPER_SENSOR, 0.20, 0.30),
    ((320, 240), 7, JPEG, 0.45, 0.80),
]


@pytest.mark.parametrize(("size", "robots", "sensor", "position_mm", "heading_deg"), CASES)
@pytest.mark.parametrize("follow", [False, True])
def test_everybody_is_found_and_nobody_else(
    size: tuple[int, int],
    robots: int,
    sensor: SensorModel,
    position_mm: float,
    heading_deg: float,
    follow: bool,
) -> None:
    world = make_world(camera=paper_camera(size), tags=two_patch_tags(robots), sensor=sensor)
    rng = np.random.default_rng(21)
    errors = []
    for number in range(12):
        truth = world.scattered(rng)
        near = truth + rng.normal(0.0, 1.0, truth.shape) * (0.003, 0.003, 0.05)
        expected = predicted(world, near) if follow else ()
        scene = locate(world.frame(truth, number), world.eye, expected)
        assert found(scene) == list(world.eye.tags.ids)
        errors.append(errors_of(scene.detections, dict(zip(found(scene), truth, strict=True))))
    every = np.concatenate(errors)
    assert np.sqrt((every[:, :2] ** 2).sum(axis=1).mean()) < 1e-3 * position_mm
    assert degrees(np.sqrt((every[:, 2] ** 2).mean())) < heading_deg


def test_the_screen_pose_belongs_to_the_floor_pose(paper: World) -> None:
    truth = paper.scattered(np.random.default_rng(3))
    for detection in locate(paper.frame(truth), paper.eye).detections:
        wanted = paper.eye.camera.pixel_pose(detection.pose)
        assert hypot(wanted.x - detection.pixel.x, wanted.y - detection.pixel.y) < 1e-9
        assert abs(wrap_angle(wanted.heading - detection.pixel.heading)) < 1e-6
        assert 0.8 < detection.confidence <= 1.0
        assert 0.0 < detection.residual_px < 0.5
        assert not detection.covariance.flags.writeable


def test_other_layouts_need_no_other_code() -> None:
    pairs = (("red", "green"), ("violet", "red"), ("green", "red"))
    worn = (TRIANGLE.worn_by(n, (("$left", a), ("$back", b))) for n, (a, b) in enumerate(pairs))
    world = make_world(tags=TagSet(tuple(worn), mirror_twins=True))
    rng = np.random.default_rng(22)
    for number in range(8):
        truth = world.scattered(rng)
        scene = locate(world.frame(truth, number), world.eye)
        assert found(scene) == [0, 1, 2]
        errors = errors_of(scene.detections, dict(zip(found(scene), truth, strict=True)))
        assert 1e3 * np.abs(errors[:, :2]).max() < 0.8


def test_a_carried_off_robot_is_found_again(paper: World) -> None:
    truth = np.array([[0.1, 0.1, 0.3], [0.5, 0.7, 2.0], [1.2, 0.2, -1.0]])
    expected = predicted(paper, truth + np.array([[0, 0, 0], [0.3, -0.1, 0.5], [0, 0, 0]]))
    scene = locate(paper.frame(truth), paper.eye, expected)
    assert found(scene) == [1, 2, 3]
    errors = errors_of(scene.detections, dict(zip(found(scene), truth, strict=True)))
    assert 1e3 * np.abs(errors[:, :2]).max() < 0.8


def test_headings_are_never_turned_round_by_a_wrong_prediction(paper: World) -> None:
    truth = np.array([[0.1, 0.1, 0.3], [0.5, 0.7, 2.0], [1.2, 0.2, -1.0]])
    expected = predicted(paper, truth + np.array([0.0, 0.0, pi]))
    scene = locate(paper.frame(truth), paper.eye, expected)
    errors = errors_of(scene.detections, dict(zip(found(scene), truth, strict=True)))
    assert len(errors) == 3
    assert degrees(np.abs(errors[:, 2]).max()) < 2.0


def test_predictions_that_make_no_sense_do_no_harm(paper: World) -> None:
    truth = paper.scattered(np.random.default_rng(5))
    nowhere = (
        Prediction("stranger", Pose2D(0.5, 0.4, 0.0), SHARP),
        Prediction(1, Pose2D(1e6, -1e6, 0.0), SHARP),
        Prediction(2, Pose2D(float("nan"), 0.0, float("nan")), SHARP),
        Prediction(3, Pose2D(float("inf"), 0.0, 1.0), SHARP),
    )
    assert found(locate(paper.frame(truth), paper.eye, nowhere)) == [1, 2, 3]


def reasons_at(scene: Scene, world: World, pose: np.ndarray) -> str:
    """Reasons given within a plate's width of a pose."""
    pixel = world.eye.camera.pixel_pose(pose_of(pose))
    near = [r for r in scene.rejected if hypot(r.x - pixel.x, r.y - pixel.y) < 12.0]
    return "; ".join(rejection.reason for rejection in near)


def test_a_tag_cut_by_the_border_is_refused_with_the_reason(paper: World) -> None:
    edge = paper.eye.camera.to_floor(np.array([[2.0, 100.0]]), 0.075)[0]
    truth = np.array([[*edge, 1.6], [0.5, 0.7, 2.0], [1.2, 0.2, -1.0]])
    for expected in ((), predicted(paper, truth)):
        scene = locate(paper.frame(truth), paper.eye, expected)
        assert found(scene) == [2, 3]
        reasons = "; ".join(rejection.reason for rejection in scene.rejected)
        assert "cut by the image border" in reasons or "patch without" in reasons


def painted(frame: Frame, world: World, pose: np.ndarray, part: int, bgr: tuple[int, ...]) -> Frame:
    """The frame with one part of a tag painted over."""
    image = frame.image.copy()
    eye = world.eye
    c, s = np.cos(pose[2]), np.sin(pose[2])
    h, w = image.shape[:2]
    x, y = np.meshgrid(np.arange(w), np.arange(h))
    pixels = np.column_stack((x.ravel(), y.ravel())).astype(float)
    away = eye.camera.to_floor(pixels, eye.camera.tag_height).reshape(h, w, 2) - pose[:2]
    u, v = c * away[..., 0] + s * away[..., 1], c * away[..., 1] - s * away[..., 0]
    polygon = eye.tags.tags[0].parts[part].polygon
    low, high = polygon.min(axis=0) - 0.003, polygon.max(axis=0) + 0.003
    image[(u > low[0]) & (u < high[0]) & (v > low[1]) & (v < high[1])] = bgr
    return as_frame(image, frame.t_capture, frame.sequence)


def test_a_front_without_a_rear_is_refused_with_the_distance(paper: World) -> None:
    truth = np.array([[0.1, 0.1, 0.0], [0.5, 0.7, 2.0], [1.2, 0.2, -1.0]])
    frame = painted(paper.frame(truth), paper, truth[0], 2, (12, 12, 12))
    scene = locate(frame, paper.eye)
    assert found(scene) == [2, 3]
    assert "front patch without rear patch within" in reasons_at(scene, paper, truth[0])
    assert " px" in reasons_at(scene, paper, truth[0])


def test_an_unknown_rear_is_refused_with_the_colours(paper: World) -> None:
    truth = np.array([[0.1, 0.1, 0.0], [0.5, 0.7, 2.0], [1.2, 0.2, -1.0]])
    frame = painted(paper.frame(truth), paper, truth[0], 2, (190, 25, 160))
    scene = locate(frame, paper.eye, predicted(paper, truth))
    assert found(scene) == [2, 3]
    assert scene.rejected


def test_an_id_is_given_once_and_the_loser_is_told(paper: World) -> None:
    truth = np.array([[0.1, 0.1, 0.0], [0.5, 0.7, 2.0], [1.2, 0.2, -1.0]])
    states = tuple(
        RobotState(robot_id, UnicycleState(*pose, 0.0, 0.0))
        for robot_id, pose in zip((2, 2, 3), truth.tolist(), strict=True)
    )
    frame = as_frame(paper.renderer.render(states, 0.0), 0.0, 0)
    scene = locate(frame, paper.eye)
    assert found(scene) == [2, 3]
    assert any("id 2 already taken by a better candidate" in r.reason for r in scene.rejected)


def test_another_size_is_an_error_with_both_sizes(paper: World) -> None:
    frame = as_frame(np.zeros((480, 640, 3), np.uint8), 0.0, 0)
    with pytest.raises(VisionError, match=r"640 x 480 px.*320 x 240 px"):
        locate(frame, paper.eye)


@pytest.mark.parametrize("bgr", [(0, 0, 0), (255, 255, 255), (30, 225, 255), (40, 20, 190)])
def test_flat_frames_show_nobody(paper: World, bgr: tuple[int, int, int]) -> None:
    image = np.full((240, 320, 3), bgr, np.uint8)
    expected = predicted(paper, paper.scattered(np.random.default_rng(0)))
    for predictions in ((), expected):
        assert locate(as_frame(image, 0.0, 0), paper.eye, predictions).detections == ()


def test_noise_shows_nobody_and_the_limits_are_told(paper: World) -> None:
    rng = np.random.default_rng(9)
    limits = Thresholds(max_blobs=50, max_candidates=3)
    eye = replace(paper.eye, thresholds=limits, min_blob_px=1.0)
    for number in range(5):
        image = rng.integers(0, 256, (240, 320, 3)).astype(np.uint8)
        assert locate(as_frame(image, 0.0, number), paper.eye).detections == ()
        scene = locate(as_frame(image, 0.0, number), eye)
        assert scene.detections == ()
        assert any("smaller blobs beyond 50 not looked at" in r.reason for r in scene.rejected)
        assert len(scene.rejected) < 120


def confetti(seed: int, size: tuple[int, int], cell: int) -> np.ndarray:
    """Squares of random tag colours: as many candidates as can be."""
    rng = np.random.default_rng(seed)
    colors = np.array([(12, 12, 12), (30, 225, 255), (40, 20, 190), (40, 140, 15), (210, 70, 30)])
    rows, columns = -(-size[1] // cell), -(-size[0] // cell)
    tiles = colors[rng.integers(0, len(colors), (rows, columns))].astype(np.uint8)
    return np.repeat(np.repeat(tiles, cell, 0), cell, 1)[: size[1], : size[0]]


@pytest.mark.parametrize("cell", [3, 4, 5, 8])
def test_confetti_is_bounded_and_gives_no_id_twice(paper: World, cell: int) -> None:
    for seed in range(3):
        scene = locate(as_frame(confetti(seed, (320, 240), cell), 0.0, seed), paper.eye)
        assert len(set(found(scene))) == len(found(scene))
        assert len(scene.rejected) < 200


ODD = make_world(camera=paper_camera((39, 23)), tags=two_patch_tags(2))
TINY = make_world(camera=paper_camera((5, 3)), tags=two_patch_tags(2))


@given(data=st.data(), which=st.sampled_from([ODD, TINY]), follow=st.booleans())
@settings(max_examples=60)
def test_no_picture_makes_it_fall(data: st.DataObject, which: World, follow: bool) -> None:
    w, h = which.eye.camera.size_px
    shade = st.sampled_from([0, 12, 30, 40, 190, 225, 255])
    image = data.draw(arrays.arrays(np.uint8, (h, w, 3), elements=shade))
    expected = predicted(which, np.array([[0.5, 0.4, 0.1], [0.2, 0.9, 3.0]])) if follow else ()
    scene = locate(as_frame(image, 0.0, 0), which.eye, expected)
    assert len(set(found(scene))) == len(found(scene))
    for detection in scene.detections:
        assert np.isfinite(detection.covariance).all()
    assert all(np.isfinite((r.x, r.y)).all() for r in scene.rejected)


def test_the_same_frame_gives_the_same_scene(paper: World) -> None:
    truth = paper.scattered(np.random.default_rng(6))
    frame = paper.frame(truth)
    assert repr(locate(frame, paper.eye)) == repr(locate(frame, paper.eye))
