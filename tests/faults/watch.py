"""An observer who knows the truth and what is wrong, and watches whether the promises hold."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from math import inf, isfinite

from control.command import Command, RobotId
from control.formation import Pair
from control.geometry import wrap_angle
from control.relative import relative_state
from control.unicycle import UnicycleState
from datasets.bodies import least_gap
from datasets.cycle import Moment
from pipeline.setup import Setup
from tests.faults.promises import BLOCKED, CLOSED, MOTORS, OWN_TIMEOUT, Duty, not_told, still
from tests.faults.schedule import Fault
from tests.faults.world import Floor

SLOW, SLOW_TURN = 0.03, 0.3  # below which a robot stands [m/s, rad/s]
NEAR, NEAR_TURN = 0.02, 0.1  # below which a follower is in its place [m, rad]
RUNS_AGAIN = 1.5  # after the last fault the formation drives again, at the latest [s]
SAME = 0.1  # between two moments at which the same is broken [s]
FORMED_AGAIN = 10.0  # and is in formation, at the latest [s]


@dataclass(slots=True)
class Record:
    """What became of one fault.

    Attributes:
        fault: it.
        stood: from its beginning until all stood who had to [s]; None if nobody had to.
        ran: from its end until the formation drove again [s]; None if something else came first.
        formed: from its end until it was in formation again [s]; None likewise.
        gap: least distance between two bodies from its beginning to the next one's [m].
    """

    fault: Fault
    stood: float | None = None
    ran: float | None = None
    formed: float | None = None
    gap: float = inf


@dataclass
class Watch:
    """Watches one run.

    Attributes:
        setup: of the run.
        faults: what goes wrong in it.
        floor: who is in somebody's hand.
        broken: promises that were not kept.
        records: of the faults that have begun.
    """

    setup: Setup
    faults: Sequence[Fault]
    floor: Floor
    broken: list[str] = field(default_factory=list)
    records: list[Record] = field(default_factory=list)
    _last: dict[str, float] = field(default_factory=dict)
    _told: tuple[Duty, ...] = ()
    _still: tuple[Duty, ...] = ()

    def __post_init__(self) -> None:
        self._told = not_told(self.faults, self.setup)
        self._still = still(self.faults, self.setup)

    def observe(self, moment: Moment) -> None:
        """Look at one cycle.

        Args:
            moment: it, with the truth.
        """
        t = moment.tick.t
        states = {s.robot_id: s.state for s in moment.truth}
        self._begin(t)
        for command in moment.cycle.commands:
            self._judge_command(command, t)
        self.judge_motion(t, states)
        if self.records:
            self._recover(moment, states)

    def close(self) -> None:
        """Go home."""

    def judge_motion(self, t: float, states: dict[RobotId, UnicycleState]) -> None:
        """Look at the robots on the floor.

        Args:
            t: now [s].
            states: true ones.
        """
        on_floor = {r: s for r, s in states.items() if r not in self.floor.lifted}
        moving = {r for r, s in on_floor.items() if abs(s.v) > SLOW or abs(s.omega) > SLOW_TURN}
        for duty in self._still:
            if duty.begins <= t < duty.ends:
                for robot in sorted(moving & duty.robots - self._deaf(t), key=str):
                    self._break(t, f"robot {robot} moves", f"at {states[robot].v:.3f} m/s")
        poses = [(s.x, s.y, s.theta) for s in on_floor.values()]
        gap = least_gap(poses, self.setup.tags.tags[0].side)
        if gap < 0.0:
            self._break(t, "two bodies overlap", f"by {-1e3 * gap:.1f} mm")
        if self.records:
            self.records[-1].gap = min(self.records[-1].gap, gap)
        for record in self.records:
            self._note_standing(record, t, moving)

    def _begin(self, t: float) -> None:
        while len(self.records) < len(self.faults) and t >= self.faults[len(self.records)].begins:
            self.records.append(Record(self.faults[len(self.records)]))

    def _judge_command(self, command: Command, t: float) -> None:
        robot, twist = command.robot_id, command.twist
        if not (isfinite(twist.v) and isfinite(twist.omega)):
            self._break(t, f"robot {robot} is sent {twist}")
        if command.valid_until < t:
            self._break(t, f"robot {robot} is sent a stale command")
        if twist.v or twist.omega:
            for duty in self._told:
                if duty.begins <= t < duty.ends and robot in duty.robots:
                    self._break(t, f"robot {robot} is told to move", f"at {twist.v:.3f} m/s")

    def _deaf(self, t: float) -> set[RobotId | None]:
        """Robots whose link is down or was: what they were told they may not have heard."""
        links = (f for f in self.faults if f.kind in (CLOSED, BLOCKED))
        later = OWN_TIMEOUT + MOTORS
        return {f.robot for f in links if f.begins <= t < min(f.begins + later, f.ends + MOTORS)}

    def _note_standing(self, record: Record, t: float, moving: set[RobotId]) -> None:
        """When all stood who had to, for as long as the fault lasts."""
        if record.stood is None and record.fault.lasts(t) and not moving & self._concerned(record):
            record.stood = t - record.fault.begins

    def _concerned(self, record: Record) -> frozenset[RobotId]:
        fault = record.fault
        if fault.robot is not None and fault.kind == BLOCKED:
            return frozenset((fault.robot,))
        duties = not_told((fault,), self.setup)
        return duties[0].robots if duties else frozenset(self.setup.formation.robots)

    def _recover(self, moment: Moment, states: dict[RobotId, UnicycleState]) -> None:
        """After the last fault: when the formation drives again, and is in formation again."""
        t, cycle, record = moment.tick.t, moment.cycle, self.records[-1]
        since = t - max(r.fault.ends for r in self.records)
        if since < 0.0 or cycle.t_start is None:
            return
        if record.ran is None and cycle.phase == "running":
            record.ran = since
        if record.ran is None and since > RUNS_AGAIN and cycle.phase not in ("given-up",):
            record.ran = since
            self._break(t, f"{cycle.phase} still", f"{since:.2f} s after the last fault")
        errors = tuple(self._errors(states, t - cycle.t_start))
        away = any(e > NEAR or turn > NEAR_TURN for e, turn in errors)
        if away:
            record.formed = None
            if since > FORMED_AGAIN:
                self._break(t, "not in formation", f"{since:.1f} s after it: {errors}")
        elif record.formed is None:
            record.formed = since

    def _errors(
        self, states: dict[RobotId, UnicycleState], t: float
    ) -> Iterator[tuple[float, float]]:
        """Distance [m] and bearing [rad] that every follower is off."""
        for pair in self.setup.formation.pairs:
            yield self._error(pair, states, t)

    def _error(
        self, pair: Pair, states: dict[RobotId, UnicycleState], t: float
    ) -> tuple[float, float]:
        offset, wanted = self.setup.follower.camera_offset, pair.shape.at(t)
        seen = relative_state(states[pair.leader].pose, states[pair.follower].pose, offset)
        turn = wrap_angle(wanted.bearing - seen.bearing)
        return abs(wanted.distance - seen.distance), abs(turn) if isfinite(turn) else 0.0

    def _break(self, t: float, what: str, number: str = "") -> None:
        """Note what is broken, once as long as it stays so."""
        if t - self._last.get(what, -inf) > SAME:
            lasting = ", ".join(r.fault.kind for r in self.records[-2:]) or "nothing"
            self.broken.append(f"{t:.3f} s: {what} {number} ({lasting})")
        self._last[what] = t
