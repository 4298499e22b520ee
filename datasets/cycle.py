"""The record of one cycle: what went in, what came out, and what was true."""

from dataclasses import dataclass

from control.command import Command, RobotId
from control.formation import ShapeReference
from control.geometry import wrap_angle
from control.plan import PlannedMotion
from control.relative import RelativeState, Vector2
from control.replanning import Answer
from control.unicycle import Twist, UnicycleState
from vision.frame import Frame
from vision.scene import Scene


@dataclass(frozen=True, slots=True)
class Orders:
    """What a person wants at a moment.

    Attributes:
        drive: velocities of the leader, where keys drive it [m/s, rad/s].
        halt: an emergency stop: all robots stop, and stay so.
        arm: motion may begin, or begin again after a stop.
        report: how the loop keeps its time is to be told.
    """

    drive: Twist | None = None
    halt: bool = False
    arm: bool = False
    report: bool = False


NO_ORDERS = Orders()


@dataclass(frozen=True, slots=True)
class Tick:
    """The inputs of one cycle.

    Attributes:
        t: the moment of the cycle, on the capture clock [s].
        frame: the newest frame not yet seen, or None.
        lost_links: robots whose radio link is down.
        orders: of a person.
        answer: of the planner that was asked for another way.
    """

    t: float
    frame: Frame | None = None
    lost_links: tuple[RobotId, ...] = ()
    orders: Orders = NO_ORDERS
    answer: Answer | None = None


@dataclass(frozen=True, slots=True)
class RobotState:
    """Where a robot is believed, or known, to be.

    Attributes:
        robot_id: the robot.
        state: pose and velocities [m, m, rad, m/s, rad/s].
    """

    robot_id: RobotId
    state: UnicycleState


@dataclass(frozen=True, slots=True)
class PairState:
    """A follower as its camera point sees its leader, and as it should.

    Attributes:
        leader: id of the robot followed.
        follower: id of the robot that follows.
        relative: predicted relative state when the command takes effect [m, rad, rad].
        reference: wanted distance and bearing with derivatives [m, rad, per s, per s^2].
    """

    leader: RobotId
    follower: RobotId
    relative: RelativeState
    reference: ShapeReference

    @property
    def error(self) -> Vector2:
        """e_1 of (11): of distance and bearing; NaN for a bearing nobody wants [m, rad]."""
        turn = wrap_angle(self.reference.bearing - self.relative.bearing)
        return self.reference.distance - self.relative.distance, turn


@dataclass(frozen=True, slots=True)
class SafetyEvent:
    """Something the safety rules acted on.

    Attributes:
        t: when [s].
        kind: "robot-stopped", "robot-free", "kept-apart", "camera-silent", "camera-back",
            "emergency-stop", "armed", "way-blocked" or "way-free".
        robot_id: whom it concerns, None for all.
        detail: one sentence with the numbers.
    """

    t: float
    kind: str
    robot_id: RobotId | None
    detail: str


@dataclass(frozen=True, slots=True)
class Cycle:
    """The outcome of one cycle.

    Attributes:
        t: the moment of the cycle [s].
        t_effective: when its commands reach the wheels [s].
        phase: "idle", "armed", "running", "holding", "stopped" (emergency stop), "finished" or
            "given-up" (for good, by the safety rules).
        t_start: when the mission's clock started [s], None before.
        scene: what was seen, None without a new frame.
        robots: predicted states at t_effective.
        pairs: one per follower, two where it follows two; leaders first.
        planned: wanted motion of the formation's leader at t_effective, None before the start.
        commands: to be sent now.
        events: what the safety rules did in this cycle.
        notes: what else is worth telling, e.g. the initial rates and their spread.
    """

    t: float
    t_effective: float
    phase: str
    t_start: float | None
    scene: Scene | None
    robots: tuple[RobotState, ...]
    pairs: tuple[PairState, ...]
    planned: PlannedMotion | None
    commands: tuple[Command, ...]
    events: tuple[SafetyEvent, ...] = ()
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Timing:
    """Computing time spent in one cycle.

    Attributes:
        vision: finding the robots in the frame [s], 0 without a frame.
        step: the whole step, frame to commands [s].
        frame_to_command: from the frame's hand-over until its commands are with the radio [s].
        late: after its beat the cycle began [s].
    """

    vision: float
    step: float
    frame_to_command: float
    late: float = 0.0


@dataclass(frozen=True, slots=True)
class Moment:
    """All that observers (recorder, viewer, scores) learn of one cycle.

    Attributes:
        tick: the inputs.
        cycle: the outcome.
        truth: true states at tick.t, empty where nobody knows.
        timing: what it cost.
    """

    tick: Tick
    cycle: Cycle
    truth: tuple[RobotState, ...]
    timing: Timing
