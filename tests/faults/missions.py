"""Missions in which something goes wrong, one after another, until the time is over."""

import random
from collections.abc import Iterator
from dataclasses import dataclass
from math import inf

from pipeline.live import Rig, run
from pipeline.radios.simulated import SimulatedRadio
from pipeline.scenario import load_scenario
from pipeline.setup import Setup, make_setup
from tests.faults.promises import MOTORS, OWN_TIMEOUT, SIGTERM
from tests.faults.schedule import Fault, draw
from tests.faults.watch import Record, Watch
from tests.faults.world import (
    FaultyCamera,
    FaultyClock,
    FaultyOperator,
    FaultyRadio,
    Floor,
    Killed,
)

CIRCLE = (
    "leader.segments=[{straight_m=0.2},{radius_m=0.4,turn_deg=72000}]", "leader.speed_mps=0.25",
    "duration_s=86400", "safety.arena_m=[-0.62,-0.43,1.62,1.23]",
)  # fmt: skip
ALONE = 0.01  # between two looks at robots whose program is gone [s]


@dataclass(frozen=True, slots=True)
class Mission:
    """What became of one.

    Attributes:
        seed: that repeats it.
        lasted: simulated time [s].
        ended: why.
        records: of its faults.
        broken: promises that were not kept.
    """

    seed: int
    lasted: float
    ended: str
    records: tuple[Record, ...]
    broken: tuple[str, ...]


def run_mission(seed: int, duration: float, scenario: str = "paper") -> Mission:
    """One mission.

    Args:
        seed: of everything random.
        duration: at most [s].
        scenario: whose robots, camera and laws are used; its leader goes in circles.

    Returns:
        What became of it.
    """
    described = load_scenario(scenario, CIRCLE)
    setup = make_setup(described)
    faults = draw(random.Random(seed), setup.formation.robots, duration)
    floor = Floor(described, faults, seed)
    r = described.radio
    inner = SimulatedRadio(floor.world, r.delay_s, r.loss, r.bandwidth_bytes_per_s, seed)
    radio, watch = FaultyRadio(inner, faults), Watch(setup, faults, floor)

    def _die() -> None:
        radio.dead = True

    clock = FaultyClock(faults, _die)
    camera = FaultyCamera(described, floor, faults, seed)
    rig = Rig(camera, radio, clock, floor.truth, (watch,), FaultyOperator(faults))
    terms = min((f.begins for f in faults if f.kind == SIGTERM), default=inf)
    try:
        why = run(setup, rig, setup.period, duration, lambda: clock.now() >= terms)
    except Killed:
        why = "killed"
    _watch_the_end(clock.now(), floor, watch)
    broken = (*watch.broken, *_expected(why, setup, faults, radio))
    return Mission(seed, clock.now(), why, tuple(watch.records), broken)


def _watch_the_end(t: float, floor: Floor, watch: Watch) -> None:
    """The program is gone: its robots stand, and stay so."""
    end = t + OWN_TIMEOUT + 2.0 * MOTORS
    while t < end:
        t += ALONE
        floor.advance(t)
        watch.judge_motion(t, {s.robot_id: s.state for s in floor.truth()})
    moving = [s for s in floor.truth() if s.robot_id not in floor.lifted and abs(s.state.v) > 1e-3]
    watch.broken += [f"{t:.3f} s: robot {s.robot_id} moves after the end" for s in moving]


def _expected(
    why: str, setup: Setup, faults: tuple[Fault, ...], radio: FaultyRadio
) -> Iterator[str]:
    """Whether it ended as it should."""
    last = faults[-1].kind if faults else ""
    hopeless = any(setup.rules.give_up < f.ends - f.begins < inf for f in faults)
    right = {"SIGTERM": "interrupted", "SIGKILL": "killed"}.get(last, "time")
    if why != right and not (why == "given-up" and hopeless):
        yield f"ended: {why}, not {right} (gives up after {setup.rules.give_up:g} s)"
    if why != "killed" and not radio.stops:
        yield f"ended: {why}, and stop was not sent"
