"""The scenario file, typed: every key has its unit in its name and its range in its type.

`pipeline.scenario` reads the files, `pipeline.setup` turns a scenario into the objects of a run.
"""

from typing import Annotated, Literal, Self

from pydantic import Field, ValidationInfo, field_validator, model_validator

from pipeline.config_palette import PaletteConfig
from pipeline.config_section import Positive, Section

NonNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Finite = Annotated[float, Field(allow_inf_nan=False)]
Seconds = Annotated[float, Field(ge=0, le=10, allow_inf_nan=False)]
Period = Annotated[float, Field(ge=0.001, le=1, allow_inf_nan=False)]
Fraction = Annotated[float, Field(ge=0, lt=1, allow_inf_nan=False)]
SignedFraction = Annotated[float, Field(gt=-1, lt=1, allow_inf_nan=False)]
Pixels = Annotated[int, Field(ge=32, le=8192)]
PerChannel = tuple[Positive, Positive]
Colour = Annotated[str, Field(pattern=r"^#[0-9a-fA-F]{6}$")]
Identifier = (
    Annotated[int, Field(ge=0, le=9999)] | Annotated[str, Field(min_length=1, max_length=32)]
)


class CameraConfig(Section):
    """Where the camera hangs and what it delivers."""

    width_px: Pixels = 320
    height_px: Pixels = 240
    fps: Annotated[float, Field(ge=1, le=1000)] = 30.0
    field_width_m: Positive = 2.4
    center_m: tuple[Finite, Finite] = (0.0, 0.0)
    mount_height_m: Positive = 2.5
    tag_height_m: NonNegative = 0.075
    distortion: tuple[Finite, Finite, Finite, Finite, Finite] = (0.0, 0.0, 0.0, 0.0, 0.0)
    latency_s: Seconds = 0.040
    other_sizes: Literal["refuse", "scale"] = "refuse"

    @model_validator(mode="after")
    def _tag_below_camera(self) -> Self:
        if self.tag_height_m >= self.mount_height_m:
            raise ValueError("tag_height_m must be below mount_height_m")
        return self


class SensorConfig(Section):
    """What the camera does to the pixels; the renderer obeys it and the pose fit expects it."""

    read_noise: Annotated[float, Field(ge=0, le=64)] = 3.0
    blur_px: Annotated[float, Field(ge=0, le=5)] = 0.6
    uneven_light: Fraction = 0.0
    chroma: Literal["444", "422", "420"] = "420"
    chroma_upsampling: Literal["linear", "nearest"] = "linear"
    chroma_offset_px: tuple[Finite, Finite] = (0.0, 0.0)
    jpeg_quality: Annotated[int, Field(ge=1, le=100)] | None = None


class PartConfig(Section):
    """A coloured polygon of a tag layout, in the robot's frame: x forward, y left."""

    name: str
    color: str
    polygon_m: tuple[tuple[Finite, Finite], ...] = Field(min_length=3)


class LayoutConfig(Section):
    """A tag layout; a part coloured "$name" takes the colour that each robot gives for `name`."""

    name: str = ""
    side_m: Positive
    parts: tuple[PartConfig, ...] = Field(min_length=1)


class TagsConfig(Section):
    """Which tag layout the robots wear."""

    layout: str = "two_patch"


class StartConfig(Section):
    """Where a simulated robot stands at t = 0, and how it moves then."""

    x_m: Finite
    y_m: Finite
    theta_deg: Finite = 0.0
    v_mps: Finite = 0.0
    omega_radps: Finite = 0.0


class RobotConfig(Section):
    """One robot: its tag, its drive, and the errors of its model that only the world knows."""

    id: Identifier
    colors: dict[str, str] = Field(default_factory=dict)
    start: StartConfig | None = None
    lag_s: Annotated[float, Field(gt=0, le=1)] = 0.05
    mass_error: SignedFraction = 0.0
    inertia_error: SignedFraction = 0.0


class StepConfig(Section):
    """A value that changes once: (before + after)/2 + (after - before)/2 tanh(rate (t - at))."""

    before_m: Positive
    after_m: Positive
    at_s: NonNegative
    rate_per_s: Positive = 10.0


class PairConfig(Section):
    """A follower, its leader and the wanted shape; bearing in the convention of equation (7)."""

    leader: Identifier
    follower: Identifier
    distance_m: Positive | StepConfig
    bearing_deg: Annotated[float, Field(ge=-180, le=180)]


class FormationConfig(Section):
    """The tree of leader-follower pairs."""

    pairs: tuple[PairConfig, ...] = Field(min_length=1)


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


class LeaderConfig(Section):
    """The planned path of the formation's leader and its tracking law."""

    start: StartConfig
    speed_mps: Positive = 0.5
    ramp_s: Positive = 1.0
    segments: tuple[SegmentConfig, ...] = Field(min_length=1)
    proportional: Positive = 8.0
    integral: Positive = 16.0
    reaching_mps2: Positive = 3.0
    point_offset_m: Positive = 0.1


class ControlConfig(Section):
    """The law of the followers, (24)-(27): proportional K, integral L."""

    law: Literal["implicit-twisting", "sampled-twisting"] = "implicit-twisting"
    command_period_s: Period = 0.005
    horizon_s: Annotated[float, Field(gt=0, le=1)] | None = None
    mu: Positive = 20.0
    nu: Positive = 4.0
    proportional: PerChannel = (2.0, 2.0)
    integral: PerChannel = (1.0, 1.0)
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


class RadioConfig(Section):
    """The link to the robots, real or simulated."""

    delay_s: Annotated[float, Field(ge=0, le=1)] = 0.005
    loss: Fraction = 0.0
    bandwidth_bytes_per_s: Positive | None = None
    speed_scale_per_mps: Positive = 1000.0
    track_width_m: Positive = 0.068
    timeout_ms: Annotated[int, Field(ge=50, le=5000)] = 300


class SafetyConfig(Section):
    """When robots are slowed and stopped."""

    slow_after_s: Positive = 0.2
    stop_after_s: Positive = 0.3
    camera_silent_s: Positive = 0.2
    good_frames_s: NonNegative = 1.0
    give_up_s: Positive = 10.0

    @model_validator(mode="after")
    def _slow_before_stop(self) -> Self:
        if self.slow_after_s >= self.stop_after_s:
            raise ValueError("slow_after_s must be less than stop_after_s")
        return self


class Scenario(Section):
    """A whole run: camera, tags, robots, formation, path, laws, link and safety."""

    name: str
    description: str = ""
    duration_s: Annotated[float, Field(gt=0, le=86400)] = 8.0
    camera: CameraConfig = CameraConfig()
    sensor: SensorConfig = SensorConfig()
    tags: TagsConfig = TagsConfig()
    layouts: dict[str, LayoutConfig] = Field(default_factory=dict)
    colors: dict[str, Colour] = Field(default_factory=dict)
    palette: PaletteConfig | None = None
    robots: tuple[RobotConfig, ...] = Field(min_length=1)
    formation: FormationConfig
    leader: LeaderConfig
    control: ControlConfig = ControlConfig()
    estimation: EstimationConfig = EstimationConfig()
    startup: StartUpConfig = StartUpConfig()
    radio: RadioConfig = RadioConfig()
    safety: SafetyConfig = SafetyConfig()

    @field_validator("palette")
    @classmethod
    def _palette_of_these_colors(
        cls, palette: PaletteConfig | None, info: ValidationInfo
    ) -> PaletteConfig | None:
        known = {"black", "floor", *info.data.get("colors", {})}
        strange = sorted(set(palette.samples) - known) if palette else []
        if strange:
            colors = ", ".join(info.data.get("colors", {}))
            raise ValueError(f"{', '.join(strange)}: not among the scenario's colours: {colors}")
        return palette

    @field_validator("robots")
    @classmethod
    def _ids_once(cls, robots: tuple[RobotConfig, ...]) -> tuple[RobotConfig, ...]:
        ids = [robot.id for robot in robots]
        twice = sorted({str(i) for i in ids if ids.count(i) > 1})
        if twice:
            raise ValueError(f"robot id given twice: {', '.join(twice)}")
        return robots

    @model_validator(mode="after")
    def _pairs_name_robots(self) -> Self:
        known = {robot.id for robot in self.robots}
        for pair in self.formation.pairs:
            for robot in (pair.leader, pair.follower):
                if robot not in known:
                    raise ValueError(
                        f"formation names robot {robot}, which is not among the robots"
                    )
        return self
