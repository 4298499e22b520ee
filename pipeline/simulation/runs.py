"""Many runs of an experiment, some at a time on all cores: between them is time for Ctrl-C."""

import os
from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from datasets.simulation.inputs import Chance, Figures, Trace
from datasets.simulation.kernel import run_batch
from datasets.simulation.scoring import score_batch
from pipeline.compiling import told_of_compiling
from pipeline.simulation.draw import Drawer, Drawn
from pipeline.simulation.experiment import Experiment
from pipeline.simulation.timetable import Timetable

AT_A_TIME = 32
"""Runs of one call of machine code at most."""

MEMORY = 64e6
"""What all calls that are begun may take together [B]."""


@dataclass(frozen=True, slots=True)
class Scored:
    """What is kept of many runs.

    Attributes:
        timetables: one a run.
        figures: how well they went.
        kept: (N,) whether robots were kept off each other.
    """

    timetables: tuple[Timetable, ...]
    figures: Figures
    kept: NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Batch:
    """Some runs.

    Attributes:
        drawn: what chance decided.
        trace: what they were, tick by tick.
        figures: how well they went.
    """

    drawn: Drawn
    trace: Trace
    figures: Figures

    @property
    def scored(self) -> Scored:
        """The same without what was tick by tick."""
        kept = np.any(self.trace.kept, axis=(1, 2))
        return Scored(self.drawn.timetables, self.figures, np.asarray(kept))


def batches(experiment: Experiment, seeds: Sequence[int]) -> Iterator[Batch]:
    """Run and score.

    Args:
        experiment: of all runs.
        seeds: one a run, >= 0.

    Yields:
        The runs in their order, some together.
    """
    drawer, row, cores = Drawer(experiment), 100.0 * len(experiment.plants), _cores()
    most = max(1, min(AT_A_TIME, int(MEMORY / (row * experiment.ticks * (cores + 1)))))
    together = min(most, -(-len(seeds) // cores)) or 1
    with ThreadPoolExecutor(cores) as pool:  # machine code needs no interpreter's lock
        begun = deque[Future[Batch]]()
        for first in range(0, len(seeds), together):
            drawn = drawer.draw(seeds[first : first + together])
            begun.append(pool.submit(run_some, experiment, drawn))
            if len(begun) > cores:
                yield begun.popleft().result()
        while begun:
            yield begun.popleft().result()


def _cores() -> int:
    """How many this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def load_kernel(experiment: Experiment) -> None:
    """Compile the machine code, or load it from disk, by running nothing.

    Args:
        experiment: any.
    """
    with told_of_compiling("the simulation", "about half a minute"):
        run_some(experiment, Drawer(experiment).draw(()))


def run_some(experiment: Experiment, drawn: Drawn) -> Batch:
    """Run and score what was drawn.

    Args:
        experiment: of all runs.
        drawn: what happens to them.

    Returns:
        The runs.
    """
    trace = _empty_trace(drawn.chance)
    run_batch(experiment.host, experiment.gains, experiment.field, drawn.chance, trace)
    return Batch(drawn, trace, score(experiment, drawn.chance, trace))


def score(experiment: Experiment, chance: Chance, trace: Trace) -> Figures:
    """Score runs.

    Args:
        experiment: of all runs.
        chance: says when their missions began and they ended.
        trace: what they were.

    Returns:
        Their figures.
    """
    runs, _, robots, _ = trace.states.shape
    figures = Figures(np.full((runs, robots, 7), np.nan), np.empty(runs), np.empty(runs))
    score_batch(experiment.goals, chance, trace, figures)
    return figures


def _empty_trace(chance: Chance) -> Trace:
    shape = *chance.frame.shape, chance.noise.shape[2]
    states, ahead = np.empty((*shape, 5)), np.empty((*shape, 5))
    return Trace(states, ahead, np.zeros((*shape, 2)), np.zeros(shape, np.bool_))
