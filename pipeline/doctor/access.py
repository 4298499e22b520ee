"""Who may open cameras and serial ports."""

import os
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from pipeline.doctor.machine import Machine
from pipeline.finding import Finding

if sys.platform != "win32":
    import grp


@dataclass(frozen=True, slots=True)
class _Kind:
    """A kind of device: its files, and the groups that systems give it to."""

    topic: str
    patterns: tuple[str, ...]
    groups: tuple[str, ...]


_CAMERAS = _Kind("cameras", ("video[0-9]*",), ("video",))
_PORTS = _Kind("serial ports", ("ttyUSB*", "ttyACM*", "rfcomm*"), ("dialout", "uucp"))


def cameras(machine: Machine) -> Finding:
    """Whether the user may open the cameras.

    Args:
        machine: whose devices are looked at.

    Returns:
        Bad if one is forbidden; a warning if the next one will be.
    """
    return _access(machine, _CAMERAS)


def serial_ports(machine: Machine) -> Finding:
    """Whether the user may open the serial ports.

    Args:
        machine: whose devices are looked at.

    Returns:
        Bad if one is forbidden; a warning if the next one will be.
    """
    return _access(machine, _PORTS)


def _access(machine: Machine, kind: _Kind) -> Finding:
    if sys.platform == "win32":
        return Finding(kind.topic, True, "this system does not give them to groups")
    paths = sorted(path for pattern in kind.patterns for path in machine.dev.glob(pattern))
    forbidden = [path for path in paths if not _may_open(path)]
    names = ", ".join(path.name for path in forbidden or paths)
    if forbidden:
        remedy = _joining(sorted({_group_of(path) for path in forbidden}))
        return Finding(kind.topic, False, f"not allowed: {names}", remedy=remedy)
    if paths:
        return Finding(kind.topic, True, f"allowed: {names}")
    groups = list(_existing(kind.groups))
    if os.geteuid() == 0 or not groups or any(gid in _own_groups() for _, gid in groups):
        return Finding(kind.topic, True, "none is plugged in; the user may open one")
    detail = f"none is plugged in; the user is not in the group {groups[0][0]}"
    return Finding(kind.topic, False, detail, False, _joining([groups[0][0]]))


def _may_open(path: Path) -> bool:
    effective = os.access in os.supports_effective_ids
    return os.access(path, os.R_OK | os.W_OK, effective_ids=effective)


def _joining(groups: list[str]) -> str:
    return f"sudo usermod -aG {','.join(groups)} $USER, then log in again"


def _group_of(path: Path) -> str:
    number = path.stat().st_gid
    try:
        return grp.getgrgid(number).gr_name
    except KeyError:
        return str(number)


def _existing(names: tuple[str, ...]) -> Iterator[tuple[str, int]]:
    for name in names:
        try:
            yield name, grp.getgrnam(name).gr_gid
        except KeyError:
            continue


def _own_groups() -> set[int]:
    return {os.getegid(), *os.getgroups()}
