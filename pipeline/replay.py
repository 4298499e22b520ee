"""Turning the crank over a recording: the recorded inputs through the same step."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from time import perf_counter

from control.command import Command
from datasets.cycle import Moment, Timing
from pipeline.live import Stopwatch
from pipeline.memory import Memory
from pipeline.ports import Observer
from pipeline.setup import Setup
from pipeline.step import step


@dataclass(frozen=True, slots=True)
class Difference:
    """A cycle whose recomputed commands are not the recorded ones.

    Attributes:
        t: the moment of the cycle [s].
        recorded: commands that were sent.
        recomputed: commands that the same inputs give now.
    """

    t: float
    recorded: tuple[Command, ...]
    recomputed: tuple[Command, ...]


def refold(setup: Setup, moments: Iterable[Moment]) -> Iterator[tuple[Moment, Moment]]:
    """Run recorded inputs through the step.

    Args:
        setup: all that is constant in the run.
        moments: recorded, in order.

    Yields:
        Each recorded moment beside the one recomputed from its tick.
    """
    memory = Memory()
    for recorded in moments:
        watch, start = Stopwatch(), perf_counter()
        memory, cycle = step(setup, memory, recorded.tick, watch.locate)
        taken = perf_counter() - start
        timing = Timing(watch.elapsed, taken, taken)
        yield recorded, Moment(recorded.tick, cycle, recorded.truth, timing)


def replay(
    setup: Setup,
    moments: Iterable[Moment],
    observers: Iterable[Observer],
    interrupted: Callable[[], bool] = lambda: False,
) -> tuple[Difference, ...]:
    """Recompute a session and compare its commands, bit for bit.

    Args:
        setup: all that is constant in the run.
        moments: recorded, in order.
        observers: learn of every recomputed cycle; they are closed at the end.
        interrupted: asked once a cycle.

    Returns:
        The cycles whose commands differ.
    """
    observers = tuple(observers)
    differences = []
    try:
        for recorded, again in refold(setup, moments):
            if again.cycle.commands != recorded.cycle.commands:
                t, was, now = recorded.tick.t, recorded.cycle.commands, again.cycle.commands
                differences.append(Difference(t, was, now))
            for observer in observers:
                observer.observe(again)
            if interrupted():
                break
    finally:
        for observer in observers:
            observer.close()
    return tuple(differences)
