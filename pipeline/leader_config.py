"""The sections [leader] and [[obstacles]] of a scenario: where the formation goes, and who says."""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from control.laws import leader_law_named
from pipeline.section import Finite, Identifier, NonNegative, Positive, Section, known

LeaderLawName = Annotated[str, known(leader_law_named)]
Driver = Literal["plan", "keys", "hand"]
"""Who moves the leader: its law along a plan, a person at the keys, or a hand that carries it."""


class StartConfig(Section):
    """Where a simulated robot stands at t = 0, and how it moves then."""

    x_m: Finite
    y_m: Finite
    theta_deg: Finite = 0.0
    v_mps: Finite = 0.0
    omega_radps: Finite = 0.0


class SegmentConfig(Section):
    """A piece of the leader's path: a straight line, or an arc (left is positive)."""

    straight_m: Positive | None = None
    radius_m: Positive | None = None
    turn_deg: Finite | None = None

    @model_validator(mode="after")
    def _line_or_arc(self) -> Self:
        arc = (self.radius_m is not None, self.turn_deg is not None)
        if (self.straight_m is None) == (not all(arc)) or (self.straight_m and any(arc)):
            raise ValueError("give either straight_m, or radius_m and turn_deg")
        return self


class WayConfig(Section):
    """A way on the floor, by segments, from a standstill to a standstill."""

    segments: tuple[SegmentConfig, ...] = Field(min_length=1)
    speed_mps: Positive = 0.5
    ramp_s: Positive = 1.0
    begins_s: NonNegative = 0.0


class GoalConfig(Section):
    """Where a planned way ends, at a standstill."""

    x_m: Finite
    y_m: Finite
    heading_deg: Finite = 0.0


class ObstacleConfig(Section):
    """A disc to drive round: about a robot's tag, wherever that is seen, or about a place.

    A place is that of the mission's start, and moves with a constant velocity.
    """

    robot: Identifier | None = None
    x_m: Finite | None = None
    y_m: Finite | None = None
    radius_m: Positive
    vx_mps: Finite = 0.0
    vy_mps: Finite = 0.0

    @model_validator(mode="after")
    def _robot_or_place(self) -> Self:
        place = (self.x_m is not None, self.y_m is not None)
        moves = self.vx_mps or self.vy_mps
        if (self.robot is None) != all(place) or (self.robot is not None and (any(place) or moves)):
            raise ValueError("give either robot, or x_m and y_m (and its velocity)")
        return self


class LeaderConfig(Section):
    """The way of the formation's leader, by segments or planned to a goal, and its tracking law.

    A planned way is driven at `speed_mps` at most; `ramp_s` from there to a standstill is its limit
    of acceleration. Keys drive at `speed_mps` and `turn_radps` at most, with the same limit; a hand
    moves the leader as it likes. Neither uses segments or a goal.
    """

    driven_by: Driver = "plan"
    start: StartConfig | None = None
    speed_mps: Positive = 0.5
    turn_radps: Positive = 2.0
    ramp_s: Positive = 1.0
    segments: tuple[SegmentConfig, ...] | None = Field(default=None, min_length=1)
    goal: GoalConfig | None = None
    proportional: Positive = 8.0
    integral: Positive = 16.0
    reaching_mps2: Positive = 3.0
    point_offset_m: Positive = 0.1
    law: LeaderLawName = "sliding"

    @model_validator(mode="after")
    def _way_for_a_plan(self) -> Self:
        if self.driven_by != "plan":
            return self
        if (self.segments is None) == (self.goal is None):
            raise ValueError("give either segments or goal")
        if self.start is None:
            raise ValueError("start is missing: a plan begins there")
        return self
