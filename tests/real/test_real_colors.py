"""Real overhead frames: one frame of a light teaches a palette that finds the robots there."""

import json
import os
from functools import cache
from math import cos, hypot, radians
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from datasets.recorded import read_image
from vision.calibration.colors import LearnedColors, learn_colors
from vision.calibration.learned import palette_from_samples
from vision.camera import overhead_camera
from vision.errors import VisionError
from vision.eye import ChromaModel, Eye, Optics, make_eye
from vision.frame import as_frame
from vision.locate import locate
from vision.palette import NamedColor, palette_from_colors
from vision.scene import Detection
from vision.tags import Layout, Part, TagSet, polygon_array

REAL = Path(os.environ.get("ECHELON_REAL_FRAMES", "../shared/real"))
pytestmark = pytest.mark.skipif(
    not (REAL / "truth" / "agh_b").is_dir(),
    reason=f"{REAL}: no real frames there (ECHELON_REAL_FRAMES names their folder)",
)
SIDE = 0.075  # of a plate [m]
PX_PER_M = 219.0
NOMINAL = (
    NamedColor("black", (12, 12, 12)),
    NamedColor("yellow", (30, 220, 255)),
    NamedColor("blue", (210, 90, 40)),
    NamedColor("red", (45, 40, 210)),
    NamedColor("green", (60, 150, 30)),
    NamedColor("violet", (176, 72, 122)),
)
TEACHERS = ("b_all2", "b_r0", "b_white2", "b_yellow1")  # one frame of each light


VSSS = (
    *NOMINAL[:3],
    NamedColor("green", (60, 150, 30)),
    NamedColor("cyan", (220, 200, 40)),
    NamedColor("pink", (200, 120, 240)),
)  # of the two-colour tops of another team


def truth(folder: str, name: str) -> dict[str, Any]:
    """The labels of a frame."""
    found: dict[str, Any] = json.loads((REAL / "truth" / folder / f"{name}.json").read_text())
    return found


@cache
def nominal_eye(
    layout: str = "agh_b",
    px_per_m: float = PX_PER_M,
    nominal: tuple[NamedColor, ...] = NOMINAL,
) -> Eye:
    """The camera, the tags and nominal colours."""
    robots = json.loads((REAL / "layouts.json").read_text())[layout]["robots"]
    tags = []
    for robot_id, robot in robots.items():
        parts = (
            Part(f"part{n}", polygon_array(SIDE * np.array(p["pts"])), p["color"])
            for n, p in enumerate(robot["polygons"])
        )
        tags.append(Layout(layout, tuple(parts)).worn_by(robot_id, ()))
    camera = overhead_camera((640, 480), 640 / px_per_m, (0.0, 0.0), 3.0, 0.0)
    optics = Optics(0.6, 3.0, ChromaModel("444"))
    tag_set = TagSet(tuple(tags), mirror_twins=True)
    return make_eye(camera, tag_set, palette_from_colors(nominal), optics)


@cache
def learned(name: str) -> LearnedColors:
    """What one frame teaches."""
    return learn_colors((read_image(REAL / "agh_b" / f"{name}.png"),), nominal_eye(), NOMINAL)


@cache
def taught_eye(name: str) -> Eye:
    """The eye with the palette that one frame teaches."""
    eye, found = nominal_eye(), learned(name)
    samples = tuple(collected.samples for collected in found.colors)
    palette = palette_from_samples(samples, found.prints)
    return make_eye(eye.camera, eye.tags, palette, eye.optics, eye.thresholds)


def detections(eye: Eye, folder: str, name: str) -> tuple[Detection, ...]:
    """The robots of a frame."""
    image = read_image(REAL / folder / f"{name}.png")
    return locate(as_frame(image, 0.0, 0, name), eye).detections


@pytest.mark.parametrize("name", sorted(p.stem for p in (REAL / "agh_b").glob("*.png")))
def test_the_tags_of_every_frame_are_found_and_named_without_a_palette(name: str) -> None:
    eye, found = nominal_eye(), learned(name)
    robots = {robot["id"]: robot for robot in truth("agh_b", name)["robots"]}
    assert len(found.lessons) == len(robots) == 10
    assert found.missing == ()
    for lesson in found.lessons:
        robot = robots[eye.tags.ids[lesson.tag]]
        x, y = lesson.pose[:2] * PX_PER_M
        assert hypot(x + 319.5 - robot["x"], 239.5 - y - robot["y"]) < 1.5
        assert cos(lesson.pose[2] - radians(robot["heading_deg"])) > cos(radians(6.0))


@pytest.mark.parametrize("name", ["scene_a_640", "scene_b_640"])
def test_tops_without_a_plate_are_found_and_named_too(name: str) -> None:
    eye = nominal_eye("rodetas", 24.24 / SIDE, VSSS)
    found = learn_colors((read_image(REAL / "rodetas" / f"{name}.png"),), eye, VSSS)
    robots = {robot["id"]: robot for robot in truth("rodetas", name)["robots"]}
    assert len(found.lessons) == len(robots) == 6
    for lesson in found.lessons:
        robot = robots[eye.tags.ids[lesson.tag]]
        x, y = lesson.pose[:2] * 24.24 / SIDE
        assert hypot(x + 319.5 - robot["x"], 239.5 - y - robot["y"]) < 1.5
        assert cos(lesson.pose[2] - radians(robot["heading_deg"])) > cos(radians(6.0))


def test_one_frame_of_each_light_teaches_a_palette_for_all_frames_of_that_light() -> None:
    wanted = found = 0
    for teacher in TEACHERS:
        light = truth("agh_b", teacher)["light_group"]
        for path in sorted((REAL / "truth" / "agh_b").glob("*.json")):
            labels = truth("agh_b", path.stem)
            if labels["light_group"] != light:
                continue
            robots = {robot["id"]: robot for robot in labels["robots"]}
            wanted += len(robots)
            for seen in detections(taught_eye(teacher), "agh_b", path.stem):
                robot = robots[seen.robot_id]  # no wrong id, no false robot, no turned heading
                assert hypot(seen.pixel.x - robot["x"], seen.pixel.y - robot["y"]) < 2.0
                assert cos(seen.pixel.heading - radians(robot["heading_deg"])) > 0.9
                found += 1
    assert wanted == 130
    assert found >= 0.99 * wanted


def test_frames_without_robots_teach_nothing_and_show_nobody() -> None:
    names = sorted(path.stem for path in (REAL / "empty").glob("*.png"))
    assert names
    for name in names:
        image = read_image(REAL / "empty" / f"{name}.png")
        with pytest.raises(VisionError, match=r"no tag (found|shows)"):
            learn_colors((image,), nominal_eye(), NOMINAL)
        for teacher in TEACHERS:
            assert detections(taught_eye(teacher), "empty", name) == ()
