"""V4L2: what drivers of known cameras answer is understood; what is asked of them is read back."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import pytest

from pipeline.cameras.capabilities import FrameSize
from pipeline.cameras.device import refused_options
from pipeline.cameras.options import DeviceOptions, apply
from pipeline.cameras.v4l2 import V4l2Device
from tests.hardware.v4l2_cameras import (
    EXPOSURE,
    EXPOSURE_AUTO,
    FOCUS,
    GAIN,
    POWER_LINE,
    REQUESTS,
    WHITE_BALANCE,
    WHITE_BALANCE_AUTO,
    Camera,
    c920,
    facecam,
    pi_camera,
)


@contextmanager
def plugged(camera: Camera) -> Iterator[V4l2Device]:
    with V4l2Device(os.devnull, camera.ioctl) as device:
        yield device


def asked(camera: Camera, options: DeviceOptions, fps: float | None = None) -> list[str]:
    with plugged(camera) as device:
        return list(apply(options, device, fps))


def test_every_request_says_the_size_of_its_structure() -> None:
    import ctypes

    for request, structure in REQUESTS.items():
        assert request >> 16 & 0x3FFF == ctypes.sizeof(structure)


def test_a_webcam_is_described_as_its_driver_does() -> None:
    with plugged(c920()) as device:
        assert (device.card, device.driver) == ("HD Pro Webcam C920", "uvcvideo")
        assert device.bus == "usb-0000:00:14.0-1"
        assert device.captures
        raw, jpeg = device.formats()
        controls = {control.name: control for control in device.controls()}
    assert (raw.code, raw.name, jpeg.code) == ("YUYV", "YUYV 4:2:2", "MJPG")
    assert raw.sizes[0] == FrameSize(
        (640, 480), (640, 480), (0, 0), (30.0, 24.0, 20.0, 15.0, 10.0, 7.5, 5.0)
    )
    assert jpeg.sizes[1].fps == (30.0, 24.0)
    exposure = controls["Exposure Time, Absolute"]
    assert (exposure.minimum, exposure.maximum, exposure.default) == (3, 2047, 250)
    assert (exposure.value, exposure.locked_out) == (250, True)
    assert controls["Auto Exposure"].choices == ((1, "Manual Mode"), (3, "Aperture Priority Mode"))
    assert "User Controls" not in controls  # a heading


def test_ranges_of_sizes_and_rates() -> None:
    with plugged(pi_camera()) as device:
        (jpeg,) = device.formats()
    assert jpeg.sizes == (FrameSize((32, 32), (2592, 1944), (2, 2), (90.0, 1.0), True),)


def test_a_node_for_other_things_is_no_camera() -> None:
    with plugged(replace(c920(), capture=False)) as device:
        assert not device.captures


def test_what_is_asked_is_locked_and_set() -> None:
    camera = c920()
    options = DeviceOptions(8.0, 40, 30, 4500, 50, True)
    assert asked(camera, options, 30.0) == []
    wanted = {
        EXPOSURE_AUTO: 1, EXPOSURE: 80, GAIN: 40, FOCUS: 30, WHITE_BALANCE_AUTO: 0,
        WHITE_BALANCE: 4500, POWER_LINE: 1, 0x009A0903: 0,
    }  # fmt: skip
    assert {number: camera.values[number] for number in wanted} == wanted


def test_exposure_by_hand_where_it_is_called_shutter_priority() -> None:
    camera = facecam()
    assert asked(camera, DeviceOptions(exposure_ms=5.0)) == []
    assert (camera.values[EXPOSURE_AUTO], camera.values[EXPOSURE]) == (2, 50)


def test_nothing_asked_nothing_written() -> None:
    camera = c920()
    assert asked(camera, DeviceOptions()) == []
    assert camera.written == []


@pytest.mark.parametrize(("camera", "mode"), [(c920(), 3), (pi_camera(), 0)])
def test_automatic_exposure_is_what_the_camera_calls_so(camera: Camera, mode: int) -> None:
    camera.values[EXPOSURE_AUTO] = 1
    assert asked(camera, DeviceOptions(exposure_ms="auto")) == []
    assert camera.values[EXPOSURE_AUTO] == mode


@pytest.mark.parametrize(
    ("camera", "options", "line"),
    [
        (
            c920(),
            DeviceOptions(exposure_ms=500.0),
            "exposure: 500 ms was asked for, the camera keeps 204.7 ms; "
            "it offers 0.3 ms to 204.7 ms",
        ),
        (
            c920(frozenset({EXPOSURE})),
            DeviceOptions(exposure_ms=5.0),
            "exposure: 5 ms was asked for, the camera keeps 25 ms; it offers 0.3 ms to 204.7 ms",
        ),
        (
            c920(frozenset({WHITE_BALANCE_AUTO})),
            DeviceOptions(white_balance_k=4500),
            "white balance: 4500 K was asked for, the camera keeps 4000 K (Permission denied); "
            "it offers 2000 K to 6500 K",
        ),
        (
            c920(),
            DeviceOptions(power_line_hz="auto"),
            "power line: auto was asked for, the camera keeps 60 Hz (Invalid argument); "
            "it offers Disabled, 50 Hz, 60 Hz",
        ),
        (pi_camera(), DeviceOptions(gain=3), "gain: the camera cannot set it"),
        (pi_camera(), DeviceOptions(focus="auto"), "focus: the camera has no automatic"),
    ],
)
def test_where_the_camera_does_otherwise_it_is_said(
    camera: Camera, options: DeviceOptions, line: str
) -> None:
    assert asked(camera, options)[-1] == line


def test_a_value_between_two_steps_is_as_asked() -> None:
    assert asked(c920(), DeviceOptions(focus=32)) == []  # steps of 5


def test_an_exposure_longer_than_a_frame_is_said() -> None:
    (line,) = asked(c920(), DeviceOptions(exposure_ms=50.0), 30.0)
    assert line.startswith("an exposure of 50 ms is longer than a frame at 30/s (33.3 ms)")
    assert asked(c920(), DeviceOptions(exposure_ms=33.0), 30.0) == []


def test_what_is_no_camera_is_told_not_raised(tmp_path: Path) -> None:
    options = DeviceOptions(gain=3)
    lines = refused_options(os.devnull, options, None)  # a real device, no camera
    lines += refused_options(str(tmp_path / "nothing"), options, None)
    assert [line.split(" (")[0] for line in lines] == 2 * ["exposure and the like cannot be set"]
    assert "No such file" in lines[1]


def test_a_failing_opening_leaves_nothing_open() -> None:
    before = len(os.listdir("/proc/self/fd"))
    with pytest.raises(OSError, match="ioctl"):
        V4l2Device(os.devnull)
    assert len(os.listdir("/proc/self/fd")) == before
