"""Simulated runs for studies: one point of a sweep after the other."""

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from datasets.simulation.inputs import Floats
from pipeline.scenario import load_scenario
from pipeline.simulation.experiment import make_experiment
from pipeline.simulation.runs import Batch, batches, load_kernel

Changes = tuple[str, ...]
"""Of the scenario `paper`, as `--set` takes them."""


def simulated(
    points: Sequence[Changes], runs: int, progress: Callable[[float], None]
) -> Iterator[Sequence[Batch]]:
    """Simulate the scenario `paper` at some points.

    Args:
        points: changes of the scenario that touch neither camera nor tags.
        runs: of every point, with the seeds 0, 1, ...
        progress: is told the share that is done.

    Yields:
        The runs of each point, in order.
    """
    seeing = None
    for number, changes in enumerate(points):
        progress(number / len(points))
        experiment = make_experiment(load_scenario("paper", changes), seeing=seeing)
        seeing = experiment.setup.seeing
        load_kernel(experiment)
        yield tuple(batches(experiment, range(runs)))


def worst_follower(batches: Sequence[Batch], column: int) -> Floats:
    """A figure of the worst follower of every run.

    Args:
        batches: of a point.
        column: in `Figures.followers`.

    Returns:
        (N,) figures; NaN where a follower has none.
    """
    figures = np.concatenate([batch.figures.followers[:, 1:, column] for batch in batches])
    worst: Floats = figures.max(axis=1)
    return worst
