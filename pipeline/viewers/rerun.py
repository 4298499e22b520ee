"""The Rerun view of a run: an observer that can neither slow the loop nor delay its end.

Moments go through a short queue to a helper process that talks to Rerun: there its cost never
meets the control loop, and a viewer that was closed, or hangs, can be left behind at once.
"""

import os
import pickle
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from queue import Full, Queue
from threading import Thread
from time import monotonic
from typing import IO

from datasets.cycle import Moment
from datasets.errors import RecordingError
from pipeline.errors import ConfigError
from pipeline.viewers.stage import Stage

_QUEUE = 8  # moments; a quarter of a second
_PERIOD = 1.0 / 30.0  # between drawings [s]
_SILENCE = 0.1  # without frames, draw this often [s]
_START_LIMIT = 20.0  # for the viewer to open [s]
_LIVE_END_LIMIT = 2.0  # for the viewer to take the rest; the robots stand already [s]
_FILE_END_LIMIT = 60.0  # for a file to be finished [s]


class RerunViewer:
    """Shows a run in the Rerun viewer, or writes it to a file that Rerun opens.

    Attributes:
        dropped: moments that were to be drawn and were not, because drawing was too slow.
    """

    def __init__(self, mode: str, stage: Stage, wait: bool = False) -> None:
        """Open the viewer or the file.

        Args:
            mode: "rerun" opens the viewer; anything else is the path of an .rrd file.
            stage: what is drawn on.
            wait: when drawing is behind, hold the run up instead of dropping (for runs without a
                real-time clock).

        Raises:
            ConfigError: if the viewer cannot be opened.
            RecordingError: if the file cannot be written.
        """
        self.dropped = 0
        self._live = mode == "rerun"
        self._wait = wait
        self._next = float("-inf")
        self._process = _start(mode)
        _expect_ready(self._process, mode, stage)
        self._queue: Queue[Moment | None] = Queue(_QUEUE)
        self._thread: Thread | None = Thread(target=self._send, name="viewer", daemon=True)
        self._thread.start()

    def observe(self, moment: Moment) -> None:
        """Queue one cycle for drawing, at most one per picture; events are always taken.

        Args:
            moment: its inputs, outcome, truth and cost.
        """
        t, due = moment.tick.t, self._next
        wanted = t >= (due if moment.tick.frame else due + _SILENCE) or moment.cycle.events
        if not wanted or self._thread is None:
            return
        self._next = t + 0.5 * _PERIOD  # frames do not come exactly on time
        try:
            self._queue.put(moment, block=self._wait, timeout=_START_LIMIT)
        except Full:
            self.dropped += 1

    def close(self) -> None:
        """Send the rest and let the viewer go; a file is finished first. Safe to call twice."""
        thread, self._thread = self._thread, None
        if thread is None:
            return
        end = monotonic() + (_LIVE_END_LIMIT if self._live else _FILE_END_LIMIT)
        try:
            self._queue.put(None, timeout=max(end - monotonic(), 0.0))
            thread.join(max(end - monotonic(), 0.0))
            self._process.wait(max(end - monotonic(), 0.0))
        except (Full, subprocess.TimeoutExpired):
            self._process.kill()
            self._process.wait()
        thread.join(_LIVE_END_LIMIT)
        for pipe in (self._process.stdin, self._process.stdout):
            with suppress(OSError):  # what is left in the pipe of a dead viewer
                _pipe(pipe).close()

    def _send(self) -> None:
        """Runs on the viewer's thread until the end of the queue; a dead viewer is ignored."""
        stream = _pipe(self._process.stdin)
        alive = True
        while (moment := self._queue.get()) is not None:
            alive = alive and _write(stream, moment)
            self.dropped += not alive
        _write(stream, None)


def _start(mode: str) -> subprocess.Popen[bytes]:
    """Start the helper process with this program's import path."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(p or "." for p in sys.path)}
    if mode != "rerun":
        try:
            Path(mode).open("wb").close()
        except OSError as error:
            raise RecordingError(f"{mode}: cannot be written ({error.strerror})") from error
    return subprocess.Popen(
        [sys.executable, "-m", "pipeline.viewers.rerun_process"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env=environment,
        start_new_session=True,  # Ctrl-C ends the run, which then closes the viewer in order
    )


def _expect_ready(process: subprocess.Popen[bytes], mode: str, stage: Stage) -> None:
    """Hand over what is fixed, and wait until the viewer is there."""
    _write(_pipe(process.stdin), (mode, stage))
    answers: Queue[bytes] = Queue()
    listener = Thread(target=lambda: answers.put(_pipe(process.stdout).readline()), daemon=True)
    listener.start()
    listener.join(_START_LIMIT)
    answer = answers.get() if not answers.empty() else b"no answer within 20 s"
    if answer != b"ready\n":
        process.kill()
        process.wait()
        reason = answer.decode().strip() or "the helper process ended"
        raise ConfigError(f"--view {mode}: Rerun cannot be opened ({reason})")


def _pipe(stream: IO[bytes] | None) -> IO[bytes]:
    if stream is None:
        raise ValueError("the process was started without this pipe")
    return stream


def _write(stream: IO[bytes], message: object) -> bool:
    """Send one message to the helper process; False if it is gone."""
    try:
        pickle.dump(message, stream, protocol=pickle.HIGHEST_PROTOCOL)
        stream.flush()
    except (OSError, ValueError):
        return False
    return True
