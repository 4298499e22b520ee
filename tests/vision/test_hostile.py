"""Whatever stands before the camera, and whatever is expected there: finite numbers or an error."""

import os
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.nothing import LAYOUTS, SIDES_PX, nobodys_eye, nothings
from tests.pipeline.commands import ROOT
from tests.vision.hostile import fuzz
from tests.vision.worlds import World, make_world, paper_camera, two_patch_tags
from vision.errors import VisionError
from vision.eye import Thresholds, make_eye
from vision.frame import as_frame
from vision.locate import locate


@pytest.fixture(scope="module")
def paper() -> World:
    return make_world()


@pytest.mark.parametrize(
    ("image", "said"),
    [
        (np.zeros((240, 320), np.uint8), r"uint8 \(240, 320\)"),
        (np.zeros((240, 320, 1), np.uint8), r"uint8 \(240, 320, 1\)"),
        (np.zeros((240, 320, 4), np.uint8), r"uint8 \(240, 320, 4\)"),
        (np.zeros((240, 320, 3), np.uint16), "uint16"),
        (np.zeros((240, 320, 3), np.float32), "float32"),
        (np.full((240, 320, 3), np.nan), "float64"),
        (np.zeros((0, 320, 3), np.uint8), r"\(0, 320, 3\)"),
        (np.zeros((240, 0, 3), np.uint8), r"\(240, 0, 3\)"),
        (np.zeros((2, 240, 320, 3), np.uint8), r"\(2, 240, 320, 3\)"),
        (np.zeros((240, 320, 3), bool), "bool"),
    ],
)
def test_what_is_no_image_is_refused(image: np.ndarray, said: str) -> None:
    with pytest.raises(VisionError, match=said):
        as_frame(image, 0.0, 0)


def test_views_with_strides_are_seen_like_copies(paper: World) -> None:
    image = paper.frame(paper.scattered(np.random.default_rng(2))).image
    wide = np.zeros((480, 640, 3), np.uint8)
    wide[::2, ::2] = image
    mirrored = np.ascontiguousarray(image[::-1, ::-1])[::-1, ::-1]
    for view in (wide[::2, ::2], mirrored, np.asfortranarray(image)):
        assert not view.flags.c_contiguous
        scene = locate(as_frame(view, 0.0, 0), paper.eye)
        assert repr(scene) == repr(locate(as_frame(image, 0.0, 0), paper.eye))


def test_noise_is_nobody(paper: World) -> None:
    rng = np.random.default_rng(5)
    for number in range(300):  # a run of 7 500 showed nobody either
        spread = (6.0, 20.0, 60.0)[number % 3]
        noise = rng.normal(rng.uniform(0, 255, 3), spread, (240, 320, 3))
        if number % 2:
            noise = rng.integers(0, 256, (240, 320, 3))
        image = np.clip(noise, 0, 255).astype(np.uint8)
        assert locate(as_frame(image, 0.0, number), paper.eye).detections == ()


@pytest.mark.parametrize("layout", LAYOUTS)
def test_clouds_of_colour_are_nobody(layout: str) -> None:
    for side_px in SIDES_PX:  # 9 600 looks of `benchmarks.nothing 800` showed one robot
        eye = nobodys_eye(layout, side_px)
        for nothing in nothings(90):
            assert locate(nothing.frame, eye).detections == (), nothing.kind


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=8)
def test_no_room_makes_it_fall(seed: int) -> None:
    fuzz(seed, 160, 3)


def test_indices_stay_within_arrays() -> None:
    """Interpreted, compiled functions check their indices; see `tests.vision.hostile` for more."""
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1", "PYTHONWARNINGS": "ignore"}
    done = subprocess.run(
        [sys.executable, "-m", "tests.vision.hostile", "4x"],
        cwd=ROOT, env=environment, capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "4 rooms" in done.stdout


def test_outside_the_field_nobody_is_looked_for() -> None:
    world = make_world(camera=paper_camera((320, 240)), tags=two_patch_tags(2))
    truth = np.array([[0.1, 0.4, 0.3], [1.2, 0.4, 2.0]])
    frame, eye = world.frame(truth), world.eye
    middle = 0.5 * (eye.camera.tag_pixels(truth).sum(axis=0))[0]
    left = np.array([[-5.0, -5.0], [middle, -5.0], [middle, 300.0], [-5.0, 300.0]])
    for corners, expected in ((None, [1, 2]), (left, [1]), (left + np.array([middle, 0.0]), [2])):
        half = make_eye(eye.camera, eye.tags, eye.palette, eye.optics, field_px=corners)
        scene = locate(frame, half)
        assert [d.robot_id for d in scene.detections] == expected
    with pytest.raises(VisionError, match="no pixel"):
        make_eye(eye.camera, eye.tags, eye.palette, field_px=left - 1000.0)


def test_the_misfit_a_tag_may_have_grows_with_its_size() -> None:
    limits = Thresholds()
    for width, expected in ((320, limits.residual_px), (1920, 0.02 * 1920 * 0.075 / 2.4)):
        camera = paper_camera((width, width * 3 // 4))
        eye = make_world(camera=camera, tags=two_patch_tags(2)).eye
        assert eye.most_residual_px == pytest.approx(expected, rel=0.05)
