"""Images that are none, or others than expected: one clear line, whatever the file is called."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from datasets.errors import RecordingError
from datasets.recorded import read_image
from pipeline.cli.locating import locate_images
from pipeline.cli.output import Output
from pipeline.errors import ConfigError
from pipeline.scenario import load_scenario
from pipeline.seeing import make_seeing
from tests.pipeline.commands import echelon_process
from vision.errors import VisionError
from vision.frame import as_frame


@pytest.fixture(scope="module")
def whole() -> np.ndarray:
    """Something to look at, 320 x 240."""
    y, x = np.mgrid[:240, :320]
    return np.stack((x % 256, y, (x + y) % 256), axis=-1).astype(np.uint8)


def encoded(image: np.ndarray, suffix: str) -> bytes:
    return cv2.imencode(suffix, image)[1].tobytes()


@pytest.mark.parametrize("suffix", [".png", ".jpg"])
@pytest.mark.parametrize("share", [0.0, 0.001, 0.3, 0.7, 0.99])
def test_a_file_that_is_cut_off_is_refused(
    tmp_path: Path, whole: np.ndarray, suffix: str, share: float
) -> None:
    data, path = encoded(whole, suffix), tmp_path / f"cut{suffix}"
    path.write_bytes(data[: int(share * len(data))])
    with pytest.raises(RecordingError, match=r"cut.*: (the file is empty|is cut off|is not an im)"):
        read_image(path)


def test_a_damaged_png_is_refused_and_the_chunk_named(tmp_path: Path, whole: np.ndarray) -> None:
    data, path = bytearray(encoded(whole, ".png")), tmp_path / "flipped.png"
    data[len(data) // 2] ^= 0x10
    path.write_bytes(data)
    with pytest.raises(RecordingError, match=r"wrong checksum in the PNG chunk at byte \d+"):
        read_image(path)


@pytest.mark.parametrize("name", ["right.png", "wrong.jpg", "none", "text.txt"])
def test_the_name_of_an_image_does_not_matter(tmp_path: Path, whole: np.ndarray, name: str) -> None:
    (tmp_path / name).write_bytes(encoded(whole, ".png"))
    assert (read_image(tmp_path / name) == whole).all()


def test_grey_deep_and_transparent_images_become_colours(tmp_path: Path, whole: np.ndarray) -> None:
    grey, path = cv2.cvtColor(whole, cv2.COLOR_BGR2GRAY), tmp_path / "image.png"
    three = cv2.cvtColor(grey, cv2.COLOR_GRAY2BGR)
    opaque = cv2.cvtColor(whole, cv2.COLOR_BGR2BGRA)
    cases = [(grey, three), (grey.astype(np.uint16) * 257, three),
             (whole.astype(np.uint16) * 257, whole), (opaque, whole)]  # fmt: skip
    for image, expected in cases:
        cv2.imwrite(str(path), image)
        assert (read_image(path) == expected).all()


def test_numbers_with_a_point_are_refused(tmp_path: Path, whole: np.ndarray) -> None:
    path, image = tmp_path / "image.tiff", whole.astype(np.float32)
    image[0] = np.nan
    cv2.imwrite(str(path), image)
    with pytest.raises(RecordingError, match="float32 pixels; need 8 or 16 bit"):
        read_image(path)


@pytest.mark.parametrize("shape", [(1, 1), (1, 20000), (20000, 1)])
def test_images_of_no_size_to_speak_of_show_nobody(shape: tuple[int, int]) -> None:
    frame = as_frame(np.full((*shape, 3), 128, np.uint8), 0.0, 0)
    seeing = make_seeing(load_scenario("paper"))
    assert seeing.detector_for(frame.size_px).camera.size_px == (shape[1], shape[0])
    with pytest.raises(ConfigError, match=r'camera.other_sizes = "scale"'):
        make_seeing(load_scenario("paper", ('camera.other_sizes="refuse"',))).detector_for(
            frame.size_px
        )


@pytest.mark.parametrize(
    ("field", "said"),
    [
        ("[[0, 0], [9, 0]]", "field_px"),
        ("[[0, 0], [9, 0], [1, nan]]", "camera.field_px.2.1"),
        ("[[900, 900], [990, 900], [990, 990]]", "field_px has no pixel of the 320 x 240 px image"),
    ],
)
def test_a_wrong_field_is_named(field: str, said: str) -> None:
    with pytest.raises((ConfigError, VisionError), match=said):
        make_seeing(load_scenario("paper", (f"camera.field_px={field}",)))


def test_overlays_never_lie_over_images_or_each_other(tmp_path: Path, whole: np.ndarray) -> None:
    one, other, file = tmp_path / "a" / "x.png", tmp_path / "b" / "x.png", tmp_path / "file"
    file.write_text("")
    for path in (one, other):
        path.parent.mkdir()
        cv2.imwrite(str(path), whole)
    cases = [
        ([one], one.parent, "would overwrite"), ([one, other], tmp_path / "c", "several images"),
        ([one], file, "not a folder"),
    ]  # fmt: skip
    for images, folder, said in cases:
        with pytest.raises(ConfigError, match=said):
            locate_images(images, "paper", (), folder, Output(True))
    assert (read_image(one) == whole).all()


def test_commands_answer_bad_images_with_one_line(tmp_path: Path, whole: np.ndarray) -> None:
    cut, folder = tmp_path / "cut.png", tmp_path / "folder.png"
    cut.write_bytes(encoded(whole, ".png")[:5000])
    folder.mkdir()
    cases = [
        (("locate", cut, "--json"), "is cut off"),
        (("locate", folder), "a folder without images"),
        (("calibrate", "colors", cut, "--out", tmp_path / "c.toml"), "is cut off"),
        (("calibrate", "camera", cut, "--out", tmp_path / "c.toml"), "0 views show the board"),
    ]
    for arguments, said in cases:
        done = echelon_process(*arguments)
        assert done.returncode == 2
        assert said in done.stderr
        assert len(done.stderr.strip().splitlines()) == 1
        assert "Traceback" not in done.stderr
    assert not (tmp_path / "c.toml").exists()
