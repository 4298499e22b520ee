"""What `echelon simulate` does: one run, or the points of a sweep."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from math import pi
from pathlib import Path
from time import perf_counter

import typer

from pipeline.cli.output import Output
from pipeline.cli.running import INTERRUPTED, SAFETY_STOP, paced
from pipeline.config import Scenario
from pipeline.errors import ConfigError
from pipeline.interruption import interruption
from pipeline.progress import ShareLine
from pipeline.radios.simulated import MESSAGE_SIZE
from pipeline.scenario import load_scenario
from pipeline.simulation.experiment import make_experiment
from pipeline.simulation.moments import moments_of
from pipeline.simulation.result import Point, Spread, point_of, run_result
from pipeline.simulation.runs import Scored, batches, load_kernel
from pipeline.simulation.sweep import combinations, parse_axes
from pipeline.trajectory import TrajectoryFile


@dataclass(frozen=True, slots=True)
class Request:
    """What `echelon simulate` was asked for.

    Attributes:
        scenario: name or file.
        runs: of every point.
        sweeps: "section.key=A,B,C" texts.
        seed: of the first run.
        overrides: "section.key=value" texts.
        duration: of every run, None: until the mission is finished [s].
        trajectory: CSV file of a single run.
    """

    scenario: str
    runs: int = 1
    sweeps: tuple[str, ...] = ()
    seed: int = 0
    overrides: tuple[str, ...] = ()
    duration: float | None = None
    trajectory: Path | None = None

    @property
    def seeds(self) -> range:
        """One a run."""
        return range(self.seed, self.seed + self.runs)


def run_simulate(request: Request, output: Output) -> None:
    """Simulate and tell the result.

    Args:
        request: what to run.
        output: where to say it.

    Raises:
        ConfigError: if the scenario or a sweep is wrong, or a trajectory of many runs is wanted.
        RecordingError: if the trajectory cannot be written.
        Exit: with status 4 if the safety rules ended a single run.
    """
    axes = parse_axes(request.sweeps)
    if request.runs == 1 and not axes:
        _run_once(request, output)
        return
    if request.trajectory is not None:
        raise ConfigError("--trajectory is of one run: leave out --runs and --sweep")
    points, start = list(combinations(axes)), perf_counter()
    with closing(ShareLine("runs")) as line, interruption() as interrupted:

        def _progress(done: int) -> None:
            line.show(done / (len(points) * request.runs))
            if interrupted():
                raise typer.Exit(INTERRUPTED)

        results = list(_points(request, points, _progress, output))
    _tell(request, results, perf_counter() - start, output)


def _run_once(request: Request, output: Output) -> None:
    scenario = _scenario(request, {}, output)
    experiment = make_experiment(scenario, request.duration)
    load_kernel(experiment)
    start = perf_counter()
    (batch,) = batches(experiment, request.seeds)
    output.result(run_result(experiment, batch, perf_counter() - start))
    if request.trajectory is not None:
        with closing(TrajectoryFile(request.trajectory, experiment.setup)) as file:
            for moment in moments_of(experiment, batch):
                file.observe(moment)
        output.say(f"trajectory: {request.trajectory}")
    if batch.drawn.timetables[0].end.phase == "given-up":
        raise typer.Exit(SAFETY_STOP)


def _points(
    request: Request,
    points: Sequence[dict[str, str]],
    progress: Callable[[int], None],
    output: Output,
) -> Iterator[Point]:
    """Run point after point; what sees is made once, as no key that is swept touches it."""
    seeing, done = None, 0
    for swept in points:
        scenario = _scenario(request, swept, output)
        experiment = make_experiment(scenario, request.duration, seeing)
        load_kernel(experiment)
        seeing, scored = experiment.setup.seeing, list[Scored]()
        for batch in batches(experiment, request.seeds):
            scored.append(batch.scored)
            done += len(batch.scored.timetables)
            progress(done)
        yield point_of(experiment, swept, scored)


def _scenario(request: Request, swept: dict[str, str], output: Output) -> Scenario:
    changes = (*request.overrides, *(f"{key}={value}" for key, value in swept.items()))
    scenario = load_scenario(request.scenario, changes)
    rate = scenario.radio.bandwidth_bytes_per_s
    return paced(scenario, MESSAGE_SIZE / rate, output) if rate else scenario


def _tell(request: Request, points: Sequence[Point], wall: float, output: Output) -> None:
    if output.as_json:
        rows = [point.to_json() for point in points]
        head = {"scenario": request.scenario, "runs": request.runs, "seed": request.seed}
        output.object(head | {"wall_s": wall, "points": rows})
        return
    steps = sum(point.steps for point in points)
    title = (
        f"{request.scenario}: {len(points) * request.runs} runs in {wall:.2f} s, "
        f"{steps / wall:,.0f} steps/s\nMedian / worst of the runs; errors of the worst follower, "
        f"true, last 20 % of a run"
    )
    header = (
        *points[0].swept, "runs", "distance rms mm", "bearing rms deg", "settled at s",
        "leader rms mm", "clearance mm", "kept apart", "stopped",
    )  # fmt: skip
    output.table(title, header, [_row(point) for point in points])


def _row(point: Point) -> tuple[str, ...]:
    worst = point.worst_follower
    return (
        *point.swept.values(),
        str(point.runs),
        _pair(worst["distance_rms_m"], 1e3),
        _pair(worst["bearing_rms_rad"], 180 / pi),
        _pair(worst["settled_at_s"]),
        _pair(point.leader, 1e3),
        _pair(point.clearance, 1e3),
        str(point.kept_apart),
        str(point.stopped),
    )


def _pair(spread: Spread, factor: float = 1.0) -> str:
    """Median and worst, and how many runs have none."""
    if spread.median is None or spread.worst is None:
        return "-"
    missing = f" ({spread.missing} never)" if spread.missing else ""
    return f"{factor * spread.median:.2f} / {factor * spread.worst:.2f}{missing}"
