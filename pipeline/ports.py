"""The seams to the world outside: small protocols that every adapter follows."""

from typing import Protocol

from control.command import Command, RobotId
from control.replanning import Answer, Question
from datasets.cycle import Moment, Orders
from vision.frame import Frame


class FrameSource(Protocol):
    """Where frames come from."""

    def latest(self, now: float) -> Frame | None:
        """Hand out the newest frame not handed out before.

        Args:
            now: the moment of the cycle [s].

        Returns:
            The newest frame that has arrived by now, None if there is no new one.

        Raises:
            CameraError: if the source has failed.
            EndOfStream: if the source has ended and its last frame was handed out.
        """
        ...

    def close(self) -> None:
        """Release the device. Safe to call twice."""
        ...


class EndOfStream(Exception):
    """A finite source (a file) has no more frames."""


class CommandSink(Protocol):
    """Where commands go."""

    @property
    def min_period(self) -> float:
        """How often the link carries a command for every robot [s]; 0 for any rate."""
        ...

    def send(self, commands: tuple[Command, ...], now: float) -> tuple[RobotId, ...]:
        """Send the newest commands; stale or non-finite ones are dropped and counted, never queued.

        Args:
            commands: at most one per robot.
            now: the moment of the cycle [s]; a command with valid_until < now is not sent.

        Returns:
            Robots whose link is down.
        """
        ...

    def stop(self, now: float) -> None:
        """Send stop to every robot, three times.

        Args:
            now: the moment of the call [s].
        """
        ...

    def close(self) -> None:
        """Release the link. Safe to call twice."""
        ...


class Operator(Protocol):
    """The person at the controls."""

    def orders(self, now: float) -> Orders:
        """What is wanted since the last time it was asked.

        Args:
            now: the moment of the cycle [s].

        Returns:
            The orders.
        """
        ...

    def close(self) -> None:
        """Give back what was taken, as a terminal. Safe to call twice."""
        ...


class Planner(Protocol):
    """Finds the leader another way while the robots drive."""

    def ask(self, question: Question) -> None:
        """Begin to look for a way; a question that was not answered yet may be forgotten.

        Args:
            question: what is wanted.
        """
        ...

    def answer(self) -> Answer | None:
        """Ask what was found, without waiting.

        Returns:
            An answer that was not given before, or None.
        """
        ...

    def close(self) -> None:
        """Release what is held. Safe to call twice."""
        ...


class Clock(Protocol):
    """The one time of a run, shared with capture timestamps."""

    def now(self) -> float:
        """Tell the time.

        Returns:
            Present time [s].
        """
        ...

    def wait_until(self, t: float) -> float:
        """Wait for a moment.

        Args:
            t: when to wake [s].

        Returns:
            The slack that was left on arrival [s]; negative if t had passed.
        """
        ...


class Observer(Protocol):
    """Who learns of every cycle: recorder, viewer, scores, progress. Never slows the loop."""

    def observe(self, moment: Moment) -> None:
        """Take note of one cycle.

        Args:
            moment: its inputs, outcome, truth and cost.
        """
        ...

    def close(self) -> None:
        """Finish and release what is held. Safe to call twice."""
        ...
