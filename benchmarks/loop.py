"""The whole loop: frame to command, and simulated seconds per second."""

from dataclasses import dataclass, replace
from statistics import median
from time import perf_counter

from pipeline.live import run
from pipeline.readiness import ready_to_drive
from pipeline.rigs import connect
from pipeline.scenario import load_scenario
from pipeline.setup import make_scores, make_setup

RUNS = 5


@dataclass(frozen=True, slots=True)
class LoopTimes:
    """How fast a scenario runs.

    Attributes:
        scenario: its name.
        real_time_factor: simulated seconds per second, median of the runs.
        p50_ms: frame to command, median [ms].
        p99_ms: frame to command, 99th percentile [ms].
    """

    scenario: str
    real_time_factor: float
    p50_ms: float
    p99_ms: float


def measure(name: str) -> LoopTimes:
    """Run a scenario several times as fast as it goes.

    Args:
        name: of the scenario.

    Returns:
        Medians over the runs.
    """
    scenario = load_scenario(name)
    setup = make_setup(scenario, ready_to_drive(scenario))
    factors, middles, highs = [], [], []
    for seed in range(RUNS):
        scores = make_scores(setup)
        rig = replace(connect(scenario, "rendered", None, seed, True), observers=(scores,))
        start = perf_counter()
        run(setup, rig, setup.period)
        result = scores.result(name, perf_counter() - start)
        factors.append(result.duration_s / result.wall_s)
        if result.latency_ms is not None:
            middles.append(result.latency_ms.frame_to_command_p50)
            highs.append(result.latency_ms.frame_to_command_p99)
    return LoopTimes(name, median(factors), median(middles), median(highs))
