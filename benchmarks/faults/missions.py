"""The missions: shipped scenarios, slowed down or prolonged so that there is time for faults."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

from benchmarks.faults.script import Plot
from control.geometry import Pose2D
from datasets.render import Renderer
from pipeline.config import Scenario
from pipeline.filming import make_renderer
from pipeline.scenario import load_scenario
from pipeline.setup import Setup, make_setup

LAPS = 12
_HALF, _BACK = "{radius_m=0.4,turn_deg=180.0}", "{straight_m=0.8}"
_OVAL = ",".join(("{straight_m=1.0}", _HALF, *(2 * LAPS - 1) * (_BACK, _HALF)))
REST = 8.0  # after a fault, in which the formation must have come right again [s]
RIM, BORDER = 0.12, 0.03  # of the picture: where none is put down, and where none drives [m]


@dataclass(frozen=True, slots=True)
class Course:
    """A scenario with changes.

    Attributes:
        scenario: its name.
        overrides: of its keys.
        first: the first fault begins between these two [s].
        groups: of faults.
    """

    scenario: str
    overrides: tuple[str, ...]
    first: tuple[float, float]
    groups: int = 1


COURSES: Mapping[str, Course] = {
    "paper, in laps": Course(
        "paper",
        (f"leader.segments=[{_OVAL}]", "duration_s=50.0", "safety.together=true"),
        (2.0, 10.0),
        3,
    ),
    "paper": Course("paper", ("leader.speed_mps=0.25", "duration_s=16.0"), (1.0, 4.0)),
    "cascade": Course("cascade", ("leader.speed_mps=0.2", "duration_s=16.0"), (1.0, 4.0)),
    "diamond": Course("diamond", ("leader.speed_mps=0.2", "duration_s=16.0"), (1.0, 4.0)),
    "obstacle": Course("obstacle", ("leader.speed_mps=0.12", "duration_s=16.0"), (1.0, 4.0)),
    "hand-led": Course(
        "hand-led", ("robots.1.carried.speed_mps=0.15", "duration_s=16.0"), (3.0, 5.0)
    ),
}
TURNS = ("paper, in laps", "cascade", "paper, in laps", "diamond", "paper", "paper, in laps",
         "obstacle", "hand-led")  # fmt: skip
"""Courses of one mission after the other."""


@dataclass(frozen=True, slots=True)
class Made:
    """A course with all that missions on it share.

    Attributes:
        scenario: changed.
        setup: of its runs.
        renderer: draws it.
        plot: what may go wrong.
        room: opposite corners of where robots may be put down [m].
    """

    scenario: Scenario
    setup: Setup
    renderer: Renderer
    plot: Plot
    room: tuple[Pose2D, Pose2D]


@cache
def made(name: str) -> Made:
    """Make a course, once.

    Args:
        name: among `COURSES`.

    Returns:
        The course.
    """
    course = COURSES[name]
    low, high = _view(load_scenario(course.scenario), BORDER)
    arena = f"safety.arena_m=[{low.x},{low.y},{high.x},{high.y}]"
    scenario = load_scenario(course.scenario, (*course.overrides, arena))
    setup = make_setup(scenario)
    plot = Plot(course.first, course.groups, REST, setup.formation.robots, scenario.commanded)
    return Made(scenario, setup, make_renderer(scenario), plot, _view(scenario, RIM))


def _view(scenario: Scenario, rim: float) -> tuple[Pose2D, Pose2D]:
    """What the camera sees but for a rim of it [m]: the lower left and the upper right corner."""
    camera = scenario.camera
    (x, y), width = camera.center_m, 0.5 * camera.field_width_m
    height = width * camera.height_px / camera.width_px
    low = Pose2D(x - width + rim, y - height + rim, 0.0)
    return low, Pose2D(x + width - rim, y + height - rim, 0.0)
