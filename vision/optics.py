"""Sharpness, noise and colour sampling of a camera."""

from dataclasses import dataclass

import numpy as np

from vision.errors import VisionError

_SUBSAMPLED_AXES = {"444": 0, "422": 1, "420": 2}
_UPSAMPLINGS = ("linear", "nearest")
# Linear upsampling and 2 x 2 means mix neighbours 1 : 6 : 1: a blur of 1 px, and so little noise.
_LINEAR_SHARE = (1.0 + 36.0 + 1.0) / 64.0


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
        if self.subsampling not in _SUBSAMPLED_AXES or self.upsampling not in _UPSAMPLINGS:
            raise VisionError(
                f"chroma {self.subsampling}, {self.upsampling}: know "
                f"{', '.join(_SUBSAMPLED_AXES)} and {', '.join(_UPSAMPLINGS)}"
            )

    @property
    def extra_blur_px(self) -> float:
        """Blur that upsampling adds to means of 2 x 2 pixels, standard deviation [px]."""
        share = _SUBSAMPLED_AXES[self.subsampling] / 2.0
        return float(np.sqrt(share)) if self.upsampling == "linear" else 0.0

    @property
    def independence(self) -> float:
        """How many independent samples a mean of 2 x 2 pixels counts for, after upsampling."""
        axes = _SUBSAMPLED_AXES[self.subsampling] if self.upsampling == "linear" else 0
        return _LINEAR_SHARE**axes


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
