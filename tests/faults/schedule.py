"""What goes wrong in a run, and when: drawn from a seed."""

import random
from collections.abc import Sequence
from dataclasses import dataclass
from math import inf

from control.command import RobotId

SHORT, LONG = 0.1, 3.0  # that a fault lasts [s]
TOO_LONG = 14.0  # that one lasts which nobody waits out [s]
GAPS = (2.0, 11.0)  # from the end of one to the beginning of the next [s]
FIRST = 3.0  # when the first may begin [s]
PATIENT = 12.0  # what is left after the last one, to be in formation again [s]
OVERLAP = 0.2  # of them begin while another lasts
HOPELESS = 0.03  # of lost cameras stay lost
STALL = 1.0  # of the host [s]

CAMERA = ("camera unplugged", "camera frozen", "camera's clock stepped")
ROBOT = ("robot covered", "robot taken away", "port closed", "port blocked")
HOST = ("host stalled", "emergency stop")
ENDS = ("SIGTERM", "SIGKILL")
KINDS = (*CAMERA, *ROBOT, *HOST, *ENDS)


@dataclass(frozen=True, slots=True)
class Fault:
    """Something that goes wrong.

    Attributes:
        kind: of KINDS.
        begins: when [s].
        ends: when it is over; inf for what ends the run [s].
        robot: whom it concerns, None for all.
        amount: by how much, for a clock that is stepped [s].
    """

    kind: str
    begins: float
    ends: float
    robot: RobotId | None = None
    amount: float = 0.0

    def lasts(self, t: float) -> bool:
        """Whether it goes on.

        Args:
            t: now [s].

        Returns:
            True from its beginning to before its end.
        """
        return self.begins <= t < self.ends


def draw(rng: random.Random, robots: Sequence[RobotId], duration: float) -> tuple[Fault, ...]:
    """Decide what goes wrong in a run.

    Args:
        rng: decides.
        robots: of the formation.
        duration: of the run [s].

    Returns:
        Faults in the order of their beginnings; what ends the run is the last one.
    """
    faults: list[Fault] = []
    t = FIRST + rng.uniform(*GAPS)
    while t < duration - PATIENT:
        fault = _drawn(rng, robots, t)
        faults.append(fault)
        if fault.ends == inf:
            break
        t = fault.ends + rng.uniform(*GAPS)
        if rng.random() < OVERLAP:
            t = rng.uniform(fault.begins, fault.ends)
    return tuple(faults)


def _drawn(rng: random.Random, robots: Sequence[RobotId], t: float) -> Fault:
    kind = rng.choices(KINDS, [1.0] * (len(KINDS) - len(ENDS)) + [0.1] * len(ENDS))[0]
    lasts = rng.uniform(SHORT, LONG)
    if kind in CAMERA:
        hopeless = kind != CAMERA[2] and rng.random() < HOPELESS
        amount = rng.choice((-1.0, 1.0)) * rng.uniform(0.3, 5.0)
        return Fault(kind, t, t + (TOO_LONG if hopeless else lasts), amount=amount)
    if kind in ROBOT:
        return Fault(kind, t, t + lasts, rng.choice(robots))
    if kind in ENDS:
        return Fault(kind, t, inf)
    return Fault(kind, t, t + (STALL if kind == HOST[0] else lasts))
