"""Real frames, spoiled: nothing falls, numbers are finite, no id twice, none on empty fields."""

from collections.abc import Callable
from functools import cache

import cv2
import numpy as np
import pytest

from datasets.recorded import read_image
from pipeline.looking import look
from pipeline.scenario import load_scenario
from pipeline.seeing import Seeing, make_seeing, named_colors
from tests.real.frames import HERE, REAL, labels, names, needs_frames
from tests.vision.hostile import check_scene, random_light
from vision.calibration.colors import learn_colors
from vision.calibration.learned import palette_from_samples
from vision.detector import ColorDetector
from vision.eye import make_eye
from vision.frame import as_frame
from vision.locate import locate

pytestmark = needs_frames
Image = np.ndarray
Rng = np.random.Generator


@cache
def seeing() -> Seeing:
    """The ten robots' camera."""
    return make_seeing(load_scenario(str(HERE / "agh_b.toml")))


@cache
def detector() -> ColorDetector:
    """With the palette that one frame teaches."""
    before = seeing().detector
    assert isinstance(before, ColorDetector)
    eye = before.eye
    colors = named_colors(load_scenario(str(HERE / "agh_b.toml")))
    found = learn_colors((frame("b_all2"),), eye, colors)
    palette = palette_from_samples(tuple(c.samples for c in found.colors), found.prints)
    return ColorDetector(make_eye(eye.camera, eye.tags, palette, eye.optics, None, eye.field_px))


@cache
def frame(name: str) -> Image:
    """A frame's picture."""
    return read_image(REAL / "agh_b" / f"{name}.png")


def pasted(image: Image, rng: Rng) -> Image:
    """A crop of another frame, put elsewhere."""
    other, out = frame(str(rng.choice(names("agh_b")))), image.copy()
    h, w = rng.integers(20, 200, 2)
    (y, x), (v, u) = ((rng.integers(0, 480 - h), rng.integers(0, 640 - w)) for _ in range(2))
    out[y : y + h, x : x + w] = other[v : v + h, u : u + w]
    return out


def robots_pasted(image: Image, rng: Rng) -> Image:
    """Tiles with robots, turned, cut and put all over the field."""
    out = image.copy()
    for robot in labels("agh_b", "b_all2")["robots"]:
        x, y = int(robot["x"]), int(robot["y"])
        tile = frame("b_all2")[max(y - 12, 0) : y + 13, x - 12 : x + 13]
        tile = np.rot90(tile, rng.integers(4))[: rng.integers(12, 26)]
        v, u = rng.integers(0, 480 - 26), rng.integers(0, 640 - 26)
        out[v : v + tile.shape[0], u : u + tile.shape[1]] = tile
    return out


def shuffled(image: Image, rng: Rng) -> Image:
    """Blocks in another order."""
    size = int(rng.choice([8, 16, 32, 80]))
    rows, columns = 480 // size, 640 // size
    blocks = image.reshape(rows, size, columns, size, 3).swapaxes(1, 2).reshape(-1, size, size, 3)
    mixed = blocks[rng.permutation(len(blocks))].reshape(rows, columns, size, size, 3)
    return np.ascontiguousarray(mixed.swapaxes(1, 2).reshape(480, 640, 3))


def swapped(image: Image, rng: Rng) -> Image:
    """Channels exchanged."""
    return np.ascontiguousarray(image[..., rng.permutation(3)])


def gamma(image: Image, rng: Rng) -> Image:
    """Another tone curve."""
    return np.rint(255.0 * (image / 255.0) ** rng.uniform(0.3, 3.0)).astype(np.uint8)


def hue(image: Image, rng: Rng) -> Image:
    """All hues turned."""
    hsv = cv2.cvtColor(image, cv2.COLOR_BGR2HSV)
    hsv[..., 0] = (hsv[..., 0].astype(int) + rng.integers(10, 170)) % 180
    return cv2.cvtColor(hsv, cv2.COLOR_HSV2BGR)


def jpeg(image: Image, _: Rng) -> Image:
    """Packed as small as can be."""
    return cv2.imdecode(cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, 5])[1], 1)


def noisy(image: Image, rng: Rng) -> Image:
    """With the noise of a dark room."""
    return np.clip(image + rng.normal(0.0, 40.0, image.shape), 0, 255).astype(np.uint8)


def mirrored(image: Image, rng: Rng) -> Image:
    """Turned over, once or twice."""
    return np.ascontiguousarray(cv2.flip(image, int(rng.integers(-1, 2))))


MUTATIONS = (pasted, robots_pasted, shuffled, swapped, gamma, hue, jpeg, noisy, mirrored)


@pytest.mark.parametrize("mutate", MUTATIONS)
def test_spoiled_frames_do_no_harm(mutate: Callable[[Image, Rng], Image]) -> None:
    rng = np.random.default_rng(7)
    for number, name in enumerate(names("agh_b")):
        image = mutate(frame(name), rng)
        if number % 3 == 2:
            image = MUTATIONS[rng.integers(len(MUTATIONS))](image, rng)
        check_scene(look(detector(), as_frame(image, 0.0, number)))
        check_scene(locate(as_frame(image, 0.0, number), detector().eye, (), random_light(rng)))


@pytest.mark.parametrize("mutate", [gamma, jpeg, noisy, mirrored])
def test_empty_fields_stay_empty_however_spoiled(mutate: Callable[[Image, Rng], Image]) -> None:
    rng = np.random.default_rng(3)
    for path in sorted((REAL / "empty").glob("*.png")):
        image = read_image(path)
        for number in range(4):
            spoiled = as_frame(mutate(image, rng), 0.0, number)
            assert look(detector(), spoiled).detections == ()
