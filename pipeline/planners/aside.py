"""A planner in a process of its own: the loop goes on driving while it looks for a way."""

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from multiprocessing import get_context
from multiprocessing.connection import Connection

from control.planner import load_libraries
from control.replanning import Answer, Question, answered
from pipeline.errors import ConfigError

PATIENCE = 30.0  # for the process to start [s]
FAREWELL = 1.0  # for it to end [s]
NICE = 5  # the loop comes first
ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


class Aside:
    """Hands questions to a process, and answers back."""

    def __init__(self) -> None:
        """Start the process, and wait until it is ready.

        Raises:
            ConfigError: if it is not.
        """
        context = get_context("spawn")
        self._link, theirs = context.Pipe()
        self._process = context.Process(target=serve, args=(theirs,), name="planner", daemon=True)
        self._lost: Answer | None = None
        with _small_matrices():
            self._process.start()
        theirs.close()  # so that either end learns when the other is gone
        if not self._link.poll(PATIENCE) or not self._is_ready():
            self.close()
            raise ConfigError(f"the planner's process is not ready after {PATIENCE:g} s")

    def ask(self, question: Question) -> None:
        """Hand a question over.

        Args:
            question: what is wanted; one that waits is forgotten.
        """
        try:
            self._link.send(question)
        except OSError:
            request, reason = question.request, "the planner's process has ended"
            self._lost = Answer(request.t_start, request.clearance, None, reason)

    def answer(self) -> Answer | None:
        """Look whether an answer has come.

        Returns:
            The newest one, or None.
        """
        answer, self._lost = self._lost, None
        with suppress(OSError, EOFError):
            while self._link.poll():
                answer = self._link.recv()
        return answer

    def close(self) -> None:
        """End the process. Safe to call twice."""
        self._link.close()
        self._process.join(FAREWELL)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()

    def _is_ready(self) -> bool:
        """Whether its first word has come, and not its end."""
        try:
            return self._link.recv() is None
        except EOFError:
            return False


def serve(link: Connection) -> None:
    """Answer the newest question, again and again, until the other end is gone.

    Args:
        link: to the run.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C ends the run, which then ends this
    if hasattr(os, "nice"):
        os.nice(NICE)
    load_libraries()
    with suppress(OSError, EOFError):
        link.send(None)
        while True:
            question = link.recv()
            while link.poll():
                question = link.recv()
            link.send(answered(question))


@contextmanager
def _small_matrices() -> Iterator[None]:
    """What is started meanwhile solves with one thread: several wait for each other."""
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update(dict.fromkeys(ONE_THREAD, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            os.environ.pop(name)
            if value is not None:
                os.environ[name] = value
