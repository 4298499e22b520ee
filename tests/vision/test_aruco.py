"""Printed markers against rendered truth: poses, covariance, and what is not accepted."""

import numpy as np
import pytest
from numpy.typing import NDArray

from control.geometry import Pose2D
from control.unicycle import UnicycleState
from datasets.cycle import RobotState
from datasets.render import Renderer
from datasets.sensor import SensorModel
from tests.vision.worlds import errors_of, paper_camera
from vision.aruco import ArucoDetector
from vision.camera import CameraModel, overhead_camera
from vision.errors import VisionError
from vision.frame import Frame, as_frame
from vision.light import PALETTE_LIGHT
from vision.locate import Prediction
from vision.markers import MarkerSet, fitting_side, marker_cells
from vision.palette import NamedColor
from vision.scene import Scene

WHITE = NamedColor("white", (255, 255, 255))
SENSOR = SensorModel(read_noise=3.0, blur_px=0.6, uneven_light=0.3, chroma="420")
SIDE = fitting_side("4x4_50", 0.075)
GRID = np.column_stack(([-0.5, 0.5, 1.5] * 3, np.repeat([-0.2, 0.4, 1.0], 3), np.zeros(9)))
Poses = NDArray[np.float64]


def markers(count: int = 9, dictionary: str = "4x4_50", first: int = 0) -> MarkerSet:
    """Robots 1 to `count` with consecutive markers."""
    side = fitting_side(dictionary, 0.075)
    return MarkerSet(dictionary, side, tuple((n + 1, first + n) for n in range(count)))


def picture(camera: CameraModel, worn: MarkerSet, poses: Poses, sensor: SensorModel) -> Frame:
    """One frame of the robots at poses (R, 3)."""
    return taken(Renderer(camera, worn.tags, (WHITE,), sensor), poses)


def taken(renderer: Renderer, poses: Poses) -> Frame:
    """A frame of robots 1, 2... at poses (R, 3)."""
    states = tuple(
        RobotState(number, UnicycleState(*pose, 0.0, 0.0))
        for number, pose in enumerate(poses.tolist(), 1)
    )
    return as_frame(renderer.render(states, 0.0), 0.0, 0)


def scattered(rng: np.random.Generator) -> Poses:
    """Nine robots near the points of a grid, with random headings."""
    shift = np.column_stack((rng.uniform(-0.1, 0.1, (9, 2)), rng.uniform(-np.pi, np.pi, 9)))
    return np.asarray(GRID + shift)


def look(detector: ArucoDetector, frame: Frame, *predictions: Prediction) -> Scene:
    return detector.locate(frame, predictions, PALETTE_LIGHT)


def sighted(width: int, frames: int) -> tuple[float, Poses, list[float]]:
    """Recall, pose errors (N, 3) [m, m, rad] and squared normalised errors."""
    camera, worn = paper_camera((width, width * 3 // 4)), markers()
    detector, renderer = ArucoDetector(camera, worn), Renderer(camera, worn.tags, (WHITE,), SENSOR)
    rng, errors, surprise = np.random.default_rng(3), [], []
    for _ in range(frames):
        truth = scattered(rng)
        seen = look(detector, taken(renderer, truth)).detections
        rows = errors_of(seen, dict(zip(worn.tags.ids, truth, strict=True)))
        errors.append(rows)
        pairs = zip(rows, seen, strict=True)
        surprise += [float(e @ np.linalg.solve(d.covariance, e)) for e, d in pairs]
    every = np.concatenate(errors)
    return len(every) / (9 * frames), every, surprise


@pytest.mark.parametrize(
    ("width", "recall", "position_mm", "heading_deg"),
    [(640, 0.95, 0.2, 0.08), (960, 1.0, 0.05, 0.05)],  # markers 15 and 23 px wide
)
def test_poses_under_the_papers_sensor(
    width: int, recall: float, position_mm: float, heading_deg: float
) -> None:
    found, errors, surprise = sighted(width, 8)
    assert found >= recall
    assert 1e3 * np.sqrt((errors[:, :2] ** 2).sum(axis=1).mean()) < position_mm
    assert np.degrees(np.sqrt((errors[:, 2] ** 2).mean())) < heading_deg
    assert np.mean(surprise) / 3.0 < 1.5  # the covariance does not promise too much


def test_poses_through_a_distorting_lens_at_the_border() -> None:
    lens = (-0.15, 0.03, 0.001, -0.001, 0.0)
    camera = overhead_camera((960, 720), 2.4, (0.5, 0.4), 1.8, 0.075, lens)
    worn = markers(4)
    truth = np.array([[1.5, 1.1, 0.3], [-0.5, 1.1, 2.0], [1.5, -0.3, -1.0], [0.5, 0.4, 3.1]])
    frame = picture(camera, worn, truth, SensorModel(read_noise=0.0, blur_px=0.6, chroma="444"))
    errors = errors_of(
        look(ArucoDetector(camera, worn), frame).detections, dict(enumerate(truth, 1))
    )
    assert len(errors) == 4
    assert 1e3 * np.abs(errors[:, :2]).max() < 0.1
    assert np.degrees(np.abs(errors[:, 2]).max()) < 0.1


@pytest.mark.parametrize("dictionary", ["5x5_100", "apriltag_36h11"])
def test_other_dictionaries(dictionary: str) -> None:
    camera, worn = paper_camera((1440, 1080)), markers(9, dictionary, first=20)
    truth = scattered(np.random.default_rng(0))
    scene = look(ArucoDetector(camera, worn), picture(camera, worn, truth, SENSOR))
    assert [d.robot_id for d in scene.detections] == list(range(1, 10))
    assert min(d.confidence for d in scene.detections) > 0.9
    errors = errors_of(scene.detections, dict(enumerate(truth, 1)))
    assert np.degrees(np.abs(errors[:, 2]).max()) < 0.5


def test_a_marker_seen_twice_is_the_robot_where_it_is_expected() -> None:
    camera = paper_camera((960, 720))
    twins = MarkerSet("4x4_50", SIDE, ((1, 7), (2, 8)))
    copies = tuple(type(twins.tags.tags[0])(i, twins.tags.tags[0].parts) for i in (1, 2))
    renderer = Renderer(camera, _Bare(copies), (WHITE,), SENSOR)  # type: ignore[arg-type]
    here, there = UnicycleState(0.2, 0.3, 0.5, 0, 0), UnicycleState(0.9, 0.3, 0.5, 0, 0)
    frame = as_frame(renderer.render((RobotState(1, here), RobotState(2, there)), 0.0), 0.0, 0)
    detector = ArucoDetector(camera, twins)
    scene = look(detector, frame)
    assert scene.detections == ()
    assert [r.reason for r in scene.rejected] == ["the marker of robot 1 is seen 2 times"] * 2
    expected = Prediction(1, Pose2D(0.88, 0.31, 0.4), np.eye(3) * 1e-4)
    (seen,) = look(detector, frame, expected).detections
    assert seen.pose.x == pytest.approx(0.9, abs=1e-3)


class _Bare:
    """Tags that no `TagSet` would accept."""

    def __init__(self, tags: tuple[object, ...]) -> None:
        self.tags, self.colors, self.outer_radius = tags, ("white", "black"), 0.053


def test_foreign_and_wrongly_sized_markers_are_named() -> None:
    camera, poses = paper_camera((960, 720)), np.array([[0.0, 0.4, 0.1], [1.0, 0.4, 0.2]])
    frame = picture(camera, markers(2, first=30), poses, SENSOR)
    assert [r.reason for r in look(ArucoDetector(camera, markers(9)), frame).rejected] == [
        "marker 30 is worn by no robot",
        "marker 31 is worn by no robot",
    ]
    large = MarkerSet("4x4_50", 0.100, ((1, 30), (2, 31)))
    reasons = [r.reason for r in look(ArucoDetector(camera, large), frame).rejected]
    assert len(reasons) == 2
    assert all("mm wide, the robots' are 100 mm" in reason for reason in reasons)


def test_a_damaged_marker_is_rejected_with_a_reason() -> None:
    camera, worn = paper_camera((960, 720)), markers(1)
    frame = picture(camera, worn, np.array([[0.5, 0.4, 0.0]]), SENSOR)
    (seen,) = look(ArucoDetector(camera, worn), frame).detections
    image = frame.image.copy()
    x, y = round(seen.pixel.x), round(seen.pixel.y)
    image[y - 7 : y + 8, x - 7 : x + 8] = (0, 0, 255)
    scene = look(ArucoDetector(camera, worn), as_frame(image, 0.0, 0))
    assert scene.detections == ()
    assert any("no marker of 4x4_50" in r.reason for r in scene.rejected)


@pytest.mark.parametrize("kind", ["black", "noise", "stripes"])
def test_nothing_is_found_where_nothing_is(kind: str) -> None:
    rng, camera = np.random.default_rng(2), paper_camera((320, 240))
    pictures = {
        "black": np.zeros((240, 320, 3)),
        "noise": rng.integers(0, 256, (240, 320, 3)),
        "stripes": np.tile((np.arange(320) // 8 % 2 * 255)[:, None], (240, 1, 3)),
    }
    frame = as_frame(pictures[kind].astype(np.uint8), 0.0, 0)
    assert look(ArucoDetector(camera, markers()), frame).detections == ()


def test_the_same_frame_gives_the_same_bits() -> None:
    camera, worn = paper_camera((640, 480)), markers()
    frame = picture(camera, worn, scattered(np.random.default_rng(5)), SENSOR)
    one, other = (look(ArucoDetector(camera, worn), frame) for _ in range(2))
    assert [repr(d) for d in one.detections] == [repr(d) for d in other.detections]


def test_frames_of_another_size_are_refused() -> None:
    frame = as_frame(np.zeros((90, 160, 3), np.uint8), 0.0, 0)
    with pytest.raises(VisionError, match="frame of 160 x 90 px, but the camera model is for 320"):
        look(ArucoDetector(paper_camera(), markers()), frame)


def test_the_tag_is_the_marker_drawn() -> None:
    worn = markers(1, first=7)
    (tag,) = worn.tags.tags
    white = sum(part.area for part in tag.parts[2:])
    cells = marker_cells("4x4_50", 7)
    assert tag.side == pytest.approx(0.075)
    assert tag.parts[1].area == pytest.approx(SIDE**2)
    assert white == pytest.approx(cells.sum() * (SIDE / 6) ** 2)


@pytest.mark.parametrize(
    ("dictionary", "worn", "message"),
    [
        ("4x4_50", ((1, 3), (2, 3)), "robots 1 and 2 cannot be told apart: both wear marker 3"),
        ("4x4_50", ((1, 50),), "marker 50: 4x4_50 has markers 0 to 49"),
        ("3x3_9", ((1, 0),), 'no marker dictionary "3x3_9"; there are: 4x4_100'),
    ],
)
def test_wrong_markers_are_refused(
    dictionary: str, worn: tuple[tuple[int, int], ...], message: str
) -> None:
    with pytest.raises(VisionError, match=message):
        MarkerSet(dictionary, SIDE, worn)
