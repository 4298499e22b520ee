"""What a scenario says of the camera's lens, light and electronics; see docs/scenarios.md."""

from typing import Annotated, Literal

from pydantic import Field

from pipeline.section import Finite, Fraction, NonNegative, Section

Gain = Annotated[float, Field(ge=0, le=100)]


class ExposureChange(Section):
    """From a moment on so much more or less light is collected."""

    at_s: NonNegative
    factor: Gain
    over_s: NonNegative = 0.0


class WhiteBalanceChange(Section):
    """From a moment on the channels have other gains."""

    at_s: NonNegative
    red: Gain = 1.0
    green: Gain = 1.0
    blue: Gain = 1.0
    over_s: NonNegative = 0.0


class SensorConfig(Section):
    """What the camera does to the pixels; the pose fit expects blur, noise and chroma of it."""

    read_noise: Annotated[float, Field(ge=0, le=64)] = 3.0
    blur_px: Annotated[float, Field(ge=0, le=5)] = 0.6
    uneven_light: Fraction = 0.0
    vignetting_power: Annotated[float, Field(ge=0, le=20)] = 0.0
    exposure_s: Annotated[float, Field(ge=0, le=0.1)] = 0.0
    readout_s: Annotated[float, Field(ge=0, le=0.1)] = 0.0
    exposure_changes: tuple[ExposureChange, ...] = ()
    flicker_depth: Annotated[float, Field(ge=0, le=1)] = 0.0
    flicker_hz: Annotated[float, Field(gt=0, le=10000)] = 100.0
    full_well_e: Annotated[float, Field(ge=10, le=1e7)] | None = None
    hot_pixel_share: Fraction = 0.0
    white_balance_changes: tuple[WhiteBalanceChange, ...] = ()
    bayer: Literal["RGGB", "BGGR", "GRBG", "GBRG"] | None = None
    gamma: Annotated[float, Field(ge=0.3, le=4)] = 1.0
    chroma: Literal["444", "422", "420"] = "420"
    chroma_upsampling: Literal["linear", "nearest"] = "linear"
    chroma_offset_px: tuple[Finite, Finite] = (0.0, 0.0)
    jpeg_quality: Annotated[int, Field(ge=1, le=100)] | None = None
