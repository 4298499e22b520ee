"""The command line as a user meets it: its answer, what it says, and its exit status."""

import os
import signal
import subprocess
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryFile
from types import FrameType
from typing import IO

import pytest

from pipeline.cli.start import main

ROOT = Path(__file__).parents[2]
ECHELON = [sys.executable, "-m", "pipeline"]


def echelon_process(*arguments: object, timeout: float = 120.0) -> subprocess.CompletedProcess[str]:
    """Run `echelon` to its end, in a process of its own."""
    command = [*ECHELON, *map(str, arguments)]
    return subprocess.run(
        command, cwd=ROOT, capture_output=True, text=True, timeout=timeout, check=False
    )


def echelon(*arguments: object, timeout: float = 120.0) -> subprocess.CompletedProcess[str]:
    """The same in this process, where all is loaded; what libraries print counts too."""
    command = ["echelon", *map(str, arguments)]
    with TemporaryFile("w+") as out, TemporaryFile("w+") as err:
        with _alone(command, out, err), _in_time(timeout):
            status = _status()
        out.seek(0), err.seek(0)
        return subprocess.CompletedProcess(command, status, out.read(), err.read())


def _status() -> int:
    """Run `main` as the interpreter would."""
    try:
        main()
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else int(end.code is not None)
    except Exception:  # noqa: BLE001 (the interpreter, too, tells and ends with 1)
        traceback.print_exc()
        return 1
    return 0


@contextmanager
def _alone(command: list[str], out: IO[str], err: IO[str]) -> Iterator[None]:
    """Arguments, folder and streams of a process, down to the descriptors."""
    before = sys.argv, sys.stdin, sys.stdout, sys.stderr, Path.cwd()
    kept = [os.dup(number) for number in range(3)]
    with open(os.devnull) as nothing:
        for number, stream in enumerate((nothing, out, err)):
            os.dup2(stream.fileno(), number)
        sys.argv, sys.stdin, sys.stdout, sys.stderr = command, nothing, out, err
        os.chdir(ROOT)
        try:
            yield
        finally:
            out.flush(), err.flush()
            sys.argv, sys.stdin, sys.stdout, sys.stderr = before[:4]
            os.chdir(before[4])
            for number, copy in enumerate(kept):
                os.dup2(copy, number)
                os.close(copy)


@contextmanager
def _in_time(limit: float) -> Iterator[None]:
    """Fail if it takes longer [s]."""

    def _late(number: int, frame: FrameType | None) -> None:
        del number, frame
        pytest.fail(f"{' '.join(sys.argv)}: no end within {limit} s")

    before = signal.signal(signal.SIGALRM, _late)
    signal.setitimer(signal.ITIMER_REAL, limit)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
