"""The camera calibration against cameras of known truth, and what it refuses."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from numpy.typing import NDArray

from datasets.render import Renderer
from datasets.sensor import SensorModel
from tests.scenes.field import COLORS, robot, two_patch_tags
from tests.vision.filmed_boards import (
    BOARD,
    CHECKERS,
    PLACES,
    SENSOR,
    film,
    filmed_set,
    flat_pose,
    floor_errors,
    found,
    held_poses,
    ideal,
    tilted,
)
from vision.calibration.board import Board
from vision.calibration.bundle import LENS, Problem, Seen, State, adjust, projected
from vision.calibration.camera import calibrate_floor, calibrate_lens, with_points
from vision.calibration.detect import BoardView, make_view
from vision.calibration.floor import FloorFrame, floor_spread
from vision.calibration.points import KnownPoint
from vision.calibration.result import given_lens
from vision.calibration.selection import Selection, offer
from vision.calibration.views import complaints, lacking_regions
from vision.camera import CameraModel
from vision.errors import VisionError
from vision.eye import make_eye
from vision.frame import as_frame
from vision.locate import locate
from vision.optics import ChromaModel, Optics
from vision.palette import palette_from_colors

Floats = NDArray[np.float64]

FIRST = FloorFrame()


def lens_of(camera: CameraModel) -> Floats:
    """The nine numbers of a camera's lens."""
    m = camera.matrix
    return np.array((m[0, 0], m[1, 1], m[0, 2], m[1, 2], *camera.distortion))


@pytest.mark.parametrize("board", [BOARD, CHECKERS], ids=["charuco", "chessboard"])
@pytest.mark.parametrize(
    ("sensor", "limit_px"),
    [(SENSOR, 0.02), (SensorModel(3.0, 1.1, 0.3, jpeg_quality=85), 0.03)],
    ids=["clean", "soft JPEG"],
)
def test_corners_are_found_to_hundredths_of_a_pixel(
    board: Board, sensor: SensorModel, limit_px: float
) -> None:
    camera, off = tilted(), []
    poses = held_poses(camera, 12)[4:10:2]
    for view, (rotation, place) in zip(found(film(camera, board, sensor), poses, board), poses,
                                       strict=True):  # fmt: skip
        off.append(view.pixels - camera.project(view.points(board) @ rotation.T + place))
        assert len(view.ids) >= 15
    assert np.sqrt(np.mean(np.vstack(off) ** 2)) < limit_px


@pytest.mark.parametrize(("width", "rms_mm", "most_mm"), [(640, 0.3, 2.0), (1280, 0.15, 1.0)])
def test_a_filmed_board_gives_the_camera_back(width: int, rms_mm: float, most_mm: float) -> None:
    truth, (held, laid) = tilted(width), filmed_set(width)
    calibration = calibrate_lens(BOARD, held, laid, FIRST)
    np.testing.assert_allclose(calibration.lens[:2], lens_of(truth)[:2], rtol=1e-3)
    np.testing.assert_allclose(calibration.lens[2:4], lens_of(truth)[2:4], atol=1.0)
    camera = calibration.camera(0.075)
    off = 1e3 * floor_errors(camera, truth)
    assert np.sqrt(np.mean(off**2)) < rms_mm
    assert off.max() < most_mm
    np.testing.assert_allclose(camera.position, truth.position, atol=2e-3)
    assert calibration.rms_px < 0.03
    assert calibration.cross_px < 0.03


def test_the_stated_errors_are_honest() -> None:
    truth, (held, laid) = tilted(), filmed_set(640)
    for places in (laid, laid[:1]):
        calibration = calibrate_lens(BOARD, held, places, FIRST)
        floor = calibration.floor
        assert floor is not None
        off = (calibration.lens - lens_of(truth)) / calibration.deviations
        assert np.abs(off).max() < 4.0
        camera = calibration.camera(0.075)
        _, spread = floor_spread(
            calibration.size_px, calibration.lens, floor.pose, floor.covariance, 0.075
        )
        ratio = np.sqrt(np.mean(floor_errors(camera, truth) ** 2) / np.mean(spread**2))
        assert 0.1 < ratio < 3.0
        assert np.sqrt(np.mean(floor_errors(camera, truth) ** 2)) < 1e-3


def test_the_board_may_lie_anywhere_in_the_floor_frame() -> None:
    truth = tilted()
    held, _ = filmed_set(640)
    rotation, place = flat_pose(0.2, -0.1, 0.7)
    raised = place + np.array((0.0, 0.0, 0.006))
    (view,) = found(film(truth), [(rotation, raised)], first=50)
    frame = FloorFrame(float(place[0]), float(place[1]), 0.7, 0.006)
    for calibration in (
        calibrate_lens(BOARD, held, [view], frame),
        calibrate_floor(BOARD, lens_of(truth), [view], frame),
    ):
        off = floor_errors(calibration.camera(0.075), truth)
        assert np.sqrt(np.mean(off**2)) < 1.5e-3


def test_no_more_distortion_is_fitted_than_the_pictures_show() -> None:
    straight = replace(tilted(), distortion=np.zeros(5))
    views = found(film(straight), held_poses(straight, 9, seed=5))
    calibration = calibrate_lens(BOARD, views, (), FIRST)
    assert calibration.terms in ("no distortion", "k1")
    assert calibration.floor is None


def test_a_wrong_corner_and_a_wrong_view_are_left_out_and_named() -> None:
    held, laid = filmed_set(640)
    shifted = moved(held[3], (slice(2, 3),), (3.0, -2.0))
    torn = moved(held[5], (slice(0, 14),), (6.0, 9.0))
    views = [*held[:3], shifted, held[4], torn, *held[6:]]
    calibration = calibrate_lens(BOARD, views, laid, FIRST)
    said = " ".join(calibration.left_out)
    assert f"{held[3].name}: 1 of" in said
    assert f"{held[5].name}: left out" in said
    off = floor_errors(calibration.camera(0.075), tilted())
    assert np.sqrt(np.mean(off**2)) < 0.5e-3


def moved(view: BoardView, which: tuple[slice, ...], way: tuple[float, float]) -> BoardView:
    """A view with some of its corners elsewhere."""
    pixels = view.pixels.copy()
    for part in which:
        pixels[part] += way
    return make_view(view.name, view.size_px, view.ids, pixels, view.blur_px)


def parallel_views() -> list[BoardView]:
    """Boards that lie flat at many places and at one height."""
    places = [(x, y) for x in (-0.6, -0.2, 0.2, 0.6) for y in (-0.3, 0.01, 0.3)]
    return [ideal(*flat_pose(x, y, 0.2 * x)) for x, y in places]


def test_poor_sets_are_refused_with_every_reason() -> None:
    held, laid = filmed_set(640)
    rng = np.random.default_rng(2)
    bent = [
        make_view(v.name, v.size_px, v.ids, v.pixels + rng.normal(0, 2.0, v.pixels.shape), 2.0)
        for v in held
    ]
    for views, reason in (
        (held[:4], "4 views show the board, 6 are needed"),
        ([held[0]] * 8, "of 8 views only 1 differ"),
        (parallel_views(), "nearly parallel"),
        (bent, "reprojection error"),
    ):
        with pytest.raises(VisionError, match=reason):
            calibrate_lens(BOARD, views, (), FIRST)
    twin = Board("chessboard", 8, 6, 0.04)
    with pytest.raises(VisionError, match="looks the same upside down"):
        calibrate_floor(twin, lens_of(tilted()), laid, FIRST)


def test_where_corners_are_lacking_is_said() -> None:
    small = [ideal(*flat_pose(-0.45 + 0.01 * i, -0.3, 0.8 * i)) for i in range(8)]
    size = small[0].size_px
    said = " ".join(complaints(small, size))
    assert "% of the image" in said
    assert "top right" in lacking_regions(small, size)
    assert "in one ninth" in said


def test_a_board_raised_off_the_floor_is_noticed() -> None:
    held, laid = filmed_set(640)
    flat = [ideal(*flat_pose(*place), f"f{i}.png") for i, place in enumerate(PLACES)]
    rotation, place = flat_pose(*PLACES[2])
    lean = np.array([[1, 0, 0], [0, 0.98, -0.199], [0, 0.199, 0.98]])
    flat[2] = ideal(lean @ rotation, place + np.array((0.0, 0.0, 0.05)), "leaning.png")
    with pytest.raises(VisionError, match=r"leaning\.png"):
        calibrate_floor(BOARD, lens_of(tilted()), flat, FIRST)
    torn = [moved(laid[0], (slice(0, 14),), (6.0, 9.0)), *laid[1:]]
    with pytest.raises(VisionError, match=r"view100\.png gives the floor frame, but does not fit"):
        calibrate_lens(BOARD, held, torn, FIRST)


GRID = [(-0.6, -0.3), (0.6, -0.35), (0.55, 0.4), (-0.5, 0.35), (0.0, 0.1), (0.2, -0.2), (-0.2, 0.2)]


def known_points(height: float = 0.0, noise_px: float = 0.2) -> list[KnownPoint]:
    """Points of the true camera, clicked with a little noise."""
    floor = np.column_stack((GRID, np.full(len(GRID), height)))
    pixels = tilted().project(floor) + np.random.default_rng(4).normal(0, noise_px, (len(GRID), 2))
    pairs = zip(floor.tolist(), pixels.tolist(), strict=True)
    return [KnownPoint(str(n), (*f,), (*p,)) for n, (f, p) in enumerate(pairs, 1)]  # type: ignore[arg-type]


@pytest.mark.parametrize("height", [0.0, 0.075])
def test_known_points_give_the_floor(height: float) -> None:
    lens = given_lens(lens_of(tilted()), (640, 480))
    calibration = with_points(lens, known_points(height))
    off = floor_errors(calibration.camera(0.075), tilted())
    assert np.sqrt(np.mean(off**2)) < 3e-3
    assert calibration.floor is not None
    assert len(calibration.floor.errors) == len(GRID)
    assert 1e-4 < np.sqrt(np.mean(calibration.floor.errors**2)) < 5e-3


def swapped(p: KnownPoint) -> KnownPoint:
    """A point whose x and y were mixed up."""
    return replace(p, floor=(p.floor[1], p.floor[0], p.floor[2]))


def test_wrong_points_are_named() -> None:
    lens, good = given_lens(lens_of(tilted()), (640, 480)), known_points()
    sign = replace(good[1], floor=(-good[1].floor[0], *good[1].floor[1:]))
    for points, reason in (
        (good[:3], "3 points on the floor: 4 are needed"),
        ([swapped(p) for p in good], "mirrored"),
        ([*good[:2], swapped(good[2]), *good[3:]], r"point 3 .*x and y swapped"),
        ([good[0], sign, *good[2:]], r"point 2 .*the sign of x"),
        ([*good, good[0]], "at the same place"),
        ([*good, KnownPoint("out", (0.3, 0.3, 0.0), (900.0, 10.0))], "point out: .* outside"),
        ([replace(p, floor=(p.floor[0], 0.5 * p.floor[0], 0.0)) for p in good], "one line"),
    ):
        with pytest.raises(VisionError, match=reason):
            with_points(lens, points)


def test_robots_at_the_border_are_measured_through_the_calibrated_camera() -> None:
    truth, (held, laid) = tilted(), filmed_set(640)
    camera = calibrate_lens(BOARD, held, laid, FIRST).camera(0.075)
    tags = two_patch_tags(4)
    colors = tuple(c for c in COLORS if c.name in tags.colors)
    sensor = SensorModel(3.0, 0.6, chroma="444")
    w, h = truth.size_px
    border = np.array([[30, 40], [w - 40, 35], [w - 35, h - 35], [35, h - 40]], float)
    places = truth.to_floor(border, 0.075)
    states = tuple(
        robot(number, *place, 0.7 * number - pi / 2)
        for number, place in enumerate(places.tolist(), 1)
    )
    image = Renderer(truth, tags, colors, sensor).render(states, 0.0)
    palette = palette_from_colors(colors, noise=3.0)
    eye = make_eye(camera, tags, palette, Optics(0.6, 3.0, ChromaModel("444")))
    seen = {d.robot_id: d.pose for d in locate(as_frame(image, 0.0, 0), eye, ()).detections}
    assert set(seen) == {1, 2, 3, 4}
    for state in states:
        pose = seen[state.robot_id]
        off = np.hypot(pose.x - state.state.x, pose.y - state.state.y)
        assert off < 1e-3
        flat = truth.to_floor(truth.project(np.array([[state.state.x, state.state.y, 0.075]])), 0.0)
        assert np.hypot(*(flat[0] - (state.state.x, state.state.y))) > 0.02  # parallax matters


def test_the_derivatives_are_derivatives() -> None:
    rng = np.random.default_rng(0)
    points, lens = BOARD.corners[::3], lens_of(tilted())
    pose = np.array((2.8, -0.3, 0.2, -0.1, 0.1, 1.2))
    _, by_lens, by_pose = projected(points, pose, lens)
    slope, values = np.hstack((by_lens, by_pose)), np.concatenate((lens, pose))
    for index in range(LENS + 6):
        step = np.zeros_like(values)
        step[index] = 1e-6 * max(1.0, abs(values[index]))
        ends = [projected(points, v[LENS:], v[:LENS])[0] for v in (values + step, values - step)]
        wanted = (ends[0] - ends[1]) / (2 * step[index])
        np.testing.assert_allclose(slope[:, index], wanted, rtol=1e-4, atol=1e-4)
    start = State(lens, (pose + rng.normal(0, 0.02, 6))[None], np.zeros(6), np.zeros((0, 3)))
    seen = Seen(points, projected(points, pose, lens)[0].reshape(-1, 2))
    fit = adjust(Problem((seen,), None, (), np.zeros(LENS, np.bool_)), start)
    np.testing.assert_allclose(fit.state.held[0], pose, atol=1e-6)


def test_a_moving_board_gives_still_sharp_and_different_views() -> None:
    one, other = ideal(*flat_pose(-0.3, 0.1, 0.3)), ideal(*flat_pose(0.3, 0.1, 0.3))
    near = moved(one, (slice(None),), (1.0, 1.0))
    selection, said = Selection(), []
    for view in (None, one, one, one, near, near, other, replace(other, blur_px=4.0), other):
        selection, verdict = offer(selection, view)
        said.append(verdict)
    assert said == [
        "no board seen", "hold still", "kept", "move or tilt the board", "move or tilt the board",
        "move or tilt the board", "hold still", "blurred", "kept",
    ]  # fmt: skip
    assert len(selection.kept) == 2
    assert not selection.complete(2)
