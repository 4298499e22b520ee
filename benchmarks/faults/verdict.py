"""What became of a mission: measured in the true world, held against the promises."""

import hashlib
from dataclasses import dataclass
from math import inf, isfinite, isnan, nan

import numpy as np

from benchmarks.faults.drive import Driven
from benchmarks.faults.evidence import STOP, Evidence
from benchmarks.faults.promises import MOVING, RESUMES, Stand, promises_of
from benchmarks.faults.script import Fault, Kind
from control.command import Command, RobotId

ROUNDING = 1e-6  # [s]
STEADY = 1.0  # in place again are followers that stay there for so long [s]
WHYS = {Kind.GONE: "given-up", Kind.SIGTERM: "interrupted", Kind.SIGKILL: "killed"}


@dataclass(frozen=True, slots=True)
class Took:
    """How long something took at worst, and how long it might.

    Attributes:
        time: it took; NaN if it had not to happen [s].
        allowed: for it [s].
    """

    time: float = nan
    allowed: float = nan

    def or_worse(self, other: "Took") -> "Took":
        """The one of two that was nearer to its limit, or farther over it.

        Args:
            other: the same thing, another time.

        Returns:
            This or the other one.
        """
        better = self.time - self.allowed >= other.time - other.allowed
        return self if better or isnan(other.time) else other


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of a group of faults.

    Attributes:
        faults: that were on together.
        wheels: until the wheels of somebody who had to stand were no longer driven.
        stands: until somebody stood who had to.
        moves: from when all might move until those who had stood moved again.
        right: from then until all followers were in their places to stay.
        clearance: least distance of two bodies meanwhile [m].
        broken: promises that were, in words.
    """

    faults: tuple[Fault, ...]
    wheels: Took
    stands: Took
    moves: Took
    right: Took
    clearance: float
    broken: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Verdict:
    """What became of a mission.

    Attributes:
        outcomes: of the groups of faults that it met.
        broken: promises that do not belong to a fault, in words.
        end: how long it took [s].
        last_error: worst distance error of a follower at the end; NaN if it ended too soon after
            a fault [m].
        digest: of all that moved.
    """

    outcomes: tuple[Outcome, ...]
    broken: tuple[str, ...]
    end: float
    last_error: float
    digest: str


def judge(driven: Driven) -> Verdict:
    """Hold a mission against the promises.

    Args:
        driven: the mission.

    Returns:
        The verdict.
    """
    court, end = _Court(driven), driven.end + driven.made.setup.period
    met = [group for group in driven.script.groups if group[0].begin <= end]
    horizons = [*(group[0].begin for group in met[1:]), inf]
    outcomes = tuple(court.outcome(*each) for each in zip(met, horizons, strict=True))
    digest = hashlib.sha256(court.evidence.states.tobytes()).hexdigest()[:16]
    broken = (*court.ending(), *court.commands())
    return Verdict(outcomes, broken, driven.end, court.last_error(outcomes), digest)


class _Court:
    """One mission before the promises."""

    def __init__(self, driven: Driven) -> None:
        self._driven, base = driven, driven.made
        self._setup, self._promises = base.setup, promises_of(base.scenario, base.setup)
        self.evidence = Evidence(driven, self._promises.timeout)
        root = self._setup.formation.root
        self._leads = {root} & set(self._promises.driven)

    def outcome(self, group: tuple[Fault, ...], horizon: float) -> Outcome:
        """Judge a group of faults; all is to stay right until the horizon."""
        faults, broken = tuple(self._driven.script.faults), list[str]()
        stands = [s for fault in group for s in self._promises.stands(fault, faults)]
        stands = [stand for stand in stands if stand.until > stand.deadline]
        wheels, stopped = self._stopping(stands, broken)
        free = max(self._promises.free_from(fault) for fault in group)
        moves = right = Took()
        if free < self._driven.end:
            moves = self._moving({stand.robot for stand in stands} | self._leads, free, broken)
            right = self._coming_right(group, free, min(horizon, self._driven.end), broken)
        if all(fault.kind is Kind.CLOCK_STEP for fault in group):
            self._driving_on(group[0].begin, free, broken)
        gap = self.evidence.least_gap(group[0].begin, min(horizon, self.evidence.times[-1]))
        if gap <= 0.0:
            broken.append(f"bodies collide: {1e3 * gap:.1f} mm")
        return Outcome(group, wheels, stopped, moves, right, gap, tuple(broken))

    def ending(self) -> tuple[str, ...]:
        """Whether it ended as it had to, and all stand after it."""
        driven = self._driven
        last = driven.script.groups[-1][0]
        may = {WHYS.get(last.kind, "finished")}
        if last.begin > driven.end - self._setup.rules.camera_silent:
            may.add("finished")  # before it was met or noticed
        broken = [] if driven.why in may else [f"ended by: {driven.why}"]
        for robot in self._promises.driven:
            t = self.evidence.moves_until(robot, driven.end, inf)
            if t > driven.end + self._promises.alone:
                broken.append(f"robot {robot} drives on {t - driven.end:.2f} s after the end")
        if self.evidence.gaps.min() <= 0.0:
            broken.append(
                f"bodies collide at {self.evidence.times[self.evidence.gaps.argmin()]:.2f} s"
            )
        return tuple(broken)

    def commands(self) -> tuple[str, ...]:
        """Whether all commands were finite, and none reached a robot too late."""
        handed = self._driven.handed
        broken = [f"command {c.twist} at {t:.2f} s" for t, c in handed if not _is_finite(c)]
        newest: dict[RobotId, Command] = {}
        coming = iter(handed)
        entry = next(coming, None)
        for sent, robot, twist in sorted(self._driven.watched.told, key=lambda told: told[0]):
            while entry is not None and entry[0] <= sent + 1e-9:
                newest[entry[1].robot_id] = entry[1]
                entry = next(coming, None)
            if twist == STOP:
                continue
            command = newest.get(robot)
            if command is None or command.twist != twist or command.valid_until < sent - 1e-9:
                broken.append(f"robot {robot} was sent an old command at {sent:.2f} s")
        return tuple(broken[:3])

    def last_error(self, outcomes: tuple[Outcome, ...]) -> float:
        """Worst distance error of a follower at the end, if there was time to come right [m]."""
        late = self.evidence.base.times <= self._driven.end
        judged = bool(outcomes) and not isnan(outcomes[-1].right.time)
        return float(self.evidence.errors[late][-1]) if judged else nan

    def _stopping(self, stands: list[Stand], broken: list[str]) -> tuple[Took, Took]:
        """Until the wheels were not driven and the robots stood, at worst."""
        wheels = stopped = Took()
        for s in stands:
            until, allowed = min(s.until, self.evidence.times[-1]), s.deadline - s.begin
            driven = Took(
                self.evidence.driven_until(s.robot, s.begin, s.until) - s.begin,
                allowed - self._promises.motors,
            )
            stood = Took(self.evidence.moves_until(s.robot, s.begin, until) - s.begin, allowed)
            for took, what in ((driven, "is driven"), (stood, "moves")):
                if took.time > took.allowed + ROUNDING:
                    broken.append(f"robot {s.robot} {what} {took.time:.3f} s after "
                                  f"{s.begin:.2f} s, allowed {took.allowed:.3f} s")  # fmt: skip
            if driven.time > 0.0:  # else it stood already
                wheels, stopped = wheels.or_worse(driven), stopped.or_worse(stood)
        return wheels, stopped

    def _moving(self, robots: set[RobotId], free: float, broken: list[str]) -> Took:
        """When all who had stood moved again."""
        worst = Took()
        for robot in sorted(robots, key=str):
            moves = self.evidence.times[
                self.evidence.faster(robot, MOVING) & (self.evidence.times >= free)
            ]
            took = Took(float(moves[0] - free) if len(moves) else inf, RESUMES)
            worst = worst.or_worse(took)
            if took.time > took.allowed:
                broken.append(f"robot {robot} moves {took.time:.2f} s after it may at {free:.2f} s")
        return worst

    def _driving_on(self, begin: float, end: float, broken: list[str]) -> None:
        """Whether the leader drove all the time, as if nothing had happened."""
        inside = (self.evidence.times >= begin) & (
            self.evidence.times < min(end + RESUMES, self._driven.end)
        )
        for robot in self._leads:
            if not self.evidence.faster(robot, MOVING)[inside].all():
                broken.append(f"robot {robot} does not drive on after {begin:.2f} s")

    def _coming_right(
        self, group: tuple[Fault, ...], free: float, horizon: float, broken: list[str]
    ) -> Took:
        """When all were in their places, to stay there until the next fault or change of shape."""
        base = self.evidence.base
        changes = [t for pair in self._setup.formation.pairs for t in pair.shape.changes]
        passed = np.interp(free, base.times, base.mission)
        left = min((t - passed for t in changes if t > passed), default=inf)
        horizon = min(horizon, free + left)
        inside = (base.times >= free) & (base.times < horizon)
        wrong = base.times[inside & ~self.evidence.small]
        allowed = self._promises.right_within(group)
        took = Took(float(wrong[-1] - free) if len(wrong) else 0.0, allowed)
        if horizon - free < min(allowed, took.time + STEADY):
            return Took()  # the time was too short to say it
        if took.time > took.allowed:
            broken.append(f"errors are not small {took.time:.2f} s after {free:.2f} s")
        return took


def _is_finite(command: Command) -> bool:
    return isfinite(command.twist.v) and isfinite(command.twist.omega)
