"""`echelon cameras`: every camera with what it does; where there is none, what to do."""

import json
import os
import sys
from pathlib import Path

import pytest

from pipeline.cameras.found import NO_CAMERA, find_cameras
from pipeline.cameras.v4l2 import V4l2Device
from pipeline.cli.listing import tell_camera
from pipeline.cli.output import Output
from tests.hardware.v4l2_cameras import Camera, c920, pi_camera
from tests.pipeline.commands import echelon


@pytest.fixture
def devices(tmp_path: Path) -> Path:
    """Device files of a webcam (with a node for other things) and a board's camera."""
    for name in ("video0", "video1", "video10", "video2", "null"):
        (tmp_path / name).touch()
    (tmp_path / "v4l" / "by-id").mkdir(parents=True)
    (tmp_path / "v4l" / "by-id" / "usb-C920-index0").symlink_to(tmp_path / "video0")
    return tmp_path


def plugged(path: str) -> V4l2Device:
    cameras: dict[str, Camera] = {"video0": c920(), "video2": pi_camera(), "video1": c920()}
    cameras["video1"].capture = False
    name = os.path.basename(path)
    if name not in cameras:
        raise PermissionError(13, "Permission denied")
    return V4l2Device(path, cameras[name].ioctl)


def test_cameras_in_the_order_of_their_numbers_by_lasting_names(devices: Path) -> None:
    webcam, board, forbidden = find_cameras(devices, plugged)
    assert [os.path.basename(c.path) for c in (webcam, board, forbidden)] == [
        "video0", "video2", "video10",
    ]  # fmt: skip
    assert webcam.spec == str(devices / "v4l" / "by-id" / "usb-C920-index0")
    assert (board.spec, board.card) == (board.path, "mmal service 16.1")
    assert "usermod -aG video" in forbidden.problem


def test_what_is_told(devices: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for camera in find_cameras(devices, plugged):
        tell_camera(camera, Output(False))
    lines = [" ".join(line.split()) for line in capsys.readouterr().out.splitlines()]
    assert "YUYV 640x480 30, 24, 20, 15, 10, 7.5, 5" in lines
    assert "MJPG 32x32 to 2592x1944, steps of 2x2 1 to 90" in lines
    assert "Exposure Time, Absolute 250 3 to 2047 250 the camera (automatic)" in lines
    assert any(
        line.startswith("Auto Exposure Aperture Priority Mode Manual Mode, Aperture")
        for line in lines
    )
    assert "echelon live --camera " + str(devices / "v4l/by-id/usb-C920-index0") in lines


@pytest.mark.skipif(bool(find_cameras()), reason="there is a camera at this machine")
@pytest.mark.skipif(sys.platform != "linux", reason="asks Linux")
def test_without_a_camera_it_says_what_to_do() -> None:
    done = echelon("cameras")
    assert (done.returncode, done.stdout.strip()) == (0, NO_CAMERA)
    told = json.loads(echelon("cameras", "--json").stdout)
    assert told == {"cameras": [], "advice": NO_CAMERA}
