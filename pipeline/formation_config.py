"""The section [formation] of a scenario: pairs one by one, or a shape for all followers."""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from pipeline.section import Finite, Identifier, NonNegative, Positive, Section

Angle = Annotated[float, Field(ge=-180, le=180)]


class StepConfig(Section):
    """A value that changes once: (before + after)/2 + (after - before)/2 tanh(rate (t - at))."""

    before_m: Positive
    after_m: Positive
    at_s: NonNegative
    rate_per_s: Positive = 10.0


class PairConfig(Section):
    """A follower and its leader: distance and bearing (7), or a distance to each of two leaders."""

    leader: Identifier
    follower: Identifier
    distance_m: Positive | StepConfig
    bearing_deg: Angle | None = None


class ShapeConfig(Section):
    """Places of all followers about the formation's leader: a named shape, or a list.

    Places are of camera points, x forward and y left of the middle of the leader's axle.
    """

    shape: Literal["line", "column", "wedge", "circle"] | None = None
    spacing_m: Positive | None = None
    half_angle_deg: Annotated[float, Field(gt=0, lt=180)] = 45.0
    leader_at: Literal["centre", "rim"] = "centre"
    places_m: tuple[tuple[Finite, Finite], ...] | None = Field(default=None, min_length=1)

    @property
    def given(self) -> bool:
        """Whether it says any places."""
        return self.shape is not None or self.places_m is not None

    @model_validator(mode="after")
    def _named_or_listed(self) -> Self:
        if (self.shape is None) != (self.spacing_m is None):
            raise ValueError("a shape goes with spacing_m")
        if self.shape is not None and self.places_m is not None:
            raise ValueError("give either shape and spacing_m, or places_m")
        return self


class ChangeConfig(ShapeConfig):
    """A change to another shape: it begins at a time and lasts for one."""

    at_s: NonNegative
    duration_s: Positive = 2.0

    @model_validator(mode="after")
    def _to_somewhere(self) -> Self:
        if not self.given:
            raise ValueError("a change needs shape and spacing_m, or places_m")
        return self


class FormationConfig(ShapeConfig):
    """Who follows whom, and where: `pairs`, or a shape about a `leader`.

    `followers` take the places in their order; where nobody says who, they are assigned so that
    no two robots meet on straight ways.
    """

    pairs: tuple[PairConfig, ...] | None = Field(default=None, min_length=1)
    leader: Identifier | None = None
    followers: tuple[Identifier, ...] | None = Field(default=None, min_length=1)
    follow: Literal["leader", "neighbour"] = "leader"
    changes: tuple[ChangeConfig, ...] = ()

    @model_validator(mode="after")
    def _pairs_or_shape(self) -> Self:
        if (self.pairs is None) == (not self.given):
            raise ValueError("give either pairs, or a shape (shape and spacing_m, or places_m)")
        if self.pairs is None and self.leader is None:
            raise ValueError("a shape needs its leader")
        if self.pairs is not None and (self.leader is not None or self.followers or self.changes):
            raise ValueError("leader, followers and changes go with a shape, not with pairs")
        return self

    @property
    def root(self) -> int | str | None:
        """The leader that follows nobody; None if there is none."""
        if self.pairs is None:
            return self.leader
        followers = {pair.follower for pair in self.pairs}
        return next((pair.leader for pair in self.pairs if pair.leader not in followers), None)

    @property
    def robots(self) -> tuple[int | str, ...]:
        """Every robot that is named."""
        if self.pairs is not None:
            return tuple(robot for pair in self.pairs for robot in (pair.leader, pair.follower))
        return (*(() if self.leader is None else (self.leader,)), *(self.followers or ()))
