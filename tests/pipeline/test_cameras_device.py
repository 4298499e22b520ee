"""Devices: what is missing or wrong is said in one line, and OpenCV says nothing beside it."""

import os
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from pipeline.cameras.device import (
    CaptureFormat,
    format_refused,
    fourcc,
    open_device,
    pixels_named,
    stamp_age,
)
from pipeline.cameras.options import DeviceOptions
from pipeline.clock import MonotonicClock
from pipeline.errors import CameraError, ConfigError
from pipeline.rigs import camera_request
from pipeline.scenario import load_scenario
from tests.pipeline.as_nobody import as_nobody

PAPER = Path(__file__).parents[2] / "datasets" / "scenarios" / "paper.toml"


@pytest.mark.parametrize(
    ("device", "words"),
    [
        (97, "camera /dev/video97: does not exist; there is "),
        ("/dev/video98", "camera /dev/video98: does not exist; there is "),
        ("/dev/null", "camera /dev/null: is no camera, or another program uses it"),
    ],
)
def test_no_camera_is_one_clear_line(
    device: int | str, words: str, capfd: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(CameraError) as caught:
        open_device(device, MonotonicClock())
    assert str(caught.value).startswith(words)
    assert "\n" not in str(caught.value)
    assert capfd.readouterr() == ("", "")


def test_a_forbidden_camera_names_the_group() -> None:
    with TemporaryDirectory() as folder:  # not pytest's own, which nobody else may enter
        os.chmod(folder, 0o755)
        path = os.path.join(folder, "video0")
        os.mknod(path, 0)
        with as_nobody(), pytest.raises(CameraError, match="permission denied"):
            open_device(path, MonotonicClock())


def test_a_drivers_stamp_counts_only_if_it_is_of_this_clock() -> None:
    assert stamp_age(99.96, 100.0) == pytest.approx(0.04)
    assert stamp_age(0.0, 100.0) is None  # no stamp
    assert stamp_age(1.7e9, 100.0) is None  # time of day
    assert stamp_age(100.1, 100.0) is None  # the future


def test_what_the_device_does_instead_is_said_with_numbers() -> None:
    wanted = CaptureFormat((320, 240), 30.0)
    assert format_refused(wanted, CaptureFormat((320, 240), 30.0)) is None
    assert format_refused(wanted, CaptureFormat((320, 240), 0.0)) is None  # it does not say
    assert format_refused(CaptureFormat(), CaptureFormat((640, 480), 15.0)) is None
    size = format_refused(wanted, CaptureFormat((640, 480), 30.0))
    assert size == "does not do 320x240 px, it offers 640x480 px"
    rate = format_refused(wanted, CaptureFormat((320, 240), 15.0))
    assert rate == "does not do 30 frames/s, it offers 15"


def test_what_a_scenario_asks_of_a_device(tmp_path: Path) -> None:
    asked = tmp_path / "asked.toml"
    asked.write_text(
        f'include = ["{PAPER}"]\n[camera]\nrepeats = "stamps"\n[camera.device]\n'
        'pixel_format = "MJPG"\n'
        'exposure_ms = 8\ngain = 40\nfocus = "auto"\nwhite_balance_k = 4500\npower_line_hz = 50\n'
    )
    camera = load_scenario(str(asked), ("camera.device.constant_rate=true",)).camera
    request = camera_request(camera)
    assert request.wanted == CaptureFormat((320, 240), 30.0, "MJPG")
    assert request.options == DeviceOptions(8.0, 40, "auto", 4500, 50, True)
    assert (request.habits.fps, request.habits.repeats) == (30.0, "stamps")
    assert isinstance(request.options.exposure_ms, float)  # warned of if longer than a frame


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("exposure_ms=0", "greater than 0"),
        ('exposure_ms="long"', "valid number"),
        ("power_line_hz=55", "50"),
        ("white_balance_k=10", "1000"),
        ("iris=3", "iris"),
    ],
)
def test_a_wrong_option_is_told_by_its_key(change: str, words: str) -> None:
    with pytest.raises(ConfigError, match=r"camera\.device") as caught:
        load_scenario("paper", (f"camera.device.{change}",))
    assert words in str(caught.value)


def test_pixel_formats_by_their_four_characters() -> None:
    assert fourcc("MJPG") == 0x47504A4D
    assert pixels_named(float(0x47504A4D)) == "MJPG"
    assert pixels_named(float(fourcc("Y8"))) == "Y8"
    assert pixels_named(-1.0) is None
    refused = format_refused(CaptureFormat(None, None, "MJPG"), CaptureFormat(None, 0.0, "YUYV"))
    assert refused == "does not send MJPG, it offers YUYV"
