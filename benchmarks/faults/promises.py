"""What is promised for every fault: who stands by when, until when, and when all is right again.

Times are those of docs/safety.md, to which come what no program can change: the tick after, the
radio's delay, and the motors' own time to come to rest.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import inf

from benchmarks.faults.script import CATCHES_UP, UNHEARD, Fault, Kind
from control.command import RobotId
from control.formation import Formation
from pipeline.config import Scenario
from pipeline.obedience import FIRST_PAUSE
from pipeline.radios.link import WRITE_TIMEOUT
from pipeline.setup import Setup

MOTORS = 6.0  # lags: from full speed (1.5 m/s, 15 rad/s) below `STILL` [1]
STILL = 0.005, 0.05  # a robot stands that is slower [m/s, rad/s]
MOVING = 0.02, 0.2  # and moves that is faster [m/s, rad/s]
RESUMES = 0.4  # from when it may move: a frame, its latency, two ticks, and motors [s]
COMES_RIGHT = 6.0  # from when all may move until they are in place: as from the start [s]
LAST_PAUSE = 2.0 * FIRST_PAUSE  # of a robot that did not obey for 2 s [s]
ONE_FRAME = 1.0 / 30.0  # of the missions' cameras [s]
CAMERA = (Kind.UNPLUGGED, Kind.FROZEN, Kind.OLD_STAMPS)
AT_ONCE = (Kind.STALLED, Kind.SIGKILL)


@dataclass(frozen=True, slots=True)
class Stand:
    """Somebody has to stand.

    Attributes:
        robot: who.
        begin: since when the reason is there [s].
        deadline: by when it stands [s].
        until: it stands at least until then [s].
    """

    robot: RobotId
    begin: float
    deadline: float
    until: float


@dataclass(frozen=True, slots=True)
class Promises:
    """What holds in a scenario.

    Attributes:
        setup: with the safety rules.
        timeout: of the robots themselves [s].
        motors: their time to come to rest [s].
        driven: robots that can be told anything.
    """

    setup: Setup
    timeout: float
    motors: float
    driven: tuple[RobotId, ...]

    def stands(self, fault: Fault, others: Iterable[Fault]) -> tuple[Stand, ...]:
        """Who has to stand for a fault.

        Args:
            fault: one.
            others: all that happens; who cannot be told to stand stops by its own timeout.

        Returns:
            One entry per robot.
        """
        others = tuple(others)
        return tuple(
            Stand(
                robot, fault.begin,
                max(fault.begin + wait, *self._by_themselves(robot, fault, wait, others)),
                self.still_until(fault),
            )
            for robot, wait in self._waits(fault).items()
            if robot in self.driven
        )  # fmt: skip

    def still_until(self, fault: Fault, missed: float = 0.0) -> float:
        """Until when those concerned stand.

        Args:
            fault: one.
            missed: how long before and after it no picture came, by chance [s].

        Returns:
            Its end; a second of good frames more after those that make all blind [s].
        """
        blind = fault.kind in (Kind.UNPLUGGED, Kind.FROZEN, Kind.STALLED)
        short = fault.end - fault.begin + missed <= self.setup.rules.camera_silent
        return fault.end + (self.setup.rules.good_frames if blind and not short else 0.0)

    def free_from(self, fault: Fault) -> float:
        """From when on all may move again as far as a fault is concerned.

        Args:
            fault: one.

        Returns:
            The moment; of old stamps, pictures are news again after as long as they are old [s].
        """
        if fault.kind is Kind.UNMOVED:
            return fault.end + LAST_PAUSE
        if fault.kind is not Kind.OLD_STAMPS:
            return self.still_until(fault, ONE_FRAME)
        news = fault.begin + min(fault.size, fault.end - fault.begin)
        return max(fault.end, news + self.setup.rules.good_frames)

    def right_within(self, group: Iterable[Fault]) -> float:
        """How long after that followers may take to come to their places.

        Args:
            group: faults that were on together.

        Returns:
            The time [s].
        """
        left = [self.free_from(f) - f.begin for f in group if self._leaves_behind(f)]
        return COMES_RIGHT + CATCHES_UP * max(left, default=0.0)

    def _leaves_behind(self, fault: Fault) -> bool:
        """Whether the leader drives on while followers stand."""
        root, together = self.setup.formation.root, self.setup.rules.together
        return (fault.robot not in (None, root) and not together) or root not in self.driven

    def _waits(self, fault: Fault) -> Mapping[RobotId, float]:
        """How long after its begin each robot stands; infinite where nothing is promised."""
        rules, formation = self.setup.rules, self.setup.formation
        tick = self.setup.period
        arrives = tick + self.setup.radio_delay + self.motors
        if fault.kind in CAMERA or fault.kind is Kind.GONE:
            return dict.fromkeys(formation.robots, rules.camera_silent + tick + arrives)
        if fault.kind in AT_ONCE:
            return dict.fromkeys(formation.robots, self.alone)
        if fault.kind in (Kind.HALTED, Kind.SIGTERM):
            return dict.fromkeys(formation.robots, arrives)
        if fault.robot is None:
            return {}
        followers = followers_of(formation, fault.robot)
        if fault.kind in UNHEARD:
            noticed = {Kind.CLOSED: 0.0, Kind.BLOCKED: WRITE_TIMEOUT}.get(fault.kind, inf)
            told = dict.fromkeys(followers, noticed + tick + arrives)
            return told | {fault.robot: self.alone}
        return dict.fromkeys((fault.robot, *followers), rules.stop_after + tick + arrives)

    @property
    def alone(self) -> float:
        """From the last command until a robot stands by itself, at the latest [s]."""
        return self.setup.period + self.setup.radio_delay + self.timeout + self.motors

    def _by_themselves(
        self, robot: RobotId, fault: Fault, wait: float, others: Iterable[Fault]
    ) -> tuple[float, ...]:
        """When it stands by itself if nobody can tell it to [s]."""
        mute = [
            other
            for other in others
            if other.kind in AT_ONCE or (other.kind in UNHEARD and other.robot == robot)
        ]
        begin, deadline = fault.begin, fault.begin + wait
        return (
            -inf,
            *(o.begin + self.alone for o in mute if o.begin <= deadline and o.end > begin),
        )


def promises_of(scenario: Scenario, setup: Setup) -> Promises:
    """What is promised in a scenario.

    Args:
        scenario: says how robots stop themselves.
        setup: made of it.

    Returns:
        The promises.
    """
    lag = max(robot.lag_s for robot in scenario.robots)
    timeout = 1e-3 * scenario.radio.timeout_ms
    return Promises(setup, timeout, MOTORS * lag, scenario.commanded)


def followers_of(formation: Formation, robot: RobotId) -> tuple[RobotId, ...]:
    """All that follow a robot, directly or not.

    Args:
        formation: who follows whom.
        robot: the first.

    Returns:
        Their ids.
    """
    found = [robot]
    for pair in formation.pairs:  # leaders first
        if pair.leader in found and pair.follower not in found:
            found.append(pair.follower)
    return tuple(found[1:])
