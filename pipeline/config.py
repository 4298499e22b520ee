"""The scenario file, typed: every key has its unit in its name and its range in its type.

`pipeline.scenario` reads the files, `pipeline.setup` turns a scenario into the objects of a run.
"""

from typing import Annotated, Literal, Self

from pydantic import Field, field_validator, model_validator

from control.laws import law_named
from pipeline.camera_config import CameraConfig
from pipeline.formation_config import FormationConfig
from pipeline.leader_config import LeaderConfig, ObstacleConfig, StartConfig, WayConfig
from pipeline.palette_config import PaletteConfig
from pipeline.radio_config import RadioConfig
from pipeline.section import (
    Colour,
    Finite,
    Identifier,
    NonNegative,
    Period,
    Positive,
    Seconds,
    Section,
    SignedFraction,
    known,
)
from pipeline.sensor_config import SensorConfig
from pipeline.surroundings_config import SurroundingsConfig

PerChannel = tuple[Positive, Positive]


LawName = Annotated[str, known(law_named)]


class PartConfig(Section):
    """A part of a tag layout in the robot's frame, x forward, y left: a polygon or a dot."""

    name: str
    color: str
    polygon_m: tuple[tuple[Finite, Finite], ...] | None = Field(default=None, min_length=3)
    center_m: tuple[Finite, Finite] | None = None
    diameter_m: Positive | None = None

    @model_validator(mode="after")
    def _polygon_or_dot(self) -> Self:
        dot = (self.center_m is not None, self.diameter_m is not None)
        if (self.polygon_m is None) == (not all(dot)) or (self.polygon_m and any(dot)):
            raise ValueError("give either polygon_m, or center_m and diameter_m")
        return self


class LayoutConfig(Section):
    """A tag layout; a part coloured "$name" takes the colour that each robot gives for `name`.

    A pattern gives these colours by a number or a name, `defaults` where nobody else does;
    `colors` are nominal, a scenario's own come first.
    """

    name: str = ""
    side_m: Positive
    mirror_twins: bool = False
    defaults: dict[str, str] = Field(default_factory=dict)
    parts: tuple[PartConfig, ...] = Field(min_length=1)
    colors: dict[str, Colour] = Field(default_factory=dict)
    patterns: dict[str, dict[str, str]] = Field(default_factory=dict)


class TagsConfig(Section):
    """What the robots wear: a layout with colours for all of them, or printed markers."""

    layout: str = "two_patch"
    colors: dict[str, str] = Field(default_factory=dict)
    dictionary: str = "4x4_50"
    marker_m: Positive | None = None
    look_alikes: bool = False


class RobotConfig(Section):
    """One robot: its tag, its drive, and what only the world knows: its errors, who carries it."""

    id: Identifier
    pattern: Identifier | None = None
    marker: Annotated[int, Field(ge=0)] | None = None
    colors: dict[str, str] = Field(default_factory=dict)
    start: StartConfig | None = None
    lag_s: Annotated[float, Field(gt=0, le=1)] = 0.05
    law: LawName | None = None
    mass_error: SignedFraction = 0.0
    inertia_error: SignedFraction = 0.0
    disturbance_mps2: NonNegative = 0.0
    turn_disturbance_radps2: NonNegative = 0.0
    carried: WayConfig | None = None


class ControlConfig(Section):
    """The followers' law, its gains, and what the first-order laws assume of disturbances."""

    law: LawName = "implicit-twisting"
    command_period_s: Period = 0.005
    horizon_s: Annotated[float, Field(gt=0, le=1)] | None = None
    mu: Positive = 20.0
    nu: Positive = 4.0
    proportional: PerChannel = (2.0, 2.0)
    integral: PerChannel = (1.0, 1.0)
    disturbance_mps2: NonNegative = 0.2
    turn_disturbance_radps2: NonNegative = 2.0
    model_error: Annotated[float, Field(ge=0, le=0.7)] = 0.15
    reaching_margin_mps2: Positive = 0.5
    layer_mps: Positive = 0.05
    lipschitz_mps3: Positive = 10.0
    camera_offset_m: Positive = 0.05
    leader_commands_known: bool = False
    speed_limit_mps: Positive = 1.5
    turn_limit_radps: Positive = 15.0

    @model_validator(mode="after")
    def _twisting_order(self) -> Self:
        if self.mu <= self.nu:
            raise ValueError(f"mu ({self.mu}) must be greater than nu ({self.nu})")
        return self


class EstimationConfig(Section):
    """The motion model of the robots' filters, and noise of poses that the fit cannot know."""

    acceleration_std_mps2: Positive = 2.0
    turn_acceleration_std_radps2: Positive = 5.0
    lag_s: Positive | None = None
    pose_std_m: NonNegative = 0.0002
    heading_std_deg: NonNegative = 0.2


class StartUpConfig(Section):
    """How the mission begins: from rest, or by watching moving robots with a differentiator."""

    initial_rates: Literal["rest", "differentiator"] = "rest"
    watch_s: Seconds = 0.5


class SafetyConfig(Section):
    """When robots are slowed and stopped, and how far their bodies are kept apart."""

    slow_after_s: Positive = 0.2
    stop_after_s: Positive = 0.3
    camera_silent_s: Positive = 0.2
    good_frames_s: NonNegative = 1.0
    give_up_s: Positive = 10.0
    hold: bool = False
    drive_ambiguous: bool = False
    unmoved_m: NonNegative = 0.1
    together: bool = False
    clearance_m: NonNegative = 0.02
    approach_rate_per_s: Positive = 8.0
    arena_m: tuple[Finite, Finite, Finite, Finite] | None = None

    @model_validator(mode="after")
    def _slow_before_stop(self) -> Self:
        if self.slow_after_s >= self.stop_after_s:
            raise ValueError("slow_after_s must be less than stop_after_s")
        return self


class SimulationConfig(Section):
    """Errors of the poses that `simulate` puts in the place of a camera's."""

    position_std_m: NonNegative = 0.0005
    heading_std_deg: NonNegative = 0.46


class Scenario(Section):
    """A whole run: camera, tags, robots, formation, path, laws, link and safety.

    Without `formation` and `leader` robots can be looked for and rendered, but not driven.
    """

    name: str
    description: str = ""
    duration_s: Annotated[float, Field(gt=0, le=86400)] = 8.0
    camera: CameraConfig = CameraConfig()
    sensor: SensorConfig = SensorConfig()
    surroundings: SurroundingsConfig = SurroundingsConfig()
    tags: TagsConfig = TagsConfig()
    layouts: dict[str, LayoutConfig] = Field(default_factory=dict)
    colors: dict[str, Colour] = Field(default_factory=dict)
    palette: PaletteConfig | None = None
    robots: tuple[RobotConfig, ...] = Field(min_length=1)
    formation: FormationConfig | None = None
    leader: LeaderConfig | None = None
    obstacles: tuple[ObstacleConfig, ...] = ()
    control: ControlConfig = ControlConfig()
    estimation: EstimationConfig = EstimationConfig()
    startup: StartUpConfig = StartUpConfig()
    radio: RadioConfig = RadioConfig()
    safety: SafetyConfig = SafetyConfig()
    simulation: SimulationConfig = SimulationConfig()

    @property
    def commanded(self) -> tuple[int | str, ...]:
        """Robots that a radio must reach: all but those that a hand moves."""
        by_hand = {o.robot for o in self.obstacles}
        if self.formation and self.leader and self.leader.driven_by == "hand":
            by_hand.add(self.formation.root)
        return tuple(r.id for r in self.robots if not r.carried and r.id not in by_hand)

    @field_validator("robots")
    @classmethod
    def _ids_once(cls, robots: tuple[RobotConfig, ...]) -> tuple[RobotConfig, ...]:
        ids = [robot.id for robot in robots]
        twice = sorted({str(i) for i in ids if ids.count(i) > 1})
        if twice:
            raise ValueError(f"robot id given twice: {', '.join(twice)}")
        return robots

    @model_validator(mode="after")
    def _nobody_drives_the_carried(self) -> Self:
        if self.formation is None or self.leader is None:
            return self
        led = {self.formation.root} if self.leader.driven_by == "hand" else set()
        driven = {*self.formation.robots} - led
        for robot in self.robots:
            if robot.carried and robot.id in driven:
                raise ValueError(
                    f"robot {robot.id} is carried and cannot be driven: let it lead with "
                    'leader.driven_by = "hand", or leave it out of the formation'
                )
        return self

    @model_validator(mode="after")
    def _formation_names_robots(self) -> Self:
        known = {robot.id for robot in self.robots}
        for robot in self.formation.robots if self.formation else ():
            if robot not in known:
                raise ValueError(f"formation names robot {robot}, which is not among the robots")
        return self

    @model_validator(mode="after")
    def _obstacles_for_a_goal(self) -> Self:
        if self.obstacles and not (self.leader and self.leader.goal):
            raise ValueError("obstacles are for a leader with a goal; segments do not mind them")
        driven = set(self.formation.robots) if self.formation else set()
        others = {robot.id for robot in self.robots} - driven
        for o in self.obstacles:
            if o.robot is not None and o.robot not in others:
                raise ValueError(f"obstacle {o.robot} must be a robot outside the formation")
        return self
