"""What a scenario says of its radio: one section for all kinds; each takes what concerns it."""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from pipeline.radios.miabot_line import MiabotSettings
from pipeline.radios.miabot_text import Drive
from pipeline.radios.open import RadioSettings
from pipeline.radios.vsss import Unit, VsssFormat
from pipeline.radios.wheels import Wheels
from pipeline.section import Fraction, Positive, Section


class RadioConfig(Section):
    """The link to the robots, real or simulated (docs/radios.md)."""

    delay_s: Annotated[float, Field(ge=0, le=1)] = 0.005
    loss: Fraction = 0.0
    bandwidth_bytes_per_s: Positive | None = None
    duplication: Fraction = 0.0
    duplicate_delay_s: Annotated[float, Field(ge=0, le=1)] = 0.01
    speed_scale_per_mps: Positive = 1000.0
    track_width_m: Positive = 0.068
    wheel_radius_m: Positive = 0.026
    wheel_limit_mps: Positive = 2.0
    timeout_ms: Annotated[int, Field(ge=50, le=5000)] = 300
    link_bytes_per_s: Annotated[float, Field(ge=100, allow_inf_nan=False)] = 1150.0
    connect_wait_s: Annotated[float, Field(gt=0, le=3600)] = 30.0
    team: Literal["blue", "yellow"] = "blue"
    vsss_unit: Unit = "rad/s"
    vsss_decimals: Annotated[int, Field(ge=0, le=4)] = 2

    @model_validator(mode="after")
    def _unit_not_rounded_away(self) -> Self:
        if self.vsss_unit == "m/s" and self.vsss_decimals < 2:
            raise ValueError('vsss_unit = "m/s" needs vsss_decimals of 2 or more')
        return self


def radio_settings(config: RadioConfig) -> RadioSettings:
    """What the adapters of real radios take from a scenario.

    Args:
        config: its `[radio]` section.

    Returns:
        The settings of all kinds.
    """
    c = config
    drive = Drive(c.speed_scale_per_mps, c.track_width_m)
    return RadioSettings(
        MiabotSettings(drive, c.timeout_ms, c.link_bytes_per_s),
        Wheels(c.track_width_m, c.wheel_radius_m, c.wheel_limit_mps),
        VsssFormat(c.vsss_unit, c.vsss_decimals, c.speed_scale_per_mps),
        c.team == "yellow",
        c.connect_wait_s,
    )
