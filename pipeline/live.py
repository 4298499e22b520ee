"""Turning the crank against a clock: frames in, one step a tick, commands out."""

import gc
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import ceil
from time import perf_counter

from control.command import RobotId
from datasets.cycle import Moment, RobotState, Tick, Timing
from pipeline.memory import Memory
from pipeline.operators.nobody import Nobody
from pipeline.planners.at_once import AtOnce
from pipeline.ports import (
    Clock,
    CommandSink,
    EndOfStream,
    FrameSource,
    Observer,
    Operator,
    Planner,
)
from pipeline.setup import Setup
from pipeline.step import step
from pipeline.supervisor import ENDS
from pipeline.tracking import find_robots
from vision.detector import Detector
from vision.frame import Frame
from vision.light import Light
from vision.locate import Prediction
from vision.scene import Scene

NOBODY: tuple[RobotId, ...] = ()
Truth = Callable[[], tuple[RobotState, ...]]


def nobody_knows() -> tuple[RobotState, ...]:
    """The truth where there is none: real robots.

    Returns:
        Nothing.
    """
    return ()


@dataclass(frozen=True, slots=True)
class Rig:
    """The world a run is connected to.

    Attributes:
        source: where frames come from.
        sink: where commands go.
        clock: the time both share.
        truth: true states of the robots at the present tick.
        observers: who learns of every cycle, in this order.
        operator: the person at the controls.
        planner: finds other ways for the leader.
    """

    source: FrameSource
    sink: CommandSink
    clock: Clock
    truth: Truth = nobody_knows
    observers: Sequence[Observer] = field(default_factory=tuple)
    operator: Operator = field(default_factory=Nobody)
    planner: Planner = field(default_factory=AtOnce)

    def close(self) -> None:
        """Release everything; the radio first, which sends stop. Safe to call twice."""
        self.sink.close()
        self.source.close()
        self.operator.close()
        self.planner.close()
        for observer in self.observers:
            observer.close()


class Stopwatch:
    """`find_robots` with the time it took."""

    def __init__(self) -> None:
        """Start with nothing measured."""
        self.elapsed = 0.0

    def locate(
        self, detector: Detector, frame: Frame, predictions: tuple[Prediction, ...], light: Light
    ) -> Scene:
        """Find the robots, and take the time.

        Args:
            detector: finds the robots.
            frame: the picture.
            predictions: where robots are expected.
            light: on the robots.

        Returns:
            What was found.
        """
        start = perf_counter()
        scene = find_robots(detector, frame, predictions, light)
        self.elapsed = perf_counter() - start
        return scene


def run(
    setup: Setup,
    rig: Rig,
    period: float,
    duration: float | None = None,
    interrupted: Callable[[], bool] = lambda: False,
) -> str:
    """Run until the mission is finished, the time is over, the frames end or someone interrupts.

    However it ends, every robot is told to stop and every observer is closed.

    Args:
        setup: all that is constant in the run.
        rig: camera, radio, clock and observers.
        period: between two ticks [s].
        duration: from the first tick, None: until the mission is finished [s].
        interrupted: asked once a tick.

    Returns:
        Why it ended: "finished", "given-up" (by the safety rules), "time", "frames ended" or
        "interrupted".

    Raises:
        CameraError: if the camera fails.
        RadioError: if the radio fails.
    """
    gc.freeze()  # to look for garbage among what was set up takes 0.15 s: a robot is blind so long
    try:
        return _turn(setup, rig, period, duration, interrupted)
    finally:
        rig.sink.stop(rig.clock.now())
        rig.close()
        gc.unfreeze()


def _turn(
    setup: Setup,
    rig: Rig,
    period: float,
    duration: float | None,
    interrupted: Callable[[], bool],
) -> str:
    """Tick after tick; a tick that is late is not made up for, the next one keeps the beat."""
    memory, origin, count = Memory(), rig.clock.now(), 0
    due, lost = origin, NOBODY
    while not interrupted():
        now = rig.clock.now()
        if duration is not None and now - origin >= duration:
            return "time"
        if memory.t is None or now > memory.t:  # a clock that goes back has nothing new
            try:
                tick = _inputs(rig, now, lost)
            except EndOfStream:
                return "frames ended"
            memory, lost = _cycle(setup, rig, memory, tick, now - due)
        if memory.mission.phase in ENDS:
            return memory.mission.phase
        count = max(count + 1, ceil((rig.clock.now() - origin) / period - 0.5))
        due = origin + count * period
        rig.clock.wait_until(due)
    return "interrupted"


def _inputs(rig: Rig, now: float, lost: tuple[RobotId, ...]) -> Tick:
    """What goes into a cycle; an emergency stop leaves at once."""
    orders = rig.operator.orders(now)
    if orders.halt:
        rig.sink.stop(now)
    return Tick(now, rig.source.latest(now), lost, orders, rig.planner.answer())


def _cycle(
    setup: Setup, rig: Rig, memory: Memory, tick: Tick, late: float
) -> tuple[Memory, tuple[RobotId, ...]]:
    """Step, commands, observers."""
    watch, start = Stopwatch(), perf_counter()
    memory, cycle = step(setup, memory, tick, watch.locate)
    decided = perf_counter()
    lost = rig.sink.send(cycle.commands, tick.t)
    if memory.route.question is not None:
        rig.planner.ask(memory.route.question)
    timing = Timing(watch.elapsed, decided - start, perf_counter() - start, late)
    moment = Moment(tick, cycle, rig.truth(), timing)
    for observer in rig.observers:
        observer.observe(moment)
    return memory, lost
