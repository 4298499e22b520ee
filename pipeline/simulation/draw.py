"""All that chance decides in some runs, drawn before the machine code starts.

A run is its seed: what is drawn for it does not depend on how many others there are. Lost frames
and lost messages are those of `live` with the same seed.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from control.geometry import Pose2D
from datasets.motion import moved
from datasets.plant import TONES, draw_tones
from datasets.simulation.inputs import Chance, Floats
from pipeline.simulation.experiment import Experiment
from pipeline.simulation.timetable import (
    HandedFrames,
    Timetable,
    handed_frames,
    make_timetable,
)
from pipeline.watching import initial_rates
from vision.scene import Detection, PixelPose, Scene

_POSES = 9  # stream of randomness


@dataclass(frozen=True, slots=True)
class Drawn:
    """What happens to some runs.

    Attributes:
        timetables: one a run.
        chance: the same and all else as tables.
    """

    timetables: tuple[Timetable, ...]
    chance: Chance


class Drawer:
    """Draws what happens to the runs of an experiment; what is alike in all is made once."""

    def __init__(self, experiment: Experiment) -> None:
        """Look at what can differ.

        Args:
            experiment: of the runs.
        """
        camera = experiment.scenario.camera
        faithful = not (camera.stamp_jitter_s or camera.dropped_share or camera.repeated_share)
        self._experiment = experiment
        self._alike: Timetable | None = None
        self._are_alike = faithful and not experiment.setup.watch_time

    def draw(self, seeds: Sequence[int]) -> Drawn:
        """Draw some runs.

        Args:
            seeds: one a run, >= 0.

        Returns:
            What happens to them.
        """
        drawn = [self._run(seed) for seed in seeds]
        tables = [table for table, _ in drawn]
        noises = [noise for _, noise in drawn]
        return Drawn(tuple(tables), _chance(self._experiment, seeds, tables, noises))

    def _run(self, seed: int) -> tuple[Timetable, Floats]:
        """Timetable of a run, and the errors of its measured poses (F, R, 3)."""
        experiment = self._experiment
        table = self._alike
        frames = table.frames if table else handed_frames(experiment, seed)
        noise = _noise(experiment, seed, len(frames))
        if table is None:
            table = make_timetable(
                experiment, frames, lambda number: _glimpse(experiment, frames, noise, number)
            )
            self._alike = table if self._are_alike else None
        return table, noise


def _noise(experiment: Experiment, seed: int, frames: int) -> Floats:
    rng = np.random.default_rng((seed, _POSES))
    return rng.standard_normal((frames, len(experiment.plants), 3)) * experiment.pose_std


def _glimpse(
    experiment: Experiment, frames: HandedFrames, noise: Floats, number: int
) -> Scene | None:
    """What a frame shows of robots that nobody has commanded yet: they drive on as they started."""
    if not experiment.setup.watch_time:
        return None
    taken = np.full(len(experiment.plants), frames.taken[number])
    poses = moved(experiment.field.starts, taken) + noise[number]
    pixel, covariance = PixelPose(0.0, 0.0, 0.0), np.diag(experiment.pose_std**2)
    seen = tuple(
        Detection(plant.robot_id, Pose2D(*pose), pixel, covariance, 0.0, 1.0)
        for plant, pose in zip(experiment.plants, poses.tolist(), strict=True)
    )
    return Scene(float(frames.stamps[number]), seen, ())


def _chance(
    experiment: Experiment,
    seeds: Sequence[int],
    tables: Sequence[Timetable],
    noises: Sequence[Floats],
) -> Chance:
    ticks = max((table.ticks for table in tables), default=0)
    frames = max((len(table.frames) for table in tables), default=0)
    shape = len(tables), ticks
    chance = Chance(
        ticks=np.array([(*table.driving, table.ticks) for table in tables], int).reshape(-1, 3),
        mission=np.full(shape, -1),
        share=np.ones(shape),
        frame=np.full(shape, -1),
        taken=np.full((len(tables), frames), np.inf),
        stamp=np.full((len(tables), frames), np.inf),
        noise=np.zeros((len(tables), frames, len(experiment.plants), 3)),
        lost=np.zeros((*shape, len(experiment.plants)), np.bool_),
        tones=np.zeros((len(tables), len(experiment.plants), 2, TONES, 2)),
        rates=np.zeros((len(tables), len(experiment.plants), 2)),
    )
    for run, (seed, table, noise) in enumerate(zip(seeds, tables, noises, strict=True)):
        count = len(table.frames)
        chance.mission[run, : table.ticks] = table.mission
        chance.share[run, : table.ticks] = table.shares
        chance.frame[run, table.frames.ticks] = np.arange(count)
        chance.taken[run, :count] = table.frames.taken
        chance.stamp[run, :count] = table.frames.stamps
        chance.noise[run, :count] = noise[:count]
        _draw_links_and_pushes(chance, run, experiment, seed)
        for robot, rates in initial_rates(experiment.setup, table.end)[0].items():
            chance.rates[run, experiment.setup.formation.robots.index(robot)] = rates
    return chance


def _draw_links_and_pushes(chance: Chance, run: int, experiment: Experiment, seed: int) -> None:
    """Lost messages as `radios.simulated` loses them, disturbances as `world` draws them."""
    first, end, _ = chance.ticks[run]
    if loss := experiment.scenario.radio.loss:
        rng = np.random.default_rng(seed)
        chance.lost[run, first:end] = rng.random((end - first, len(experiment.plants))) < loss
    if experiment.field.plants[:, 5:].any():
        numbers = [robot.id for robot in experiment.scenario.robots]
        for robot, plant in enumerate(experiment.plants):
            seeds = seed, numbers.index(plant.robot_id)
            chance.tones[run, robot] = draw_tones(np.random.default_rng(seeds))
