"""All that a run remembers from one cycle to the next: values, handed in and out."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf

from control.command import RobotId
from control.estimation import Estimate
from control.follower import FollowerMemory
from control.geometry import Pose2D
from control.history import SentCommands
from control.leader import LeaderMemory
from control.plan import Plan
from control.replanning import Question
from control.unicycle import UnicycleState
from pipeline.guard import GuardMemory
from vision.frame import Frame
from vision.light import PALETTE_LIGHT, Light


@dataclass(frozen=True, slots=True)
class Sighting:
    """A robot seen where it cannot have come by itself.

    Attributes:
        t: capture time [s].
        pose: on the floor [m, m, rad].
    """

    t: float
    pose: Pose2D


@dataclass(frozen=True, slots=True)
class Track:
    """What is remembered of one robot.

    Attributes:
        estimate: filtered state at the capture of the last frame that corrected it.
        ahead: that state rolled forward through the commands sent.
        t_ahead: the time of `ahead` [s].
        sent: commands sent to the robot.
        ambiguous: whether it may be another robot that wears the same tag.
        elsewhere: the last sighting that was not believed; None if the last was.
    """

    estimate: Estimate
    ahead: UnicycleState
    t_ahead: float
    sent: SentCommands = field(default_factory=SentCommands)
    ambiguous: bool = False
    elsewhere: Sighting | None = None


@dataclass(frozen=True, slots=True)
class Obedience:
    """Whether a robot does what it is told.

    Attributes:
        t: capture time from which on it has been in one place [s].
        t_seen: capture time of its last sighting [s].
        place: where it is [m, m, rad].
        expected: where its commands should have taken it meanwhile, and how fast it should be.
        until: it has to stand until then [s].
        pause: for which it has to stand the next time [s].
    """

    t: float
    t_seen: float
    place: Pose2D
    expected: UnicycleState
    until: float = -inf
    pause: float = 0.0


@dataclass(frozen=True, slots=True)
class Glimpse:
    """Relative configurations seen in one frame while the robots are watched before the start.

    Attributes:
        t: capture time [s].
        distances: one per pair of the formation [m].
        bearings: one per pair, in (-pi, pi] [rad].
    """

    t: float
    distances: tuple[float, ...]
    bearings: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Mission:
    """How far the run has come.

    Attributes:
        phase: a state of `pipeline.supervisor`.
        t_start: when the mission's clock stood at 0 [s]; None before the start.
        held: how long the formation has been standing by the safety rules [s].
        glimpses: what was seen while watching.
    """

    phase: str = "idle"
    t_start: float | None = None
    held: float = 0.0
    glimpses: tuple[Glimpse, ...] = ()


@dataclass(frozen=True, slots=True)
class Laws:
    """Memories of the control laws; a law that does not run has none.

    Attributes:
        leader: of the formation's leader.
        followers: by robot.
        kept: when each robot was last kept off other bodies [s].
    """

    leader: LeaderMemory | None = None
    followers: Mapping[RobotId, FollowerMemory] = field(default_factory=dict)
    kept: Mapping[RobotId, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Route:
    """The leader's plan, where it is renewed on the way.

    Attributes:
        plan: the newest one; None: that of the setup.
        clearance: that the newest one was made with; None: that of the setup [m].
        before: what is driven until the newest begins; None: it has begun.
        question: to be asked of the planner now.
        asked: when the last one was [s].
        blocked: all stand, until there is another way or this one is free.
        refused: the last answer was that there is none.
    """

    plan: Plan | None = None
    clearance: float | None = None
    before: Plan | None = None
    question: Question | None = None
    asked: float = -inf
    blocked: bool = False
    refused: bool = False


@dataclass(frozen=True, slots=True)
class Memory:
    """The state of the fold over ticks.

    Attributes:
        t: of the last tick [s], None before the first.
        tracks: robots seen so far.
        obedience: of robots that are seen.
        guard: of the safety rules.
        mission: phase and clock.
        route: the leader's plan now.
        laws: integrals of the control laws.
        light: on the robots, as the last scene told it.
        frame: the last that was looked at.
    """

    t: float | None = None
    tracks: Mapping[RobotId, Track] = field(default_factory=dict)
    obedience: Mapping[RobotId, Obedience] = field(default_factory=dict)
    guard: GuardMemory = field(default_factory=GuardMemory)
    mission: Mission = field(default_factory=Mission)
    route: Route = field(default_factory=Route)
    laws: Laws = field(default_factory=Laws)
    light: Light = PALETTE_LIGHT
    frame: Frame | None = None
