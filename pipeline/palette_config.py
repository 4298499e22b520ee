"""The scenario's `[palette]`, typed: colours as the camera shows them."""

from typing import Annotated, Self

from pydantic import Field, model_validator

from pipeline.section import Positive, Section

Level = Annotated[int, Field(ge=0, le=255)]
Pixel = tuple[Level, Level, Level]


class PaletteConfig(Section):
    """What `echelon calibrate colors` writes; all colours as blue, green, red.

    Measured pixels of every colour, of "black" and of "floor"; the prints' colours in one light;
    how much darker and brighter than measured they may appear.
    """

    light: tuple[Positive, Positive] = (0.45, 1.8)
    prints: dict[str, tuple[Positive, Positive, Positive]]
    samples: dict[str, Annotated[tuple[Pixel, ...], Field(min_length=1, max_length=200)]]

    @model_validator(mode="after")
    def _same_names(self) -> Self:
        if self.light[0] > self.light[1]:
            raise ValueError(f"light: {self.light[0]} is above {self.light[1]}")
        odd = set(self.prints) ^ (set(self.samples) - {"black", "floor"})
        if odd:
            raise ValueError(f"{', '.join(sorted(odd))}: need both prints and samples")
        return self
