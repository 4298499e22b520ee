"""Which cameras this machine has."""

import glob
import os
from collections.abc import Callable
from pathlib import Path

from pipeline.cameras.capabilities import CameraDescription
from pipeline.cameras.v4l2 import V4l2Device

Open = Callable[[str], V4l2Device]
DEVICES = Path("/dev")
NO_CAMERA = (
    "no camera at this machine (no /dev/video*): plug one in; in a virtual machine or container "
    "hand the device through; a network camera needs no device: --camera URL"
)
NOT_LINUX = "cameras are listed on Linux only; elsewhere try live --camera 0, 1, ..."


def find_cameras(
    devices: Path = DEVICES, open_device: Open = V4l2Device
) -> list[CameraDescription]:
    """Describe every camera.

    Args:
        devices: folder of the device files.
        open_device: opens one.

    Returns:
        In the order of their numbers; one that cannot be asked says why.
    """
    paths = sorted(devices.glob("video[0-9]*"), key=lambda path: int(path.name[5:]))
    lasting = _lasting_names(devices)
    found = (_described(str(path), lasting.get(path.name), open_device) for path in paths)
    return [camera for camera in found if camera is not None]


def _described(path: str, lasting: str | None, open_device: Open) -> CameraDescription | None:
    """None for a device from which no pictures come."""
    spec = lasting or path
    try:
        with open_device(path) as device:
            if not device.captures:
                return None
            return CameraDescription(
                path, spec, device.card, device.driver, device.bus, device.formats(),
                device.controls(),
            )  # fmt: skip
    except PermissionError:
        why = "permission denied: sudo usermod -aG video $USER, then log in again"
        return CameraDescription(path, spec, problem=why)
    except OSError as error:
        return CameraDescription(path, spec, problem=error.strerror or str(error))


def _lasting_names(devices: Path) -> dict[str, str]:
    """By device name, the link that stays when cameras are plugged in another order."""
    links = sorted(glob.glob(str(devices / "v4l" / "by-id" / "*")))
    return {os.path.basename(os.path.realpath(link)): link for link in reversed(links)}
