"""What a scenario says of things, shadows and glare around the robots; see docs/scenarios.md."""

from itertools import pairwise
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from pipeline.section import Finite, NonNegative, Positive, Section

Share = Annotated[float, Field(ge=0, le=1)]
Outline = tuple[tuple[Finite, Finite], ...]


class PointConfig(Section):
    """A point of a path, and when it is reached."""

    at_s: NonNegative = 0.0
    x_m: Finite
    y_m: Finite
    theta_deg: Finite = 0.0


class WanderConfig(Section):
    """A seeded way about a place."""

    x_m: Finite
    y_m: Finite
    reach_m: tuple[Positive, Positive]
    speed_mps: NonNegative


class PathConfig(Section):
    """Something that moves: from point to point, or wandering."""

    points: tuple[PointConfig, ...] = ()
    wander: WanderConfig | None = None

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        if bool(self.points) == (self.wander is not None):
            raise ValueError("give either points, or wander")
        times = [point.at_s for point in self.points]
        if any(late <= early for early, late in pairwise(times)):
            raise ValueError("the times of points must ascend")
        return self


class ThingConfig(PathConfig):
    """A flat thing of one colour: on the floor, or above the robots."""

    shape: Literal["hand", "disc", "square", "triangle", "cable", "outline"]
    color: str
    height_m: NonNegative = 0.0
    size_m: Positive = 0.1
    line_m: Outline = ()
    outline_m: Outline = ()
    from_s: NonNegative | None = None
    until_s: NonNegative | None = None

    @model_validator(mode="after")
    def _points_for_its_shape(self) -> Self:
        if self.shape == "cable" and len(self.line_m) < 2:
            raise ValueError('shape "cable" needs line_m, 2 or more points; size_m is its width')
        if self.shape == "outline" and len(self.outline_m) < 3:
            raise ValueError('shape "outline" needs outline_m, 3 or more points')
        return self


class ClutterConfig(Section):
    """Seeded shapes on the floor."""

    count: Annotated[int, Field(ge=0, le=1000)]
    colors: tuple[str, ...] = Field(min_length=1)
    size_m: tuple[Positive, Positive] = (0.02, 0.06)
    moving_share: Share = 0.0
    speed_mps: NonNegative = 0.2

    @model_validator(mode="after")
    def _small_to_large(self) -> Self:
        if self.size_m[0] > self.size_m[1]:
            raise ValueError("size_m goes from the smallest to the largest")
        return self


class ShadowConfig(PathConfig):
    """A round, soft shadow."""

    radius_m: Positive
    softness_m: Positive = 0.1
    darkness: Share = 0.5


class GlareConfig(Section):
    """A lamp's mirror image."""

    x_m: Finite
    y_m: Finite
    width_m: Positive = 0.05
    strength: Annotated[float, Field(ge=0, le=10000)] = 300.0


class SurroundingsConfig(Section):
    """Everything in view that is neither floor nor robot; only the rendered camera sees it."""

    clutter: ClutterConfig | None = None
    things: tuple[ThingConfig, ...] = ()
    shadows: tuple[ShadowConfig, ...] = ()
    glares: tuple[GlareConfig, ...] = ()
