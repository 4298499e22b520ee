"""A wall clock that is set every second, by an hour forth or back, for one program alone."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

CLOCK = r"""
#define _GNU_SOURCE
#include <sys/syscall.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

int clock_gettime(clockid_t id, struct timespec *t) {
    int failed = syscall(SYS_clock_gettime, id, t);
    if (!failed && (id == CLOCK_REALTIME || id == CLOCK_REALTIME_COARSE))
        t->tv_sec += t->tv_sec % 2 ? 3600 : -3600;
    return failed;
}

int gettimeofday(struct timeval *t, void *zone) {
    struct timespec now;
    (void)zone;
    int failed = clock_gettime(CLOCK_REALTIME, &now);
    if (!failed && t) t->tv_sec = now.tv_sec, t->tv_usec = now.tv_nsec / 1000;
    return failed;
}

time_t time(time_t *t) {
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    if (t) *t = now.tv_sec;
    return now.tv_sec;
}
"""
STEPS = """
from time import sleep, time
times = [time() for _ in range(5) if sleep(0.4) is None]
assert max(times) - min(times) > 3000
"""


def deluded(folder: Path) -> dict[str, str]:
    """What a program's environment must have for it to see such a clock.

    Args:
        folder: for the library that does it.

    Returns:
        Variables; none where there is no C compiler.
    """
    compiler = shutil.which("cc")
    if compiler is None or not sys.platform.startswith("linux"):
        return {}
    source, library = folder / "wall_clock.c", folder / "wall_clock.so"
    source.write_text(CLOCK)
    subprocess.run((compiler, "-shared", "-fPIC", "-o", library, source), check=True)
    environment = {"LD_PRELOAD": str(library)}
    subprocess.run((sys.executable, "-c", STEPS), env={**os.environ, **environment}, check=True)
    return environment
