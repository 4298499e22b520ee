"""The [camera] section of a scenario: where the camera hangs and what it delivers."""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from pipeline.section import Finite, Fraction, NonNegative, Pixels, Positive, Seconds, Section


class LensConfig(Section):
    """A calibrated lens: OpenCV's model, for images of one size."""

    size_px: tuple[Pixels, Pixels]
    focal_px: tuple[Positive, Positive]
    center_px: tuple[Finite, Finite]
    distortion: tuple[Finite, Finite, Finite, Finite, Finite] = (0.0, 0.0, 0.0, 0.0, 0.0)


class FloorConfig(Section):
    """Where a calibrated camera sees the floor frame: Rodrigues rotation and translation."""

    rotation_rad: tuple[Finite, Finite, Finite]
    translation_m: tuple[Finite, Finite, Finite]


class DeviceConfig(Section):
    """What a camera at this machine is asked to hold still; what is not named stays as it is."""

    pixel_format: Annotated[str, Field(pattern=r"^[A-Za-z0-9]{3,4}$")] | None = None
    exposure_ms: Annotated[float, Field(gt=0, le=10_000)] | Literal["auto"] | None = None
    gain: int | Literal["auto"] | None = None
    focus: int | Literal["auto"] | None = None
    white_balance_k: Annotated[int, Field(ge=1000, le=20_000)] | Literal["auto"] | None = None
    power_line_hz: Literal[0, 50, 60, "auto"] | None = None
    constant_rate: bool | None = None


class CameraConfig(Section):
    """Where the camera hangs and what it delivers.

    A calibrated `lens` and `floor` win over field width, centre, mount height and distortion, which
    describe an ideal camera that looks straight down. A lens alone leaves the floor unknown. What
    lies outside the polygon `field_px` is not searched. `repeats` says what makes a picture the one
    before: its pixels, or, where a strong codec makes still scenes so, a stamp that stands still.
    """

    width_px: Pixels = 320
    height_px: Pixels = 240
    fps: Annotated[float, Field(ge=1, le=1000)] = 30.0
    field_width_m: Positive = 2.4
    center_m: tuple[Finite, Finite] = (0.0, 0.0)
    mount_height_m: Positive = 2.5
    tag_height_m: NonNegative = 0.075
    distortion: tuple[Finite, Finite, Finite, Finite, Finite] = (0.0, 0.0, 0.0, 0.0, 0.0)
    latency_s: Seconds = 0.040
    stamp_jitter_s: Annotated[float, Field(ge=0, le=0.1)] = 0.0
    dropped_share: Fraction = 0.0
    repeated_share: Fraction = 0.0
    repeats: Literal["pixels", "stamps"] = "pixels"
    device: DeviceConfig = DeviceConfig()
    other_sizes: Literal["refuse", "scale"] = "refuse"
    lens: LensConfig | None = None
    floor: FloorConfig | Literal["unknown"] | None = None
    tag_px: Positive | None = None
    field_px: tuple[tuple[Finite, Finite], ...] | None = Field(default=None, min_length=3)

    @property
    def floor_known(self) -> bool:
        """Whether pixels can be turned into metres."""
        return self.floor != "unknown" and (self.lens is None or self.floor is not None)

    @model_validator(mode="after")
    def _one_whole_camera(self) -> Self:
        if self.lens is None and self.tag_height_m >= self.mount_height_m:
            raise ValueError("tag_height_m must be below mount_height_m")
        if isinstance(self.floor, FloorConfig) and self.lens is None:
            raise ValueError("camera.floor is measured through a lens: give camera.lens, too")
        if self.tag_px is not None and self.floor_known:
            raise ValueError('tag_px is for an unknown floor: say camera.floor = "unknown"')
        return self
