"""Sharpness, noise and colour sampling of a camera."""

from dataclasses import dataclass
from math import hypot

from vision.errors import VisionError

_SUBSAMPLINGS = ("444", "422", "420")
_UPSAMPLINGS = ("linear", "nearest")
_PIXEL = 12**-0.5  # standard deviation of its width
_MIXED_SHARE = ((1.0 + 36.0 + 1.0) / 64.0) ** 2  # what mixing along both axes leaves of the noise


@dataclass(frozen=True, slots=True)
class ChromaModel:
    """How the camera or codec samples colour.

    Chroma is always read as means of 2 x 2 pixels, which undoes nearest-neighbour upsampling.

    Attributes:
        subsampling: "444", "422" or "420".
        offset_px: x, y by which the picture's colours lie right of and below its brightness; (0, 0)
            where a colour sample is sited in the middle of its pixels.
        upsampling: how the decoder fills in colours: "linear" or "nearest".

    Raises:
        VisionError: if the subsampling or upsampling is another.
    """

    subsampling: str = "420"
    offset_px: tuple[float, float] = (0.0, 0.0)
    upsampling: str = "linear"

    def __post_init__(self) -> None:
        if self.subsampling not in _SUBSAMPLINGS or self.upsampling not in _UPSAMPLINGS:
            raise VisionError(
                f"chroma {self.subsampling}, {self.upsampling}: know "
                f"{', '.join(_SUBSAMPLINGS)} and {', '.join(_UPSAMPLINGS)}"
            )

    @property
    def mixed(self) -> bool:
        """Whether upsampling mixes neighbouring means of 2 x 2 pixels 1 : 6 : 1."""
        return self.upsampling == "linear" and self.subsampling != "444"

    @property
    def mixed_one_way(self) -> bool:
        """Whether it does so along rows only; columns are then mixed likewise before the fit."""
        return self.mixed and self.subsampling == "422"

    @property
    def extra_blur_px(self) -> float:
        """Blur of these means by the mixing, standard deviation [px]."""
        return 1.0 if self.mixed else 0.0

    @property
    def independence(self) -> float:
        """How many independent samples a mean of 2 x 2 pixels counts for."""
        return _MIXED_SHARE if self.mixed else 1.0


@dataclass(frozen=True, slots=True)
class Optics:
    """Sharpness and noise of the camera.

    Attributes:
        blur_px: lens blur, standard deviation of a Gaussian [px].
        noise: of a pixel, standard deviation [grey levels].
        chroma: how colour is sampled.
    """

    blur_px: float = 0.6
    noise: float = 3.0
    chroma: ChromaModel = ChromaModel()

    @property
    def edge_px(self) -> float:
        """Width of an edge in the picture, standard deviation of lens and pixel [px].

        A tag fits as well as noise n lets it with a misfit of 0.025 to 0.035 n times this
        (measured: tags of 8 to 32 px, n 1 to 6, blur 0.4 to 1 px).
        """
        return hypot(self.blur_px, _PIXEL)
