"""What all sections of a scenario file share: their base, and numbers with ranges."""

from collections.abc import Callable
from functools import partial
from typing import Annotated

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from control.errors import ControlError

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


def known(find: Callable[[str], object]) -> AfterValidator:
    """A check that a name can be found.

    Args:
        find: looks it up; raises ControlError if it is unknown.

    Returns:
        For `Annotated`: leaves the name as it is.
    """
    return AfterValidator(partial(_found, find))


def _found(find: Callable[[str], object], name: str) -> str:
    try:
        find(name)
    except ControlError as error:
        raise ValueError(str(error)) from None
    return name


class Section(BaseModel):
    """Base of all sections: unknown keys are errors, values do not change after loading."""

    model_config = ConfigDict(extra="forbid", frozen=True)
