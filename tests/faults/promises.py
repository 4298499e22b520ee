"""What must hold while something is wrong: who may not be told to move, who stands, and when."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from control.command import RobotId
from control.formation import Formation
from pipeline.setup import Setup
from tests.faults.schedule import CAMERA, ENDS, HOST, ROBOT, Fault

COVERED, TAKEN, CLOSED, BLOCKED = ROBOT
UNPLUGGED, FROZEN, STEPPED = CAMERA
STALLED, EMERGENCY = HOST
SIGTERM, SIGKILL = ENDS

MOTORS = 0.3  # that robots need to stand once they are told to: six lags [s]
OWN_TIMEOUT = 0.3  # of the robots [s]
PICTURES = 0.08  # from a moment to the frame that shows it, at most [s]


@dataclass(frozen=True, slots=True)
class Duty:
    """Robots that must stand for a while.

    Attributes:
        robots: who.
        begins: from when on [s].
        ends: until when [s].
    """

    robots: frozenset[RobotId]
    begins: float
    ends: float


def not_told(faults: Sequence[Fault], setup: Setup) -> tuple[Duty, ...]:
    """Who may not be told to move, and when.

    Args:
        faults: of the run.
        setup: its rules and formation.

    Returns:
        The duties of docs/safety.md; none of a fault that ends before it takes effect.
    """
    every = (_not_told(fault, faults, setup) for fault in faults)
    return tuple(duty for duty in every if duty is not None and duty.begins < duty.ends)


def still(faults: Sequence[Fault], setup: Setup) -> tuple[Duty, ...]:
    """Who really stands, and when: the motors' time after they were told, or by themselves.

    Args:
        faults: of the run.
        setup: its rules and formation.

    Returns:
        The duties.
    """
    told = (replace(duty, begins=duty.begins + MOTORS) for duty in not_told(faults, setup))
    every = (*told, *_by_themselves(faults, setup))
    return tuple(duty for duty in every if duty.begins < duty.ends)


def led_by(formation: Formation, robot: RobotId) -> frozenset[RobotId]:
    """A robot and all that follow it.

    Args:
        formation: who follows whom.
        robot: of it.

    Returns:
        The robots.
    """
    found = {robot}
    for pair in formation.pairs:  # leaders first
        if pair.leader in found:
            found.add(pair.follower)
    return frozenset(found)


def _not_told(fault: Fault, faults: Sequence[Fault], setup: Setup) -> Duty | None:
    rules, tick = setup.rules, 1.5 * setup.period
    everybody = frozenset(setup.formation.robots)
    concerned = everybody if fault.robot is None else led_by(setup.formation, fault.robot)
    begins, ends = fault.begins + tick, fault.ends
    if fault.kind in (COVERED, TAKEN, STEPPED):
        begins += rules.stop_after
    elif fault.kind in (UNPLUGGED, FROZEN):
        begins += rules.camera_silent
        ends += rules.good_frames if begins + PICTURES < ends else 0.0
    elif fault.kind == CLOSED:
        begins += setup.period
    elif fault.kind == STALLED:
        ends += rules.good_frames
    elif fault.kind == EMERGENCY:
        ends = min(f.ends for f in faults if f.kind == EMERGENCY and f.ends > fault.begins)
    elif fault.kind in (BLOCKED, SIGKILL):
        return None  # nobody knows, or nobody is there who could
    return Duty(concerned, begins, ends)


def _by_themselves(faults: Sequence[Fault], setup: Setup) -> Iterator[Duty]:
    """Robots that hear nothing stop by themselves."""
    for fault in faults:
        begins = fault.begins + OWN_TIMEOUT + MOTORS
        if fault.kind in (CLOSED, BLOCKED) and fault.robot is not None:
            yield Duty(frozenset((fault.robot,)), begins, fault.ends)
        if fault.kind in (STALLED, SIGKILL):
            yield Duty(frozenset(setup.formation.robots), begins, fault.ends)
