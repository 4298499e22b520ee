"""One mission with faults, by the loop of `echelon live`."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from traceback import format_exception_only

import numpy as np

from benchmarks.faults.missions import TURNS, Made, made
from benchmarks.faults.outside import Outside, Watched
from benchmarks.faults.ports import Camera, Clock, Killed, Person, Radio
from benchmarks.faults.script import Script, draw
from control.command import Command
from datasets.cycle import Moment
from pipeline.cameras.rendered import RenderedCamera
from pipeline.live import Rig, run
from pipeline.ports import Observer
from pipeline.rigs import make_world

AFTERWARDS = 1.5  # the world is watched after the end [s]
PATIENCE = 90.0  # a mission that is not over then has failed [s]


@dataclass(slots=True)
class Diary:
    """An observer that keeps the mission's clock.

    Attributes:
        times: of the cycles [s].
        starts: when the mission's clock stood at 0, as each cycle had it; NaN before [s].
    """

    times: list[float] = field(default_factory=list)
    starts: list[float] = field(default_factory=list)

    def observe(self, moment: Moment) -> None:
        """Take note of one cycle.

        Args:
            moment: the cycle.
        """
        start = moment.cycle.t_start
        self.times.append(moment.tick.t)
        self.starts.append(np.nan if start is None else start)

    def close(self) -> None:
        """Keep what there is. Safe to call twice."""


@dataclass(frozen=True, slots=True)
class Driven:
    """A mission that is over.

    Attributes:
        course: its name.
        made: what it shares with others.
        script: what went wrong.
        watched: what really happened.
        handed: commands the radio was handed, with the moment [s].
        diary: the mission's clock.
        why: it ended: as `run` says, "killed", or the error.
        end: when [s].
    """

    course: str
    made: Made
    script: Script
    watched: Watched
    handed: list[tuple[float, Command]]
    diary: Diary
    why: str
    end: float


def drive(number: int, seed: int) -> Driven:
    """Draw a mission and drive it.

    Args:
        number: of the mission, >= 0.
        seed: of all missions, >= 0.

    Returns:
        What happened.
    """
    course = TURNS[number % len(TURNS)]
    script = draw(made(course).plot, np.random.default_rng((seed, number)))
    return drive_script(course, script, seed * 1_000_003 + number)


def drive_script(
    course: str, script: Script, seed: int, observers: Sequence[Observer] = ()
) -> Driven:
    """Drive a mission.

    Args:
        course: its name.
        script: what goes wrong.
        seed: of the world, >= 0.
        observers: who else looks on.

    Returns:
        What happened.
    """
    base, diary = made(course), Diary()
    scenario, setup, delay = base.scenario, base.setup, base.setup.radio_delay
    world = Outside(make_world(scenario).plants, script, base.room, delay, seed)
    radio = Radio(world, script, delay, seed)
    clock = Clock(script, radio)
    c = scenario.camera
    camera = Camera(RenderedCamera(world, base.renderer, c.fps, c.latency_s), script, c.latency_s)
    rig = Rig(camera, radio, clock, world.truth, (diary, *observers), Person(script))
    try:
        why = run(setup, rig, setup.period, PATIENCE, clock.interrupted)
    except Killed:
        why = "killed"
    except Exception as error:  # noqa: BLE001 (whatever it is, it is a finding)
        why = format_exception_only(error)[-1].strip()
    world.advance(clock.now() + AFTERWARDS)
    return Driven(course, base, script, world.watched, radio.handed, diary, why, clock.now())
