"""How a radio's links are doing: one type for all kinds of radio, a value others can read."""

from dataclasses import dataclass

from control.command import RobotId
from pipeline.radios.miabot_text import EncoderCounts

SIMULATED = "simulated"
"""The place of a link that is simulated."""


@dataclass(frozen=True, slots=True)
class LinkCounts:
    """What became of the messages of one link.

    Attributes:
        sent: written to the link.
        replaced: overtaken by a newer one before the budget allowed them.
        stale: older than their valid_until when their turn came, not sent.
        connects: times the link came up.
        failures: times it went down or could not be opened.
        rate: messages sent during the last second [1/s].
        silences: times the robots were stopped because no command had come for too long.
        lost: messages known to have been lost on the way; 0 where nobody knows.
        doubled: messages known to have arrived twice; 0 where nobody knows.
    """

    sent: int = 0
    replaced: int = 0
    stale: int = 0
    connects: int = 0
    failures: int = 0
    rate: float = 0.0
    silences: int = 0
    lost: int = 0
    doubled: int = 0


@dataclass(frozen=True, slots=True)
class RoundTrip:
    """How long a robot's answers took, from writing the question to reading the answer.

    Attributes:
        asked: questions that were answered or given up.
        unanswered: of these, given up after half a second.
        p50: median of the last answers [s]; None before the first.
        longest: of the whole run [s]; None before the first.
    """

    asked: int
    unanswered: int
    p50: float | None
    longest: float | None

    @property
    def loss(self) -> float | None:
        """Share of the questions that were not answered; None before the first outcome."""
        return self.unanswered / self.asked if self.asked else None


@dataclass(frozen=True, slots=True)
class RobotReport:
    """How one robot's link is doing.

    Attributes:
        robot_id: the robot.
        place: its port or address.
        up: whether the link is connected.
        error: why not, None if it is.
        counts: what became of the messages; robots on one link share them.
        garbage: bytes received that were no known reply.
        foreign: replies that name another robot.
        round_trip: None where robots do not answer.
        encoders: the latest counts; None where there are none.
    """

    robot_id: RobotId
    place: str
    up: bool
    error: str | None
    counts: LinkCounts
    garbage: int = 0
    foreign: int = 0
    round_trip: RoundTrip | None = None
    encoders: EncoderCounts | None = None
