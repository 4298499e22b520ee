"""What is said of simulated runs: one as `live` says it, many by mean, median and worst."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from math import inf, isfinite
from typing import Any

import numpy as np

from control.formation import by_follower
from control.unicycle import UnicycleState
from datasets.cycle import SafetyEvent
from datasets.scores import FollowerScore, LeaderScore
from datasets.sightings import Sighted
from datasets.simulation.inputs import Floats
from datasets.truth import RunResult
from pipeline.restraint import CALM, kept_event
from pipeline.simulation.experiment import Experiment
from pipeline.simulation.runs import Batch, Scored
from pipeline.watching import initial_rates

FIGURES = (
    "distance_rms_m", "distance_max_m", "bearing_rms_rad", "bearing_max_rad", "settled_at_s",
    "v_max_mps", "omega_max_radps",
)  # fmt: skip
"""Of a follower, in the order of `Figures.followers`."""


@dataclass(frozen=True, slots=True)
class Spread:
    """A figure over some runs; None where no run has it.

    Attributes:
        mean: of the runs that have it.
        median: likewise.
        worst: the greatest, or the least where less is worse.
        missing: runs that do not have it, e.g. never settled.
    """

    mean: float | None
    median: float | None
    worst: float | None
    missing: int


@dataclass(frozen=True, slots=True)
class Point:
    """Runs of one experiment.

    Attributes:
        swept: value by key, as it was given.
        runs: how many.
        followers: by id, spreads by figure.
        worst_follower: spreads of each figure of the worst follower of a run.
        leader: of the rms of its distance to the plan [m].
        clearance: of the least distance between two bodies [m].
        kept_apart: runs in which robots were kept off each other.
        stopped: runs that the safety rules ended.
        steps: ticks of all runs.
    """

    swept: dict[str, str]
    runs: int
    followers: dict[str, dict[str, Spread]]
    worst_follower: dict[str, Spread]
    leader: Spread
    clearance: Spread
    kept_apart: int
    stopped: int
    steps: int

    def to_json(self) -> dict[str, Any]:
        """The point as the command line prints it.

        Returns:
            A JSON-able object.
        """
        return {
            "swept": self.swept,
            "runs": self.runs,
            "followers": _plain(self.followers),
            "worst_follower": _plain(self.worst_follower),
            "leader": {"position_rms_m": asdict(self.leader)},
            "min_clearance_m": asdict(self.clearance),
            "kept_apart_runs": self.kept_apart,
            "safety_stops": self.stopped,
        }


def point_of(experiment: Experiment, swept: dict[str, str], scored: Sequence[Scored]) -> Point:
    """Condense the runs of a point.

    Args:
        experiment: of the runs.
        swept: value by key.
        scored: all its runs.

    Returns:
        The point.
    """
    figures = np.concatenate([some.figures.followers for some in scored])[:, 1:]
    tables = [table for some in scored for table in some.timetables]
    robots = experiment.setup.formation.robots[1:]
    return Point(
        swept=swept,
        runs=len(tables),
        followers={str(robot): _spreads(figures[:, k]) for k, robot in enumerate(robots)},
        worst_follower=_spreads(_worst(figures)),
        leader=_spread(np.concatenate([some.figures.leader for some in scored])),
        clearance=_spread(np.concatenate([some.figures.clearance for some in scored]), True),
        kept_apart=sum(int(some.kept.sum()) for some in scored),
        stopped=sum(table.end.phase == "given-up" for table in tables),
        steps=sum(table.ticks for table in tables),
    )


def run_result(experiment: Experiment, batch: Batch, wall: float) -> RunResult:
    """What is said of a single run.

    Args:
        experiment: of the run.
        batch: the run alone.
        wall: how long it took [s].

    Returns:
        The result; what only pictures have is None.
    """
    setup, table = experiment.setup, batch.drawn.timetables[0]
    rows = dict(zip(setup.formation.robots, batch.figures.followers[0].tolist(), strict=True))
    first, end = table.driving
    started = table.end.t_start is not None
    clearance = float(batch.figures.clearance[0])
    return RunResult(
        scenario=setup.name,
        frames=len(table.frames),
        duration_s=(table.ticks - 1) * setup.period,
        wall_s=wall,
        truth=True,
        followers=tuple(
            _score(pairs[0].follower, [pair.leader for pair in pairs], rows[robot])
            for robot, pairs in by_follower(setup.formation.pairs).items()
        ),
        leader=LeaderScore(_known(float(batch.figures.leader[0]))) if started else None,
        min_clearance_m=_known(clearance),
        seen=tuple(Sighted(robot, len(table.frames)) for robot in setup.formation.robots),
        vision=None,
        latency_ms=None,
        commands_sent=(end - first) * len(setup.formation.robots),
        safety_events=_events(experiment, batch),
        notes=initial_rates(setup, table.end)[1] if started else (),
    )


def _events(experiment: Experiment, batch: Batch) -> tuple[SafetyEvent, ...]:
    """What rules and filter did, in order of time."""
    setup, events = experiment.setup, list(batch.drawn.timetables[0].events)
    robots, ahead = setup.formation.robots, batch.trace.ahead[0].tolist()
    for index, robot in enumerate(robots):
        last = -inf
        for tick in np.flatnonzero(batch.trace.kept[0, :, index]).tolist():
            if (tick - last) * setup.period >= CALM:
                states = {
                    k: UnicycleState(*row) for k, row in zip(robots, ahead[tick], strict=True)
                }
                events.append(kept_event(setup, robot, states, tick * setup.period))
            last = tick
    return tuple(sorted(events, key=lambda event: event.t))


def _score(
    follower: int | str, leaders: Sequence[int | str], row: Sequence[float]
) -> FollowerScore:
    second = leaders[1] if len(leaders) == 2 else None
    return FollowerScore(follower, leaders[0], second, *map(_known, row))


def _known(value: float) -> float | None:
    return value if isfinite(value) else None


def _worst(figures: Floats) -> Floats:
    """The greatest of all followers (N, R, 7) in each run, (N, 7); one never settled is worst."""
    worst: Floats = np.fmax.reduce(figures, axis=1)
    settled = FIGURES.index("settled_at_s")
    worst[:, settled] = figures[:, :, settled].max(axis=1)
    return worst


def _spreads(figures: Floats) -> dict[str, Spread]:
    """Of figures (N, 7)."""
    return {name: _spread(figures[:, k]) for k, name in enumerate(FIGURES)}


def _spread(values: Floats, less_is_worse: bool = False) -> Spread:
    known = values[np.isfinite(values)]
    missing = len(values) - len(known)
    if not len(known):
        return Spread(None, None, None, missing)
    worst = known.min() if less_is_worse else known.max()
    return Spread(float(known.mean()), float(np.median(known)), float(worst), missing)


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(entry) for key, entry in value.items()}
    return asdict(value)
