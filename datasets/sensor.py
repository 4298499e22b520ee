"""What a real camera does to the light that falls on it: named, seeded, physical parameters.

Two kinds of effects. Optics act where the picture changes: the lamp (`light`), the lens (`blur`).
Electronics act on whole frames, one `Stage` after the other, in the order of a real camera: noise
and digitising, colour subsampling or JPEG. A new effect is a new stage in `SensorModel.stages`.
"""

from dataclasses import dataclass
from math import ceil, isfinite
from typing import Any, Literal, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from datasets.errors import SimulationError

Chroma = Literal["444", "422", "420"]
Upsampling = Literal["linear", "nearest"]
Image = NDArray[Any]  # (H, W, 3) BGR: float32 until it is digitised, uint8 from then on

_FACTORS = {"444": (1, 1), "422": (2, 1), "420": (2, 2)}  # luma samples per chroma sample, x and y
_JPEG = {
    "444": cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444,
    "422": cv2.IMWRITE_JPEG_SAMPLING_FACTOR_422,
    "420": cv2.IMWRITE_JPEG_SAMPLING_FACTOR_420,
}
_INTERPOLATION = {"linear": cv2.INTER_LINEAR, "nearest": cv2.INTER_NEAREST}
_SPARE = 1 << 20  # noise samples beyond one frame: that many different frames


class Stage(Protocol):
    """One thing the electronics do to a frame."""

    def __call__(self, image: Image, frame: int) -> Image:
        """Change a frame.

        Args:
            image: shape (H, W, 3), BGR, 0 to 255; may be written to.
            frame: number of the frame; randomness depends on it and the seed alone.

        Returns:
            The changed frame, same shape.
        """
        ...


@dataclass(frozen=True, slots=True)
class SensorModel:
    """A camera's lens, light and electronics.

    Attributes:
        read_noise: standard deviation of the noise of every colour channel, of 255.
        blur_px: standard deviation of the lens's Gaussian point spread [px].
        uneven_light: 0.30: the darkest place gets 30 % less light than the brightest.
        light_center: brightest place, as shares of the image's width and height.
        chroma: colour subsampling: "444" none, "422" every second column, "420" also every second
            row; a colour sample is the mean of its pixels, its place is their middle.
        chroma_offset_px: displacement of the colours against the brightness, right and down, as
            encoders and decoders with different siting cause it [px].
        chroma_upsampling: how the decoder fills in colours: "linear", or "nearest" as fast ones do.
        jpeg_quality: 1 to 100, None for no compression.

    Raises:
        SimulationError: if a parameter is out of its range.
    """

    read_noise: float = 3.0
    blur_px: float = 0.6
    uneven_light: float = 0.0
    light_center: tuple[float, float] = (0.35, 0.4)
    chroma: Chroma = "420"
    chroma_offset_px: tuple[float, float] = (0.0, 0.0)
    chroma_upsampling: Upsampling = "linear"
    jpeg_quality: int | None = None

    def __post_init__(self) -> None:
        quality = 100 if self.jpeg_quality is None else self.jpeg_quality
        sound = (
            0.0 <= self.read_noise <= 255.0
            and 0.0 <= self.blur_px <= 50.0
            and 0.0 <= self.uneven_light < 1.0
            and all(map(isfinite, (*self.light_center, *self.chroma_offset_px)))
            and self.chroma in _FACTORS
            and self.chroma_upsampling in _INTERPOLATION
            and 1 <= quality <= 100
        )
        if not sound:
            raise SimulationError(f"sensor parameters out of range: {self}")

    @property
    def blur_radius(self) -> int:
        """How far the lens spreads a point [px]."""
        return ceil(4.0 * self.blur_px)

    def blur(self, image: NDArray[np.float32]) -> NDArray[np.float32]:
        """Look through the lens.

        Args:
            image: shape (H, W, C).

        Returns:
            The blurred image, same shape.
        """
        if not self.blur_px:
            return image
        size = 2 * self.blur_radius + 1
        return np.asarray(cv2.GaussianBlur(image, (size, size), self.blur_px), np.float32)

    def light(self, size_px: tuple[int, int], margin: int = 0) -> NDArray[np.float32]:
        """Brightness under one lamp, falling off with the square of the distance.

        Args:
            size_px: width and height of the image [px].
            margin: further pixels on every side [px].

        Returns:
            Shape (H + 2 margin, W + 2 margin): 1 at the brightest and 1 - uneven_light at the
            darkest pixel of the image, the margin apart.
        """
        width, height = size_px
        x = np.arange(-margin, width + margin) - self.light_center[0] * (width - 1)
        y = np.arange(-margin, height + margin) - self.light_center[1] * (height - 1)
        square = (x * x)[None, :] + (y * y)[:, None]
        inner = square[margin : margin + height, margin : margin + width]
        near, far = inner.min(), inner.max()
        falloff = self.uneven_light / ((1.0 - self.uneven_light) * max(far - near, 1.0))
        light = 1.0 / (1.0 + falloff * np.maximum(square - near, 0.0))
        return np.asarray(light, np.float32)

    def stages(self, size_px: tuple[int, int], seed: int) -> tuple[Stage, ...]:
        """The electronics, first to last.

        Args:
            size_px: width and height of the frames [px].
            seed: of all that is random, >= 0.

        Returns:
            Stages that turn a float32 frame into a uint8 one.
        """
        stages: list[Stage] = [ReadNoise(self.read_noise, size_px, seed)]
        own = self.chroma if self.jpeg_quality is None else "444"  # JPEG subsamples itself
        if own != "444" or any(self.chroma_offset_px):
            stages.append(ChromaLoss(own, self.chroma_offset_px, self.chroma_upsampling))
        if self.jpeg_quality is not None:
            stages.append(JpegLoss(self.jpeg_quality, self.chroma))
        return tuple(stages)


class ReadNoise:
    """Gaussian noise, independent in every pixel, channel and frame; then 8 bits.

    A frame's noise is a piece of a long seeded row of samples, beginning at a place that depends on
    the frame: as good as fresh samples, and 30 times as fast.
    """

    def __init__(self, sigma: float, size_px: tuple[int, int], seed: int) -> None:
        """Make the samples.

        Args:
            sigma: standard deviation, of 255.
            size_px: width and height of the frames [px].
            seed: of the samples, >= 0.
        """
        self._seed = seed
        self._samples = None
        if sigma:
            count = 3 * size_px[0] * size_px[1] + _SPARE
            rng = np.random.default_rng(seed)
            self._samples = rng.standard_normal(count, np.float32) * np.float32(sigma)

    def __call__(self, image: Image, frame: int) -> Image:
        """Add the frame's noise and digitise.

        Args:
            image: float32, shape (H, W, 3), 0 to 255.
            frame: number of the frame.

        Returns:
            uint8, rounded, values beyond 0 and 255 clipped.
        """
        if self._samples is None:
            return np.clip(np.rint(image), 0, 255).astype(np.uint8)
        first = np.random.default_rng((self._seed, frame)).integers(_SPARE)
        noise = self._samples[first : first + image.size].reshape(image.shape)
        return cv2.add(image, noise, dtype=cv2.CV_8U)


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
        across, down = _FACTORS[self.chroma]
        if across * down == 1:
            return image.copy()
        odd = cv2.copyMakeBorder(image, 0, -height % down, 0, -width % across, cv2.BORDER_REPLICATE)
        rows, columns = odd.shape[:2]
        few = cv2.resize(odd, (columns // across, rows // down), interpolation=cv2.INTER_AREA)
        many = cv2.resize(few, (columns, rows), interpolation=_INTERPOLATION[self.upsampling])
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
