"""Single frames over noise, blur and size, searched from nothing and tracked."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np

from benchmarks.limits.errors import Errors
from control.geometry import Pose2D
from control.unicycle import UnicycleState
from datasets.cycle import RobotState
from pipeline.filming import make_renderer
from pipeline.scenario import load_scenario
from pipeline.setup import Setup, make_setup
from vision.frame import as_frame
from vision.light import PALETTE_LIGHT
from vision.locate import Prediction

NOISES = (1.0, 3.0, 6.0, 12.0)  # of 255
BLURS = (0.3, 0.6, 1.2)  # [px]
SIZES = (6, 8, 10, 14, 20)  # of a robot [px]
FRAMES, GAP = 60, 0.12  # pictures a cell; least distance of two robots [m]
SIDE = 0.075  # of a robot [m]
DOUBT = (0.004, 0.004, 0.06)  # of a prediction over one frame [m, m, rad]
_MOUNT = 2.5 / 2.4  # height of the camera over the width of its field, as in `paper`


@dataclass(frozen=True, slots=True)
class Cell:
    """One cell of the grid.

    Attributes:
        size_px: of a robot.
        noise: read noise, of 255.
        blur_px: of the lens.
        searched: errors of the search from nothing.
        tracked: errors with predictions.
    """

    size_px: int
    noise: float
    blur_px: float
    searched: Errors
    tracked: Errors


def cells() -> Iterator[Cell]:
    """Measure cell after cell, always the same.

    Yields:
        One result per cell.
    """
    for number, (size, noise, blur) in enumerate(product(SIZES, NOISES, BLURS)):
        yield _measured(size, noise, blur, np.random.default_rng(number))


def count() -> int:
    """How many cells there are.

    Returns:
        Their number.
    """
    return len(SIZES) * len(NOISES) * len(BLURS)


def _measured(size: int, noise: float, blur: float, rng: np.random.Generator) -> Cell:
    width = 320 * SIDE / size
    scenario = load_scenario(
        "paper",
        (f"camera.field_width_m={width}", f"camera.mount_height_m={width * _MOUNT}",
         f"sensor.read_noise={noise}", f"sensor.blur_px={blur}"),
    )  # fmt: skip
    setup, renderer = make_setup(scenario), make_renderer(scenario)
    searched, tracked = Errors(SIDE), Errors(SIDE)
    for number in range(FRAMES):
        states = _scattered(setup, rng)
        t = number / 30.0
        frame = as_frame(renderer.render(states, t), t, number)
        told = tuple(_nearly(state, rng) for state in states)
        searched.add(setup.seeing.detector.locate(frame, (), PALETTE_LIGHT), states)
        tracked.add(setup.seeing.detector.locate(frame, told, PALETTE_LIGHT), states)
    return Cell(size, noise, blur, searched, tracked)


def _scattered(setup: Setup, rng: np.random.Generator) -> tuple[RobotState, ...]:
    """The robots at random places wholly in the picture, with random headings."""
    camera = setup.camera
    width, height = camera.size_px
    rim = np.array([[0.0, height - 1.0], [width - 1.0, 0.0]])
    low, high = camera.to_floor(rim, camera.tag_height) + np.array([[0.06], [-0.06]])
    while True:
        places = rng.uniform(low, high, (len(setup.tags.ids), 2))
        away = np.hypot(*(places[:, None] - places).transpose(2, 0, 1)) + np.eye(len(places))
        if away.min() > GAP:
            break
    turns = rng.uniform(-np.pi, np.pi, len(places)).tolist()
    return tuple(
        RobotState(robot_id, UnicycleState(x, y, turn, 0.0, 0.0))
        for robot_id, (x, y), turn in zip(setup.tags.ids, places.tolist(), turns, strict=True)
    )


def _nearly(robot: RobotState, rng: np.random.Generator) -> Prediction:
    x, y, turn = rng.normal(0.0, DOUBT).tolist()
    s = robot.state
    pose = Pose2D(s.x + x, s.y + y, s.theta + turn)
    return Prediction(robot.robot_id, pose, np.diag(np.square(DOUBT)))
