"""The renderer against known areas and centroids; nothing is rounded to pixels."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest

from datasets.cycle import RobotState
from datasets.errors import SimulationError
from datasets.floor import Floor
from datasets.render import Renderer
from datasets.sensor import SensorModel
from tests.scenes.field import COLORS, SIDE, robot, scattered, two_patch_tags
from vision.camera import CameraModel, overhead_camera
from vision.palette import NamedColor

CAMERA = overhead_camera((320, 240), 2.4, (0.5, 0.4), 2.5, SIDE)
CLEAN = SensorModel(read_noise=0.0, blur_px=0.0, chroma="444")
DARK = Floor(bgr=(0.0, 0.0, 0.0), texture=0.0, line_width=0.0)
SCALE = 320 / 2.4 * 2.5 / (2.5 - SIDE)  # at the tags' height [px/m]


def drawn(
    states: tuple[RobotState, ...],
    sensor: SensorModel = CLEAN,
    camera: CameraModel = CAMERA,
    floor: Floor = DARK,
    seed: int = 0,
    t: float = 0.0,
) -> np.ndarray:
    """Render robots with two-patch tags."""
    tags = two_patch_tags(max((s.robot_id for s in states), default=1))
    return Renderer(camera, tags, COLORS, sensor, seed, floor).render(states, t)


def white_plates(states: tuple[RobotState, ...], sensor: SensorModel = CLEAN) -> np.ndarray:
    """Render tags of one colour, 200, on black: brightness / 200 is the coverage of the plates."""
    tags = two_patch_tags(len(states))
    colors = tuple(NamedColor(name, (200, 200, 200)) for name in tags.colors)
    image = Renderer(CAMERA, tags, colors, sensor, 0, DARK).render(states, 0.0)
    return image[..., 0].astype(float) / 200.0


def centroid(weights: np.ndarray) -> np.ndarray:
    """Weighted centre x, y [px]."""
    rows, columns = np.indices(weights.shape)
    return np.array([(weights * columns).sum(), (weights * rows).sum()]) / weights.sum()


def test_plates_have_their_area_and_place() -> None:
    rng = np.random.default_rng(1)
    for _ in range(25):
        state = robot(1, rng.uniform(-0.5, 1.5), rng.uniform(-0.3, 1.1), rng.uniform(-pi, pi))
        seen = white_plates((state,))
        assert seen.sum() == pytest.approx((SIDE * SCALE) ** 2, abs=0.05)  # px^2; 8-bit rounding
        pixel = CAMERA.pixel_pose(state.state.pose)
        # sharp edges sampled by pixels: up to c (1 - c) / 2 of a pixel's width per border pixel
        np.testing.assert_allclose(centroid(seen), (pixel.x, pixel.y), atol=0.013)


def test_lens_and_noise_do_not_displace() -> None:
    state = robot(1, 0.777, 0.333, 0.7)
    pixel = CAMERA.pixel_pose(state.state.pose)
    sensor = SensorModel(read_noise=0.0, blur_px=1.3, chroma="444")
    np.testing.assert_allclose(
        centroid(white_plates((state,), sensor)), (pixel.x, pixel.y), atol=0.003
    )


def test_nested_parts_show_their_own_colours_only() -> None:
    """Sum of each channel = sum over parts of visible area times colour."""
    state = robot(1, 0.412, 0.587, 0.9)
    tag = two_patch_tags(1).tags[0]
    colors = {color.name: np.array(color.bgr, float) for color in COLORS} | {
        "black": np.full(3, 12.0)
    }
    expected = sum(
        tag.visible_area(i) * SCALE**2 * colors[part.color] for i, part in enumerate(tag.parts)
    )
    seen = drawn((state,)).astype(float).sum(axis=(0, 1))
    np.testing.assert_allclose(seen, expected, atol=25.0)  # 8-bit rounding of about 140 pixels


def test_moves_by_a_hundredth_of_a_pixel() -> None:
    step = 0.01 / SCALE
    places = [
        centroid(white_plates((robot(1, 0.5 + k * step, 0.4, 0.3),)))[0] for k in range(0, 101, 10)
    ]
    np.testing.assert_allclose(np.diff(places), 0.1, atol=0.01)


def test_touching_plates_cover_no_pixel_twice() -> None:
    """Two squares side by side at any angle look like one rectangle."""
    for theta in (0.0, 0.3, 1.2):
        ahead = SIDE * np.array([np.cos(theta), np.sin(theta)])
        pair = (robot(1, 0.51, 0.43, theta), robot(2, 0.51 + ahead[0], 0.43 + ahead[1], theta))
        seen = white_plates(pair)
        assert seen.max() <= 1.0
        assert seen.sum() == pytest.approx(2.0 * (SIDE * SCALE) ** 2, abs=0.1)


def test_overlapping_robots_hide_one_another() -> None:
    pair = (robot(1, 0.5, 0.4), robot(2, 0.5 + 0.5 * SIDE, 0.4))
    seen = white_plates(pair)
    assert seen.max() <= 1.0
    # within 2 %: pixels on both borders count as if each robot had its own share of them
    assert seen.sum() == pytest.approx(1.5 * (SIDE * SCALE) ** 2, rel=0.02)


def test_empty_floor_is_seen_around_robots() -> None:
    """Away from the robots the picture is that of the empty floor, bit for bit."""
    sensor = SensorModel(read_noise=0.0, blur_px=0.6, uneven_light=0.3, chroma="444")
    empty = drawn((), sensor, floor=Floor())
    seen = drawn((robot(1, 0.7, 0.6, 0.4),), sensor, floor=Floor())
    pixel = CAMERA.pixel_pose(robot(1, 0.7, 0.6).state.pose)
    changed = np.argwhere((empty != seen).any(axis=2))
    assert np.abs(changed - (pixel.y, pixel.x)).max() < 0.0375 * 2**0.5 * SCALE + 4.0
    assert len(changed) > 80


@pytest.mark.parametrize("distortion", [(0.0,) * 5, (-0.12, 0.03, 0.001, -0.002, 0.0)])
def test_parts_of_robots_at_the_border(distortion: tuple[float, ...]) -> None:
    """A window of a larger picture is the smaller picture: cutting off changes nothing else."""
    small = overhead_camera((320, 240), 2.4, (0.5, 0.4), 2.5, SIDE, distortion)
    matrix = small.matrix.copy()
    matrix[:2, 2] += 40.0
    large = replace(small, size_px=(400, 320), matrix=matrix)
    rng = np.random.default_rng(3)
    states = scattered(rng, 7, (-0.75, -0.55), (1.75, 1.35))
    sensor = SensorModel(read_noise=0.0, blur_px=0.9, chroma="444")
    wide = drawn(states, sensor, large)[40:-40, 40:-40].astype(int)
    np.testing.assert_allclose(drawn(states, sensor, small).astype(int), wide, atol=1)


def test_distorted_lens_puts_tags_where_the_camera_says() -> None:
    camera = overhead_camera(
        (321, 201), 2.4, (0.2, -0.1), 2.0, SIDE, (-0.2, 0.05, 0.002, 0.001, 0.0)
    )
    for x, y in ((0.9, 0.3), (-0.6, -0.6), (0.2, -0.1)):
        state = robot(1, x, y, 0.6)
        seen = drawn((state,), camera=camera).astype(float).sum(axis=2)
        pixel = camera.pixel_pose(state.state.pose)
        assert np.hypot(*(centroid(seen) - (pixel.x, pixel.y))) < 1.0  # yellow outweighs red


def test_robots_far_outside_do_not_show() -> None:
    camera = overhead_camera((320, 240), 2.4, (0.0, 0.0), 2.0, SIDE, (-0.3, 0.0, 0.0, 0.0, 0.0))
    far = robot(1, 3.0, 0.0), robot(2, 0.0, 50.0)
    np.testing.assert_array_equal(drawn(far, camera=camera), drawn((), camera=camera))


def test_same_seed_and_moment_same_picture_whatever_was_drawn_before() -> None:
    states = scattered(np.random.default_rng(5), 3, (0.0, 0.0), (1.0, 0.8))
    first = Renderer(CAMERA, two_patch_tags(3), COLORS, SensorModel(), 7)
    second = Renderer(CAMERA, two_patch_tags(3), COLORS, SensorModel(), 7)
    expected = first.render(states, 1.0 / 3.0)
    second.render(states[:1], 0.1)
    np.testing.assert_array_equal(second.render(states, 1.0 / 3.0), expected)
    assert (first.render(states, 0.4) != expected).mean() > 0.5
    assert not expected.flags.writeable
    assert expected.flags.c_contiguous


def test_tags_must_fit_the_robots_and_the_colours() -> None:
    renderer = Renderer(CAMERA, two_patch_tags(1), COLORS, CLEAN)
    with pytest.raises(SimulationError, match="robot 9 wears no tag"):
        renderer.render((robot(9, 0.0, 0.0),), 0.0)
    with pytest.raises(SimulationError, match="robot 1 to be rendered"):
        renderer.render((robot(1, float("nan"), 0.0),), 0.0)
    with pytest.raises(SimulationError, match="yellow"):
        Renderer(CAMERA, two_patch_tags(1), COLORS[1:], CLEAN)
