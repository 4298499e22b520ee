"""Colours learned from rendered pictures in every light, against truth; refusals with reasons."""

import colorsys

import numpy as np
import pytest
from numpy.typing import NDArray

from datasets.sensor import SensorModel
from tests.vision.worlds import BLACK, REARS, YELLOW, World, make_world, two_patch_tags
from vision.calibration.colors import LearnedColors, learn_colors
from vision.calibration.learned import Print, palette_from_samples
from vision.errors import VisionError
from vision.eye import make_eye
from vision.locate import locate
from vision.palette import ColorSamples, NamedColor

NOMINAL = (YELLOW, *REARS)
PAPER = {"read_noise": 3.0, "blur_px": 0.6, "uneven_light": 0.3, "chroma": "420"}
LIGHTS = {
    "dim": ((0.35, 0.35, 0.35), {}),
    "warm": ((0.6, 0.9, 1.1), {}),
    "uneven": ((1.0, 1.0, 1.0), {"uneven_light": 0.7}),
    "jpeg": ((0.8, 0.8, 0.8), {"jpeg_quality": 70}),
}


def lit(color: NamedColor, gains: tuple[float, float, float]) -> NamedColor:
    """A colour under a lamp of another colour."""
    b, g, r = (min(255, round(v * k)) for v, k in zip(color.bgr, gains, strict=True))
    return NamedColor(color.name, (b, g, r))


def turned(color: NamedColor, degrees: float) -> NamedColor:
    """A colour with another hue."""
    b, g, r = (v / 255 for v in color.bgr)
    h, s, v = colorsys.rgb_to_hsv(r, g, b)
    r, g, b = (round(255 * x) for x in colorsys.hsv_to_rgb((h + degrees / 360) % 1.0, s, v))
    return NamedColor(color.name, (b, g, r))


def scene(light: str = "jpeg", count: int = 3) -> World:
    """Robots under a light."""
    gains, changes = LIGHTS[light]
    colors = tuple(lit(color, gains) for color in NOMINAL)
    return make_world(None, two_patch_tags(count), SensorModel(**{**PAPER, **changes}), colors)


def learned(
    world: World, poses: NDArray[np.float64], nominal: tuple[NamedColor, ...] = NOMINAL
) -> LearnedColors:
    """What one picture teaches, asked for by nominal colours."""
    eye = make_world(None, world.eye.tags, SensorModel(), nominal).eye
    return learn_colors((world.frame(poses).image,), eye, (*nominal, BLACK))


def all_right(found: LearnedColors, poses: NDArray[np.float64]) -> bool:
    """Whether every lesson was about the robot that stood there."""
    true = poses[[lesson.tag for lesson in found.lessons]]
    poses = np.array([lesson.pose for lesson in found.lessons])
    away = np.hypot(*(poses - true)[:, :2].T)
    return bool((away < 2e-3).all() and (np.cos((poses - true)[:, 2]) > 0.99).all())


@pytest.mark.parametrize("light", LIGHTS)
def test_every_light_teaches_a_palette_that_finds_the_robots(light: str) -> None:
    world, rng = scene(light), np.random.default_rng(3)
    poses = world.scattered(rng)
    found = learned(world, poses)
    assert len(found.lessons) == 3
    assert (found.missing, found.unsure) == ((), 0)
    assert all_right(found, poses)
    samples = tuple(collected.samples for collected in found.colors)
    assert {s.name for s in samples} == {"black", "yellow", "red", "green", "blue", "floor"}
    assert all(len(s.pixels) <= 200 for s in samples)
    palette = palette_from_samples(samples, found.prints)
    eye = make_eye(world.eye.camera, world.eye.tags, palette, world.eye.optics)
    for number in range(1, 9):
        poses = world.scattered(rng)
        detections = locate(world.frame(poses, number), eye).detections
        assert [d.robot_id for d in detections] == [1, 2, 3]
        for d, pose in zip(detections, poses, strict=True):
            assert np.hypot(d.pose.x - pose[0], d.pose.y - pose[1]) < 2e-3


def test_hues_that_are_15_degrees_off_are_still_named_right() -> None:
    for count in (3, 7):
        world = scene("dim", count)
        poses = world.scattered(np.random.default_rng(count))
        signs = (1, -1) * 4
        nominal = tuple(turned(c, 15.0 * s) for c, s in zip(NOMINAL, signs, strict=True))
        found = learned(world, poses, nominal)
        assert len(found.lessons) == count
        assert all_right(found, poses)


def with_blue(bgr: tuple[int, int, int]) -> LearnedColors:
    """What robots 1 (red), 2 (green) and 3 teach, the last in a colour that is only called blue."""
    colors = (YELLOW, *REARS[:2], NamedColor("blue", bgr))
    world = make_world(None, two_patch_tags(3), SensorModel(**PAPER), colors)
    return learned(world, world.scattered(np.random.default_rng(5)), colors)


def test_two_colours_that_are_close_are_said_with_numbers_and_the_robots_they_confuse() -> None:
    closest = with_blue((80, 60, 190)).rivals[0]
    assert (closest.one, closest.other, closest.verdict) == ("red", "blue", "close")
    assert 0.01 < closest.error < 0.05
    assert closest.confused == ((1, 3),)
    far = with_blue((210, 70, 30)).rivals[0]
    assert far.verdict == "far apart"
    with pytest.raises(
        VisionError, match=r"red and blue are too close .* 1 may be 3 \(margin [01]"
    ):
        with_blue((46, 52, 196))


def test_colours_that_might_be_exchanged_are_refused() -> None:
    same = (YELLOW, NamedColor("red", (60, 60, 200)), REARS[1], NamedColor("blue", (64, 60, 196)))
    world = scene("jpeg")
    with pytest.raises(VisionError, match=r"red may be blue.*margin [\d.]+, needed"):
        learned(world, world.scattered(np.random.default_rng(2)), same)


def test_a_floor_without_robots_is_refused_with_what_was_seen() -> None:
    world = scene()
    away = np.array([[50.0, 50.0, 0.0]] * 3)
    with pytest.raises(VisionError, match="no tag found in 1 pictures: "):
        learned(world, away)


def test_a_colour_nobody_shows_is_named_with_who_should_show_it() -> None:
    world = scene()
    poses = world.scattered(np.random.default_rng(1))
    poses[2, :2] = 50.0
    with pytest.raises(VisionError, match=r"no tag shows blue beyond doubt .* robots 3 "):
        learned(world, poses)


def test_what_has_the_geometry_but_not_the_colours_teaches_nothing() -> None:
    strange = NamedColor("blue", (170, 170, 170))
    colors = (YELLOW, *REARS[:2], strange)
    world = make_world(None, two_patch_tags(3), SensorModel(**PAPER), colors)
    seeker = make_world(None, two_patch_tags(2), SensorModel(), NOMINAL)
    poses = world.scattered(np.random.default_rng(4))
    found = learn_colors((world.frame(poses).image,), seeker.eye, (*NOMINAL, BLACK))
    assert len(found.lessons) == 2
    assert all_right(found, poses)


def test_the_same_pictures_teach_the_same_bits() -> None:
    world = scene()
    poses = world.scattered(np.random.default_rng(8))
    one, two = learned(world, poses), learned(world, poses)
    assert (one.prints, one.rivals) == (two.prints, two.rivals)
    for a, b in zip(one.colors, two.colors, strict=True):
        np.testing.assert_array_equal(a.samples.pixels, b.samples.pixels)


def test_pictures_of_another_size_are_refused() -> None:
    eye = scene().eye
    for images in ((), (np.zeros((48, 64, 3), np.uint8),)):
        with pytest.raises(VisionError, match="picture"):
            learn_colors(images, eye, (*NOMINAL, BLACK))


def test_noise_and_flat_pictures_teach_nothing() -> None:
    eye, rng = scene().eye, np.random.default_rng(0)
    for image in (np.zeros((240, 320, 3)), rng.integers(0, 256, (240, 320, 3))):
        with pytest.raises(VisionError, match="no tag"):
            learn_colors((np.asarray(image, np.uint8),), eye, (*NOMINAL, BLACK))


def test_wrong_samples_are_refused() -> None:
    red = ColorSamples("red", np.full((3, 3), 40, np.uint8))
    prints = (Print("red", (40.0, 40.0, 40.0)),)
    with pytest.raises(VisionError, match=r"light range 2\.0 to 1\.0"):
        palette_from_samples((red,), prints, (2.0, 1.0))
    with pytest.raises(VisionError, match="prints of"):
        palette_from_samples((red,), ())
