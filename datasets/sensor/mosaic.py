"""One colour filter per photosite, and the camera's guess at the two colours that are missing."""

from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from datasets.sensor.exposure import FULL
from datasets.sensor.stage import Image

Bayer = Literal["RGGB", "BGGR", "GRBG", "GBRG"]  # filters of the first two rows, left to right

BAYER: dict[str, int] = {
    "RGGB": cv2.COLOR_BayerRGGB2BGR,
    "BGGR": cv2.COLOR_BayerBGGR2BGR,
    "GRBG": cv2.COLOR_BayerGRBG2BGR,
    "GBRG": cv2.COLOR_BayerGBRG2BGR,
}
_SCALE = 256.0  # levels of the raw picture per grey level: 16 bits


class Mosaic:
    """Keeps one channel of every pixel and fills in the others by OpenCV's bilinear demosaicing."""

    def __init__(self, filters: Bayer, size_px: tuple[int, int]) -> None:
        """Lay the filters.

        Args:
            filters: of the first two rows.
            size_px: width and height of the frames, at least 4 [px].
        """
        self._code = BAYER[filters]
        rows, columns = np.indices(size_px[::-1])
        channels = np.array(["BGR".index(name) for name in filters]).reshape(2, 2)
        kept = channels[rows % 2, columns % 2]
        self._kept: NDArray[np.intp] = (np.arange(kept.size) * 3 + kept.ravel()).reshape(kept.shape)

    def __call__(self, image: Image, frame: int) -> Image:  # noqa: ARG002 (a Stage takes it)
        """See through the filters and guess the rest.

        Args:
            image: float32, shape (H, W, 3), linear light.
            frame: not used.

        Returns:
            float32, shape (H, W, 3), 0 to 255.
        """
        seen = np.clip(image.reshape(-1)[self._kept], 0.0, FULL)
        raw = np.rint(seen * _SCALE).astype(np.uint16)
        full = cv2.cvtColor(raw, self._code)
        return np.asarray(full, np.float32) / np.float32(_SCALE)
