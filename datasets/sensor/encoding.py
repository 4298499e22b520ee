"""From linear light to the numbers of a picture: gamma and 8 bits."""

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from datasets.sensor.exposure import FULL
from datasets.sensor.stage import Image


def linear_light(levels: ArrayLike, gamma: float) -> NDArray[np.float64]:
    """What light gives some levels of a picture.

    Args:
        levels: 0 to 255, any shape.
        gamma: level = 255 (light / 255)^(1 / gamma).

    Returns:
        Linear light, 0 to 255, same shape.
    """
    given = np.asarray(levels, np.float64)
    return given if gamma == 1.0 else FULL * (given / FULL) ** gamma


class Encoding:
    """The camera's tone curve, level = 255 (light / 255)^(1 / gamma); then 8 bits."""

    def __init__(self, gamma: float) -> None:
        """Remember the curve.

        Args:
            gamma: 1 for none, 2.2 as a rule.
        """
        self._power = 1.0 / gamma

    def __call__(self, image: Image, frame: int) -> Image:  # noqa: ARG002 (a Stage takes it)
        """Encode and digitise.

        Args:
            image: float32, shape (H, W, 3), linear light.
            frame: not used.

        Returns:
            uint8, rounded; light beyond 0 and 255 is clipped.
        """
        light = np.clip(image, 0.0, FULL)
        if self._power != 1.0:
            light = cv2.pow(light * np.float32(1.0 / FULL), self._power) * np.float32(FULL)
        levels: Image = np.rint(light).astype(np.uint8)
        return levels
