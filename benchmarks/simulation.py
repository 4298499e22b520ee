"""Simulation without a camera: steps a second, alone and in a batch, beside a plain loop."""

import os
import subprocess
import sys
from dataclasses import dataclass
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter

import numpy as np

from pipeline.config import Scenario
from pipeline.scenario import check_tables, load_scenario
from pipeline.simulation.experiment import Experiment, make_experiment
from pipeline.simulation.runs import batches, load_kernel

BATCH = 3000  # robots in a batch, of all runs
MANY = 20  # robots of the larger formation
TURNS, PLAIN_STEPS = 5, 2000
STEP = 0.033  # of the plain loop [s]
FRESH = (
    "from pipeline.scenario import load_scenario\n"
    "from pipeline.simulation.experiment import make_experiment\n"
    "from pipeline.simulation.runs import load_kernel\n"
    "from time import perf_counter\n"
    "experiment = make_experiment(load_scenario('paper'))\n"
    "start = perf_counter()\n"
    "load_kernel(experiment)\n"
    "print(perf_counter() - start)\n"
)


@dataclass(frozen=True, slots=True)
class SimulationSpeed:
    """Steps a second, medians; a step is a tick of the host.

    Attributes:
        name: what was run.
        robots: how many.
        alone: one run after the other, each drawn, run and scored [1/s].
        batch: runs of 3000 robots together on all cores, drawn, run and scored [1/s].
        plain: a loop in Python and numpy that only moves as many robots [1/s].
    """

    name: str
    robots: int
    alone: float
    batch: float
    plain: float


@dataclass(frozen=True, slots=True)
class LoadTimes:
    """How long the first call takes.

    Attributes:
        compile_s: where no machine code is kept [s].
        load_s: where it is [s].
    """

    compile_s: float
    load_s: float


class PlainField:
    """Robots that are moved one step a call, in the manner of the Robotarium's simulator."""

    def __init__(self, count: int) -> None:
        """Put the robots in a row.

        Args:
            count: how many.
        """
        self._poses = np.zeros((3, count))
        self._poses[0] = 0.3 * np.arange(count)
        self._twists = np.zeros((2, count))

    def get_poses(self) -> np.ndarray:
        """Where the robots are.

        Returns:
            (3, N) x, y, theta.
        """
        return self._poses.copy()

    def set_velocities(self, twists: np.ndarray) -> None:
        """Command the robots.

        Args:
            twists: (2, N) v and omega, clipped to what the wheels can do.
        """
        track, most = 0.068, 1.5
        half = 0.5 * track * twists[1]
        wheels = np.clip(np.vstack((twists[0] - half, twists[0] + half)), -most, most)
        self._twists = np.vstack((0.5 * (wheels[0] + wheels[1]), (wheels[1] - wheels[0]) / track))

    def step(self) -> None:
        """Move on."""
        (v, omega), theta = self._twists, self._poses[2]
        self._poses[0] += STEP * v * np.cos(theta)
        self._poses[1] += STEP * v * np.sin(theta)
        turned = theta + STEP * omega
        self._poses[2] = np.arctan2(np.sin(turned), np.cos(turned))


def measure() -> tuple[list[SimulationSpeed], LoadTimes]:
    """Time the paper's three robots, and twenty.

    Returns:
        Speeds, and the times of the first call.
    """
    speeds = [_speed("paper", load_scenario("paper")), _speed("wedge of twenty", _twenty())]
    return speeds, LoadTimes(_fresh(True), _fresh(False))


def _speed(name: str, scenario: Scenario) -> SimulationSpeed:
    experiment = make_experiment(scenario)
    load_kernel(experiment)
    count = len(experiment.plants)
    plain = median(_plain(count) for _ in range(TURNS))
    alone = median(_steps_a_second(experiment, 1, seed) for seed in range(5 * TURNS))
    batch = median(_steps_a_second(experiment, BATCH // count, 0) for _ in range(TURNS))
    return SimulationSpeed(name, count, alone, batch, plain)


def _steps_a_second(experiment: Experiment, runs: int, seed: int) -> float:
    start = perf_counter()
    done = [batch.scored for batch in batches(experiment, range(seed, seed + runs))]
    taken = perf_counter() - start
    return sum(table.ticks for scored in done for table in scored.timetables) / taken


def _plain(count: int) -> float:
    """Steps a second of the plain loop: each robot goes towards a place beside the one before."""
    field, gap = PlainField(count), np.array([[-0.2], [0.1]])
    start = perf_counter()
    for _ in range(PLAIN_STEPS):
        poses = field.get_poses()
        wanted = np.roll(poses[:2], 1, axis=1) + gap
        away = wanted - poses[:2]
        c, s = np.cos(poses[2]), np.sin(poses[2])
        ahead, aside = c * away[0] + s * away[1], c * away[1] - s * away[0]
        field.set_velocities(np.vstack((2.0 * ahead, 4.0 * np.arctan2(aside, ahead))))
        field.step()
    return PLAIN_STEPS / (perf_counter() - start)


def _fresh(compiles: bool) -> float:
    """Time of the first call in a process of its own [s]."""
    with TemporaryDirectory() as folder:
        place = {"NUMBA_CACHE_DIR": folder} if compiles else {}
        done = subprocess.run(
            [sys.executable, "-c", FRESH], env=os.environ | place, capture_output=True, text=True,
            check=True,
        )  # fmt: skip
    return float(done.stdout)


def _twenty() -> Scenario:
    """Twenty robots in a wedge; printed markers, as there are not twenty colours."""
    paper = load_scenario("paper").model_dump(exclude_unset=True, mode="json")
    robots = [
        {"id": n + 1, "marker": n, "start": {"x_m": -0.15 * ((n + 1) // 2), "y_m": _side(n)}}
        for n in range(MANY)
    ]
    formation = {"leader": 1, "shape": "wedge", "spacing_m": 0.2}
    leader = paper["leader"] | {"speed_mps": 0.3, "segments": [{"straight_m": 3.0}]}
    tags = {"layout": "aruco", "marker_m": 0.06}
    return check_tables(
        paper | {"robots": robots, "formation": formation, "leader": leader, "tags": tags},
        "twenty robots",
    )


def _side(number: int) -> float:
    """Of robots in a wedge, in turn left and right [m]."""
    return 0.15 * ((number + 1) // 2) * (1.0 if number % 2 else -1.0)
