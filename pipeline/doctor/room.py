"""Room for data: on the disk, in the network's buffers, on the buses that cameras share."""

import re
import shutil
from collections import defaultdict
from pathlib import Path

from pipeline.doctor.machine import Machine, number_in
from pipeline.finding import Finding

PICTURE = 640 * 480 * 3  # uncompressed: the most that a lossless recording takes [B]
RATE = 30  # [1/s]
LITTLE, NONE = 10.0, 1.0  # room for so much of that is a warning, and bad [min]
STREAM_BUFFER = 393_216  # what FFmpeg asks for a UDP stream (libavformat/udp.c) [B]
FULL_SPEED = 5000  # from here on cameras do not fill a bus [Mbit/s]


def disk(machine: Machine) -> Finding:
    """Whether recordings have room.

    Args:
        machine: whose working folder is looked at.

    Returns:
        A warning below ten minutes, bad below one.
    """
    free = shutil.disk_usage(machine.work).free
    minutes = free / (PICTURE * RATE * 60)
    detail = f"{free / 1e9:.1f} GB free: {minutes:.0f} min or more of 640x480 at {RATE}/s"
    remedy = "" if minutes >= LITTLE else "make room, or --record to another disk"
    return Finding("disk", not remedy, detail, minutes < NONE, remedy)


def udp_buffer(machine: Machine) -> Finding:
    """Whether a picture that comes as a burst of datagrams is kept.

    Args:
        machine: whose network is looked at.

    Returns:
        A warning if the kernel grants less than is asked.
    """
    most = number_in(machine.proc / "sys/net/core/rmem_max")
    if most is None:
        return Finding("UDP buffer", True, "not told by this system")
    small = most < STREAM_BUFFER
    detail = f"{most} B at most, {STREAM_BUFFER} B are asked for a stream"
    remedy = "sudo sysctl -w net.core.rmem_max=1048576" if small else ""
    return Finding("UDP buffer", not small, detail, False, remedy)


def usb(machine: Machine) -> Finding:
    """Whether cameras share a slow bus.

    Args:
        machine: whose cameras are looked at.

    Returns:
        A warning if two or more do.
    """
    buses = _cameras_by_bus(machine)
    slow = {bus: n for bus, n in buses.items() if n > 1 and (_speed(bus) or 0) < FULL_SPEED}
    told = "; ".join(
        f"{bus.name}: {n} at {_speed(bus) or 'unknown'} Mbit/s" for bus, n in sorted(buses.items())
    )
    remedy = (
        "plug them into ports of different controllers, or send MJPG "
        "(camera.device.pixel_format): 640x480 at 30/s takes 147 Mbit/s uncompressed"
    )
    return Finding("USB", not slow, told or "no camera on it", False, remedy if slow else "")


def _cameras_by_bus(machine: Machine) -> dict[Path, int]:
    """Number of cameras on each bus; one camera may have several nodes."""
    devices: dict[Path, set[Path]] = defaultdict(set)
    for link in machine.sys.glob("class/video4linux/video*/device"):
        interface = link.resolve()
        for bus in interface.parents:
            if re.fullmatch(r"usb\d+", bus.name):
                devices[bus].add(interface.parent if ":" in interface.name else interface)
    return {bus: len(cameras) for bus, cameras in devices.items()}


def _speed(bus: Path) -> int | None:
    return number_in(bus / "speed")
