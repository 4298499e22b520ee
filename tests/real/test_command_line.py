"""Real frames as a stranger would look at them: a scenario, one frame to teach, the command."""

import json
from pathlib import Path
from typing import Any

import cv2
import pytest

from datasets.recorded import read_image
from pipeline.cli.calibrating_colors import calibrate_colors
from pipeline.cli.locating import locate_images
from pipeline.cli.output import Output
from pipeline.errors import ConfigError
from tests.pipeline.commands import echelon
from tests.real.frames import HERE, REAL, Tally, labels, names, needs_frames

pytestmark = needs_frames
TEACHERS = ("b_all2", "b_r0", "b_white2", "b_yellow1")  # one frame of each light


def taught(teacher: Path, scenario: str, folder: Path) -> Path:
    """A scenario whose palette one frame has taught."""
    calibrate_colors([str(teacher), str(HERE / scenario)], folder / "colors.toml", 1, (), SILENT)
    path = folder / "taught.toml"
    base = json.dumps(str((HERE / scenario).resolve()))
    path.write_text(f'name = "taught"\ninclude = [{base}, "colors.toml"]\n')
    return path


class Silent(Output):
    """Keeps what would be printed."""

    def __init__(self) -> None:
        super().__init__(True)
        self.said: dict[str, Any] = {}

    def say(self, text: str) -> None:
        del text

    def object(self, value: dict[str, Any]) -> None:
        self.said = json.loads(json.dumps(value, allow_nan=False))


SILENT = Silent()


def located(images: list[Path], scenario: Path, *overrides: str) -> list[dict[str, Any]]:
    """What `echelon locate --json` says of images."""
    output = Silent()
    locate_images(images, str(scenario), overrides, None, output)
    return list(output.said["images"])


@pytest.mark.parametrize("teacher", TEACHERS)
def test_one_frame_teaches_its_light_and_empty_fields_stay_empty(
    teacher: str, tmp_path: Path
) -> None:
    light = labels("agh_b", teacher)["light_group"]
    same = [n for n in names("agh_b") if labels("agh_b", n)["light_group"] == light]
    scenario = taught(REAL / "agh_b" / f"{teacher}.png", "agh_b.toml", tmp_path)
    tally = Tally()
    images = [REAL / "agh_b" / f"{name}.png" for name in same]
    for name, image in zip(same, located(images, scenario), strict=True):
        tally.add(labels("agh_b", name), image["detections"])
        assert all(d["x_m"] is None for d in image["detections"])
    assert (tally.false, tally.wrong_ids, tally.flips) == (0, 0, 0)
    assert tally.robots - tally.right <= (1 if teacher == "b_white2" else 0)  # 129 of 130 in all
    for empty in located(sorted((REAL / "empty").glob("*.png")), scenario):
        assert empty["detections"] == []


@pytest.mark.parametrize("teacher", ["scene_a_640", "scene_b_640"])
def test_tops_without_a_rim_and_a_stretched_picture(teacher: str, tmp_path: Path) -> None:
    scenario = taught(REAL / "rodetas" / f"{teacher}.png", "rodetas.toml", tmp_path)
    wide = tmp_path / "wide.toml"
    base = json.dumps(str((HERE / "rodetas_wide.toml").resolve()))
    wide.write_text(f'name = "wide"\ninclude = [{base}, "colors.toml"]\n')
    tally = Tally()
    for name in names("rodetas"):
        path = REAL / "rodetas" / f"{name}.png"
        (image,) = located([path], wide if "1080" in name else scenario)
        tally.add(labels("rodetas", name), image["detections"])
    assert (tally.right, tally.robots) == (18, 18)
    assert (tally.false, tally.wrong_ids, tally.flips) == (0, 0, 0)


def test_the_whole_way_through_the_command(tmp_path: Path) -> None:
    teacher, scenario = REAL / "agh_b" / "b_yellow1.png", HERE / "agh_b.toml"
    colors, setup = tmp_path / "colors.toml", tmp_path / "mine.toml"
    done = echelon("calibrate", "colors", teacher.resolve(), scenario.resolve(), "--out", colors)
    assert done.returncode == 0, done.stderr
    assert "10 tags taught" in done.stdout
    base = json.dumps(str(scenario.resolve()))
    setup.write_text(f'name = "mine"\ninclude = [{base}, "colors.toml"]\n')
    seen = tmp_path / "seen"
    done = echelon("locate", teacher.resolve(), "--setup", setup, "--overlay", seen, "--json")
    assert done.returncode == 0, done.stderr
    (image,) = json.loads(done.stdout)["images"]
    assert len(image["detections"]) == 10
    picture = read_image(seen / "b_yellow1.png")
    assert picture.shape[0] > 960
    assert picture.shape[1] == 1280


def test_a_darker_or_brighter_picture_is_tried_in_other_brightnesses(tmp_path: Path) -> None:
    scenario = taught(REAL / "agh_b" / "b_all2.png", "agh_b.toml", tmp_path)
    image = read_image(REAL / "agh_b" / "b_all2.png")
    for factor, least in ((0.4, 8), (0.3, 7)):
        dark = tmp_path / "dark.png"
        cv2.imwrite(str(dark), cv2.convertScaleAbs(image, alpha=factor))
        tally = Tally()
        tally.add(labels("agh_b", "b_all2"), located([dark], scenario)[0]["detections"])
        assert tally.right >= least
        assert (tally.false, tally.wrong_ids, tally.flips) == (0, 0, 0)


def test_a_palette_of_other_tags_is_refused(tmp_path: Path) -> None:
    taught(REAL / "agh_b" / "b_all2.png", "agh_b.toml", tmp_path)
    for scenario in ("rodetas.toml", "agh_b.toml"):
        path = tmp_path / "other.toml"
        base = json.dumps(str((HERE / scenario).resolve()))
        path.write_text(f'name = "other"\ninclude = [{base}, "colors.toml"]\n')
        frame = REAL / "agh_b" / "b_all2.png"
        if scenario == "agh_b.toml":
            assert len(located([frame], path)[0]["detections"]) == 10
        else:
            with pytest.raises(ConfigError, match="red, violet, which are not among"):
                located([frame], path)


@pytest.mark.parametrize("name", ["still_plates.mpg", "exposure_settling.mpg"])
def test_videos_play_through(name: str) -> None:
    done = echelon("replay", (REAL / "video" / name).resolve(), "paper", "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["frames"] > 10
