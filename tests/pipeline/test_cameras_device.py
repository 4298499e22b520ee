"""Devices: what is missing or wrong is said in one line, and OpenCV says nothing beside it."""

import os
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np
import pytest

from pipeline.cameras.capture_format import CaptureFormat, format_refused, fourcc, pixels_named
from pipeline.cameras.device import DeviceReader, open_device, stamp_age
from pipeline.cameras.options import DeviceOptions
from pipeline.clock import MonotonicClock
from pipeline.errors import CameraError, ConfigError
from pipeline.rigs import camera_request
from pipeline.scenario import load_scenario
from tests.pipeline.as_nobody import as_nobody

CLOCK = MonotonicClock()
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


class Driver:
    """Stands in for an opened cv2.VideoCapture: no camera is at hand where tests run."""

    def __init__(self, damaged: int, age: float) -> None:
        self._left, self._age = damaged, age
        self.asked: list[tuple[int, float]] = []
        self.known = {cv2.CAP_PROP_FRAME_WIDTH: 32.0, cv2.CAP_PROP_FRAME_HEIGHT: 24.0}

    def isOpened(self) -> bool:
        return True

    def set(self, key: int, value: float) -> bool:
        self.asked.append((key, value))
        return True

    def get(self, key: int) -> float:
        if key == cv2.CAP_PROP_POS_MSEC:
            return 1e3 * (time.monotonic() - self._age)
        return self.known.get(key, 0.0)

    def grab(self) -> bool:
        return True

    def retrieve(self) -> tuple[bool, np.ndarray | None]:
        self._left -= 1
        return (False, None) if self._left >= 0 else (True, np.zeros((24, 32, 3), np.uint8))

    def release(self) -> None: ...


def reader(driver: Driver, monkeypatch: pytest.MonkeyPatch) -> DeviceReader:
    monkeypatch.setattr(cv2, "VideoCapture", lambda *_: driver)
    wanted = CaptureFormat(
        (32, 24), None, "MJPG" if driver.known.get(cv2.CAP_PROP_FOURCC) else None
    )
    return DeviceReader(os.devnull, CLOCK, 0.2, wanted)


@pytest.mark.parametrize(("age", "dated"), [(0.05, 0.05), (5000.0, 0.2)])
def test_a_picture_is_as_old_as_its_stamp_says_or_as_the_latency(
    age: float, dated: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    picture = reader(Driver(0, age), monkeypatch).read()
    assert picture.t_arrival - picture.t_capture == pytest.approx(dated, abs=0.02)
    assert (picture.stamp is None) == (age > 1.0)


def test_a_damaged_picture_is_left_out_but_not_for_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    assert reader(Driver(3, 0.01), monkeypatch).read().image.shape == (24, 32, 3)
    with pytest.raises(CameraError, match="30 damaged pictures in a row"):
        reader(Driver(1000, 0.01), monkeypatch).read()


def test_the_pixel_format_is_set_before_the_size_that_depends_on_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    driver = Driver(0, 0.01)
    driver.known[cv2.CAP_PROP_FOURCC] = float(fourcc("MJPG"))
    reader(driver, monkeypatch)
    keys = [key for key, _ in driver.asked]
    assert keys.index(cv2.CAP_PROP_FOURCC) < keys.index(cv2.CAP_PROP_FRAME_WIDTH)
    assert (cv2.CAP_PROP_BUFFERSIZE, 2) in driver.asked  # one only would cost every other picture


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
