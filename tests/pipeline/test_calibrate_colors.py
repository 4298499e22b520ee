"""`echelon calibrate colors`: sources, the fragment a scenario includes, and wrong fragments."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from datasets.recorded import VideoWriter, read_image
from pipeline.errors import CameraError, ConfigError
from pipeline.glimpses import glimpse
from pipeline.scenario import load_scenario, scenario_path
from pipeline.seeing import colored_eye
from pipeline.setup import make_setup
from tests.pipeline.commands import echelon
from vision.frame import as_frame
from vision.locate import locate

FRAGMENT = """\
[palette]
light = [0.45, 1.8]
[palette.prints]
{prints}
[palette.samples]
black = [[10, 10, 10]]
floor = [[40, 42, 44]]
{samples}
"""
BGR = {
    "yellow": (20, 210, 240),
    "red": (40, 40, 200),
    "green": (60, 140, 30),
    "blue": (200, 80, 40),
}


def fragment(**changes: object) -> str:
    """A palette file, with some colours changed or left out (None)."""
    colors = {name: value for name, value in {**BGR, **changes}.items() if value is not None}
    prints = "\n".join(f"{name} = {list(bgr)}" for name, bgr in colors.items())
    samples = "\n".join(f"{name} = [{list(bgr)}]" for name, bgr in colors.items())
    return FRAGMENT.format(prints=prints, samples=samples)


def including(folder: Path, text: str) -> str:
    """A scenario that includes a palette file."""
    (folder / "colors.toml").write_text(text)
    mine = folder / "mine.toml"
    mine.write_text(f'include = ["{scenario_path("paper").resolve()}", "colors.toml"]\n')
    return str(mine)


@pytest.fixture(scope="module")
def frames(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("frames")
    done = echelon("render", "paper", "--out", folder, "--duration", 0.2)
    assert done.returncode == 0, done.stderr
    return folder


def test_a_folder_becomes_a_fragment_that_a_scenario_includes(frames: Path, tmp_path: Path) -> None:
    out = tmp_path / "colors.toml"
    done = echelon("calibrate", "colors", frames, "paper", "--frames", 2, "--out", out, "--json")
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert (told["found_after"], told["missing"], told["unsure"]) == (3, [], 0)
    assert {rival["verdict"] for rival in told["rivals"]} == {"far apart"}
    assert len(told["taught"]) == 6
    for when in ("before", "after"):
        assert read_image(tmp_path / f"colors_{when}.png").shape == (960, 1280, 3)
    setup = make_setup(load_scenario(including(tmp_path, out.read_text())))
    eye = colored_eye(setup.seeing, (320, 240))
    assert eye.palette.names == ("yellow", "red", "green", "blue")
    image = read_image(sorted(frames.glob("*.png"))[-1])
    scene = locate(as_frame(image, 0.0, 0), eye)
    assert [d.robot_id for d in scene.detections] == [1, 2, 3]


def test_pictures_that_show_no_robot_are_one_clear_line(tmp_path: Path) -> None:
    noise = np.random.default_rng(0).integers(0, 60, (240, 320, 3), np.uint8)
    cv2.imwrite(str(tmp_path / "noise.png"), noise)
    done = echelon("calibrate", "colors", tmp_path / "noise.png", "--out", tmp_path / "c.toml")
    assert done.returncode == 2
    assert "noise.png: no tag found in 1 pictures" in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
    assert not (tmp_path / "c.toml").exists()


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (fragment(blue=None), "palette.samples lacks blue, which the tags need"),
        (
            fragment(pink=(1, 2, 3)),
            "scenario paper: palette.samples has pink, which is not among the scenario's colours",
        ),
        (fragment(red=(1, 2, 300)), "samples.red.0.2: input should be less than or equal to 255"),
        (fragment(red=(1, 2)), 'missing key "palette.samples.red.0.2"'),
        (fragment().replace("[palette.samples]", "[palette.samples]\nred2 = []"), "red2"),
        (fragment().replace("0.45, 1.8", "1.8, 0.45"), "light: 1.8 is above 0.45"),
        (fragment().replace("light =", "lights ="), 'unknown key "palette.lights"; did you mean'),
    ],
)
def test_a_wrong_fragment_is_named(tmp_path: Path, text: str, expected: str) -> None:
    with pytest.raises(ConfigError) as error:
        make_setup(load_scenario(including(tmp_path, text)))
    assert expected in str(error.value)
    assert "\n" not in str(error.value)


def test_glimpses_are_spread_over_what_there_is(frames: Path) -> None:
    files = sorted(frames.glob("*.png"))
    few = glimpse((str(frames),), 3)
    assert [f.camera_id for f in few] == [
        files[n].name for n in (0, round((len(files) - 1) / 2), -1)
    ]
    assert [f.camera_id for f in glimpse(tuple(map(str, files[:2])), 1)] == [
        file.name for file in files[:2]
    ]


def test_glimpses_of_a_video_reach_its_end(tmp_path: Path) -> None:
    path = tmp_path / "grey.mp4"
    writer = VideoWriter(path, 30.0)
    for level in range(40):
        writer.write(as_frame(np.full((64, 96, 3), 4 * level, np.uint8), level / 30, level))
    writer.close()
    numbers = [frame.sequence for frame in glimpse((str(path),), 4)]
    assert len(numbers) == 4
    assert numbers[0] == 0
    assert numbers[-1] >= 30


def test_wrong_sources_are_named(frames: Path, tmp_path: Path) -> None:
    image = str(sorted(frames.glob("*.png"))[0])
    with pytest.raises(ConfigError, match="give images, or one folder"):
        glimpse((image, str(frames)), 2)
    other = tmp_path / "other.png"
    cv2.imwrite(str(other), np.zeros((48, 64, 3), np.uint8))
    with pytest.raises(ConfigError, match=r"different sizes: .*64 x 48"):
        glimpse((image, str(other)), 2)
    with pytest.raises(CameraError, match="/dev/video97"):
        glimpse(("/dev/video97",), 2)
