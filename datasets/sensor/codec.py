"""The camera's codec: colours at fewer places than brightness, and JPEG."""

from dataclasses import dataclass
from typing import Literal

import cv2
import numpy as np

from datasets.errors import SimulationError
from datasets.sensor.stage import Image

Chroma = Literal["444", "422", "420"]
Upsampling = Literal["linear", "nearest"]

FACTORS = {"444": (1, 1), "422": (2, 1), "420": (2, 2)}  # luma samples per chroma sample, x and y
INTERPOLATION = {"linear": cv2.INTER_LINEAR, "nearest": cv2.INTER_NEAREST}
_JPEG = {
    "444": cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444,
    "422": cv2.IMWRITE_JPEG_SAMPLING_FACTOR_422,
    "420": cv2.IMWRITE_JPEG_SAMPLING_FACTOR_420,
}


@dataclass(frozen=True, slots=True)
class ChromaLoss:
    """Colours kept at fewer places than brightness, and perhaps displaced; full-range BT.601.

    Attributes:
        chroma: "444", "422" or "420".
        offset_px: displacement of the colours, right and down [px].
        upsampling: how the decoder fills in colours.
    """

    chroma: Chroma
    offset_px: tuple[float, float]
    upsampling: Upsampling

    def __call__(self, image: Image, frame: int) -> Image:  # noqa: ARG002 (a Stage takes it)
        """Encode and decode.

        Args:
            image: uint8, shape (H, W, 3).
            frame: not used.

        Returns:
            What the decoder makes of it, uint8.
        """
        full = cv2.cvtColor(image, cv2.COLOR_BGR2YCrCb)
        colors = self._resampled(self._displaced(full))
        cv2.mixChannels([full], [colors], [0, 0])  # the brightness stays
        return cv2.cvtColor(colors, cv2.COLOR_YCrCb2BGR)

    def _displaced(self, image: Image) -> Image:
        if not any(self.offset_px):
            return image
        height, width = image.shape[:2]
        shift = np.array([[1.0, 0.0, self.offset_px[0]], [0.0, 1.0, self.offset_px[1]]])
        return cv2.warpAffine(image, shift, (width, height), borderMode=cv2.BORDER_REPLICATE)

    def _resampled(self, image: Image) -> Image:
        height, width = image.shape[:2]
        across, down = FACTORS[self.chroma]
        if across * down == 1:
            return image.copy()
        odd = cv2.copyMakeBorder(image, 0, -height % down, 0, -width % across, cv2.BORDER_REPLICATE)
        rows, columns = odd.shape[:2]
        few = cv2.resize(odd, (columns // across, rows // down), interpolation=cv2.INTER_AREA)
        many = cv2.resize(few, (columns, rows), interpolation=INTERPOLATION[self.upsampling])
        return np.ascontiguousarray(many[:height, :width])


@dataclass(frozen=True, slots=True)
class JpegLoss:
    """A trip through a real JPEG encoder and decoder, as MJPG cameras do with every frame.

    Attributes:
        quality: 1 to 100.
        chroma: colour subsampling.
    """

    quality: int
    chroma: Chroma

    def __call__(self, image: Image, frame: int) -> Image:  # noqa: ARG002 (a Stage takes it)
        """Encode and decode.

        Args:
            image: uint8, shape (H, W, 3).
            frame: not used.

        Returns:
            What the decoder makes of it, uint8.

        Raises:
            SimulationError: if the codec fails.
        """
        options = [cv2.IMWRITE_JPEG_QUALITY, self.quality]
        options += [cv2.IMWRITE_JPEG_SAMPLING_FACTOR, _JPEG[self.chroma]]
        encoded, data = cv2.imencode(".jpg", image, options)
        decoded = cv2.imdecode(data, cv2.IMREAD_COLOR) if encoded else None
        if decoded is None:
            raise SimulationError(f"JPEG of quality {self.quality} failed")
        return decoded
