"""Devices: what is missing or wrong is said in one line, and OpenCV says nothing beside it."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from tempfile import TemporaryDirectory

import pytest

from pipeline.cameras.device import CaptureFormat, format_refused, open_device, stamp_age
from pipeline.clock import MonotonicClock
from pipeline.errors import CameraError

NOBODY = 65534  # a user id without rights


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


@contextmanager
def as_nobody() -> Iterator[None]:
    """Be a user without rights for a while; root may open everything."""
    user = os.geteuid()
    if user == 0:
        os.seteuid(NOBODY)
    try:
        yield
    finally:
        os.seteuid(user)


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
