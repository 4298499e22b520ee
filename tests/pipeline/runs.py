"""Closed-loop runs for tests: a scenario through rendered frames, as fast as it goes."""

from dataclasses import replace

from datasets.cycle import Moment
from datasets.truth import RunResult
from pipeline.live import run
from pipeline.rigs import connect
from pipeline.scenario import load_scenario
from pipeline.setup import Setup, make_scores, make_setup


class Keeper:
    """An observer that keeps every moment."""

    def __init__(self) -> None:
        self.moments: list[Moment] = []
        self.closed = False

    def observe(self, moment: Moment) -> None:
        self.moments.append(moment)

    def close(self) -> None:
        self.closed = True


def run_scenario(
    name: str, seed: int = 0, overrides: tuple[str, ...] = (), duration: float | None = None
) -> tuple[Setup, RunResult, list[Moment]]:
    """Run a scenario and give its setup, its scores and all its moments."""
    scenario = load_scenario(name, overrides)
    setup, keeper = make_setup(scenario), Keeper()
    scores = make_scores(setup)
    rig = replace(connect(scenario, "rendered", None, seed, True), observers=(scores, keeper))
    run(setup, rig, setup.period, duration)
    assert keeper.closed
    return setup, scores.result(name, 0.0), keeper.moments
