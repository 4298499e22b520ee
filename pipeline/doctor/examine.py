"""All checks of the machine, in reading order."""

import os
import platform
import sys
from collections.abc import Iterator
from pathlib import Path

from pipeline.doctor import access, processor, room, software
from pipeline.doctor.beat import keep_beat
from pipeline.doctor.machine import Machine
from pipeline.finding import Finding

HERE = Machine()


def examine(foreign: str, machine: Machine = HERE) -> Iterator[Finding]:
    """Look at everything that can spoil a run.

    Args:
        foreign: other people's packages by the names of Echelon's own, empty if there are none.
        machine: what is looked at.

    Yields:
        Findings; the last but one takes two seconds.
    """
    asked, wanted = software.asked()
    count = _usable_cores()
    yield software.python(platform.python_version(), asked)
    yield from software.packages(wanted)
    yield software.strangers(foreign)
    yield access.cameras(machine)
    yield access.serial_ports(machine)
    yield room.usb(machine)
    yield room.udp_buffer(machine)
    yield room.disk(machine)
    yield processor.cores(count)
    yield processor.governor(machine)
    yield processor.clock_source(machine)
    yield processor.algebra_threads(processor.openblas_threads(machine), count)
    yield keep_beat()
    yield software.viewer(os.environ, Path(sys.executable).parent)


def _usable_cores() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
