"""What goes wrong in a mission, and when: drawn at random, from a seed."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from math import inf

import numpy as np

from control.command import RobotId


class Kind(Enum):
    """What can go wrong."""

    UNPLUGGED = "camera unplugged"
    FROZEN = "camera frozen"
    OLD_STAMPS = "camera stamps go back"
    CLOCK_STEP = "clock step"
    COVERED = "robot covered"
    TAKEN = "robot taken away"
    CLOSED = "link closed"
    BLOCKED = "link blocked"
    UNMOVED = "robot does not obey"
    STALLED = "host stalled"
    HALTED = "emergency stop"
    GONE = "camera gone for good"
    SIGTERM = "SIGTERM"
    SIGKILL = "SIGKILL"


LASTS = {
    Kind.UNPLUGGED: (0.1, 4.0),
    Kind.FROZEN: (0.1, 3.0),
    Kind.OLD_STAMPS: (1.5, 3.0),
    Kind.CLOCK_STEP: (0.5, 3.0),
    Kind.COVERED: (0.1, 2.0),
    Kind.TAKEN: (0.6, 3.0),
    Kind.CLOSED: (0.02, 2.0),
    Kind.BLOCKED: (0.02, 2.0),
    Kind.UNMOVED: (0.6, 2.0),
    Kind.STALLED: (1.0, 1.0),
    Kind.HALTED: (0.5, 3.0),
}
"""How long a fault that passes lasts [s]."""

ENDS = (Kind.GONE, Kind.SIGTERM, Kind.SIGKILL)
"""Faults that end a run."""

OF_ROBOTS = (Kind.COVERED, Kind.TAKEN)
UNHEARD = (Kind.CLOSED, Kind.BLOCKED, Kind.UNMOVED)
"""Faults during which a robot hears nothing."""

SIZES = {Kind.OLD_STAMPS: (0.35, 0.9), Kind.CLOCK_STEP: (-3600.0, 3600.0)}
CATCHES_UP = 2.0  # time there is to catch up, per time a leader may have driven on alone [1]
PAIRS = 0.35  # share of the faults during which another one begins


@dataclass(frozen=True, slots=True)
class Fault:
    """Something that goes wrong.

    Attributes:
        kind: what.
        begin: when [s].
        end: when it has passed; infinite if it ends the run [s].
        robot: whom it concerns, None for all.
        size: by how much stamps are wrong [s].
    """

    kind: Kind
    begin: float
    end: float
    robot: RobotId | None = None
    size: float = 0.0

    def on(self, t: float) -> bool:
        """Tell whether it is on.

        Args:
            t: a moment [s].

        Returns:
            True from its begin until its end.
        """
        return self.begin <= t < self.end


@dataclass(frozen=True, slots=True)
class Script:
    """All that goes wrong in a mission.

    Attributes:
        groups: faults that are on together, in the order of time; the groups are far apart.
    """

    groups: tuple[tuple[Fault, ...], ...]

    @property
    def faults(self) -> Iterator[Fault]:
        """All faults."""
        return (fault for group in self.groups for fault in group)

    def on(self, kinds: Sequence[Kind], t: float, robot: RobotId | None = None) -> Fault | None:
        """The first fault of some kinds that is on.

        Args:
            kinds: of which one is asked for.
            t: the moment [s].
            robot: whom it must concern; None for any.

        Returns:
            The fault, None if there is none.
        """
        for fault in self.faults:
            if fault.kind in kinds and fault.on(t) and robot in (None, fault.robot):
                return fault
        return None


@dataclass(frozen=True, slots=True)
class Plot:
    """What is given when a script is drawn.

    Attributes:
        first: the first group begins between these two [s].
        groups: number of groups of faults.
        rest: between the end of a group and the begin of the next, at least [s].
        robots: who can be covered.
        driven: who has a link; only they can be taken away, or not obey.
        ending: share of the missions whose last fault ends them.
    """

    first: tuple[float, float]
    groups: int
    rest: float
    robots: tuple[RobotId, ...]
    driven: tuple[RobotId, ...]
    ending: float = 0.3


def draw(plot: Plot, rng: np.random.Generator) -> Script:
    """Draw what goes wrong.

    Args:
        plot: what is given.
        rng: decides.

    Returns:
        The script.
    """
    begin, groups = rng.uniform(*plot.first), []
    ends = rng.random() < plot.ending
    for _ in range(plot.groups - ends):
        groups.append(_group(plot, begin, rng))
        end = max(fault.end for fault in groups[-1])
        begin = end + plot.rest + CATCHES_UP * (end - begin) + rng.uniform(0.0, 1.0)
    if ends:
        groups.append((Fault(ENDS[rng.integers(len(ENDS))], begin, inf),))
    return Script(tuple(groups))


def _group(plot: Plot, begin: float, rng: np.random.Generator) -> tuple[Fault, ...]:
    """One fault, or two that overlap."""
    kinds = list(LASTS)
    first, second = (kinds[k] for k in rng.permutation(len(kinds))[:2])
    one = _fault(plot, first, begin, rng)
    if rng.random() >= PAIRS:
        return (one,)
    return one, _fault(plot, second, rng.uniform(one.begin, one.end), rng)


def _fault(plot: Plot, kind: Kind, begin: float, rng: np.random.Generator) -> Fault:
    end, robot = begin + rng.uniform(*LASTS[kind]), None
    if kind in OF_ROBOTS or kind in UNHEARD:
        who = plot.robots if kind is Kind.COVERED else plot.driven
        robot = who[rng.integers(len(who))]
    size = rng.uniform(*SIZES[kind]) if kind in SIZES else 0.0
    return Fault(kind, begin, end, robot, size)
