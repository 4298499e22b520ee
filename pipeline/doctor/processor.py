"""The processor: how many cores, how fast they may go, which clock tells the time."""

import ctypes
import re

from pipeline.doctor.machine import Machine, text_of
from pipeline.finding import Finding

GOOD_CLOCKS = ("tsc", "kvm-clock", "hyperv_clocksource_tsc_page", "arch_sys_counter", "xen")
ENOUGH_CORES = 2  # one for the loop, one for what reads, records and shows


def cores(count: int) -> Finding:
    """Whether the loop has a core for itself.

    Args:
        count: of cores the process may use.

    Returns:
        A warning if there is one only.
    """
    remedy = "" if count >= ENOUGH_CORES else "a machine with more; else record and view little"
    return Finding("cores", not remedy, f"{count} may be used", False, remedy)


def governor(machine: Machine) -> Finding:
    """Whether cores keep their speed.

    Args:
        machine: whose processor is looked at.

    Returns:
        A warning if some may slow down to save power.
    """
    files = sorted(machine.sys.glob("devices/system/cpu/cpu[0-9]*/cpufreq/scaling_governor"))
    found = [text_of(path) for path in files]
    if not found:
        return Finding("processor speed", True, "not governed here (a virtual machine?)")
    slow = [name for name in found if name != "performance"]
    detail = ", ".join(f"{found.count(name)} x {name}" for name in sorted(set(found)))
    remedy = "sudo cpupower frequency-set -g performance" if slow else ""
    return Finding("processor speed", not slow, detail, False, remedy)


def clock_source(machine: Machine) -> Finding:
    """Whether reading the time is quick.

    Args:
        machine: whose clock is looked at.

    Returns:
        A warning if the kernel has fallen back to a slow one.
    """
    folder = machine.sys / "devices/system/clocksource/clocksource0"
    name = text_of(folder / "current_clocksource")
    if not name:
        return Finding("clock", True, "not told by this system")
    good = name in GOOD_CLOCKS
    better = [
        one for one in text_of(folder / "available_clocksource").split() if one in GOOD_CLOCKS
    ]
    remedy = "" if good else f"kernel option clocksource={better[0] if better else 'tsc'}"
    return Finding("clock", good, name, False, remedy)


def algebra_threads(threads: int | None, count: int) -> Finding:
    """Whether the linear algebra starts more threads than there are cores.

    Args:
        threads: it would use, None if it does not say.
        count: of cores the process may use.

    Returns:
        A warning if so: they push the loop off its core.
    """
    if threads is None:
        return Finding("BLAS threads", True, "not told by this library")
    many = threads > count
    remedy = f"export OPENBLAS_NUM_THREADS={count} OMP_NUM_THREADS={count}" if many else ""
    return Finding("BLAS threads", not many, f"{threads} on {count} cores", False, remedy)


def openblas_threads(machine: Machine) -> int | None:
    """Ask the OpenBLAS that NumPy has loaded.

    Args:
        machine: where this process tells what it has loaded.

    Returns:
        Number of threads, None if another library is in use.
    """
    loaded = re.search(r"\s(/\S*openblas\S*)", text_of(machine.proc / "self/maps"))
    if loaded is None:
        return None
    library = ctypes.CDLL(loaded.group(1))
    for name in (f"{p}openblas_get_num_threads{s}" for p in ("scipy_", "") for s in ("64_", "")):
        function = getattr(library, name, None)
        if function is not None:
            return int(function())
    return None
