"""What all sections of a scenario file share: their base, and numbers with ranges."""

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NonNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Finite = Annotated[float, Field(allow_inf_nan=False)]
Seconds = Annotated[float, Field(ge=0, le=10, allow_inf_nan=False)]
Period = Annotated[float, Field(ge=0.001, le=1, allow_inf_nan=False)]
Fraction = Annotated[float, Field(ge=0, lt=1, allow_inf_nan=False)]
SignedFraction = Annotated[float, Field(gt=-1, lt=1, allow_inf_nan=False)]
Pixels = Annotated[int, Field(ge=32, le=8192)]
Colour = Annotated[str, Field(pattern=r"^#[0-9a-fA-F]{6}$")]

Identifier = (
    Annotated[int, Field(ge=0, le=9999)] | Annotated[str, Field(min_length=1, max_length=32)]
)


class Section(BaseModel):
    """Base of all sections: unknown keys are errors, values do not change after loading."""

    model_config = ConfigDict(extra="forbid", frozen=True)
