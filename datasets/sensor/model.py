"""The parameters of a camera's lens and electronics, and the stages that obey them.

In physical order: light of the scene (linear) - lens - exposure - photosites (shot noise, hot
pixels, read noise, white balance, colour filters) - tone curve and 8 bits - codec. A new effect is
a new stage.
"""

from dataclasses import dataclass
from math import isfinite

import numpy as np
from numpy.typing import NDArray

from datasets.errors import SimulationError
from datasets.sensor.codec import FACTORS, INTERPOLATION, Chroma, ChromaLoss, JpegLoss, Upsampling
from datasets.sensor.encoding import Encoding
from datasets.sensor.exposure import Change, Exposure, Flicker, WhiteBalance
from datasets.sensor.mosaic import BAYER, Bayer, Mosaic
from datasets.sensor.noise import HotPixels, ReadNoise, ShotNoise
from datasets.sensor.optics import Vignetting, blur_radius, blurred, lamp_light
from datasets.sensor.shutter import Shutter
from datasets.sensor.stage import Stage
from vision.camera import CameraModel

_STEADY = Flicker()


@dataclass(frozen=True, slots=True)
class SensorModel:
    """A camera's lens, light and electronics.

    Attributes:
        read_noise: standard deviation of the noise of every colour channel, of 255, in linear
            light.
        blur_px: standard deviation of the lens's Gaussian point spread [px].
        uneven_light: 0.30: the darkest place gets 30 % less light than the brightest.
        light_center: brightest place, as shares of the image's width and height.
        chroma: colour subsampling: "444" none, "422" every second column, "420" also every second
            row; a colour sample is the mean of its pixels, its place is their middle.
        chroma_offset_px: displacement of the colours against the brightness, right and down, as
            encoders and decoders with different siting cause it [px].
        chroma_upsampling: how the decoder fills in colours: "linear", or "nearest" as fast ones do.
        jpeg_quality: 1 to 100, None for no compression.
        vignetting_power: n of the loss cos^n towards the corners; 0 none, 4 a plain lens.
        exposure_time: how long every row collects light: moving things blur [s].
        readout_time: from the first row's exposure to the last row's; 0: a global shutter [s].
        exposure_changes: of lamp, iris or exposure, in linear light.
        flicker: of the lamp.
        full_well: electrons at level 255, for shot noise; None for none.
        hot_pixels: share of pixels that are always too bright.
        white_balance_changes: of the channels' gains.
        bayer: colour filters of the first two rows, None for three photosites a pixel.
        gamma: level = 255 (light / 255)^(1 / gamma).

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
    vignetting_power: float = 0.0
    exposure_time: float = 0.0
    readout_time: float = 0.0
    exposure_changes: tuple[Change, ...] = ()
    flicker: Flicker = _STEADY
    full_well: float | None = None
    hot_pixels: float = 0.0
    white_balance_changes: tuple[Change, ...] = ()
    bayer: Bayer | None = None
    gamma: float = 1.0

    def __post_init__(self) -> None:
        quality = 100 if self.jpeg_quality is None else self.jpeg_quality
        well = 1.0 if self.full_well is None else self.full_well
        sound = (
            0.0 <= self.read_noise <= 255.0
            and 0.0 <= self.blur_px <= 50.0
            and 0.0 <= self.uneven_light < 1.0
            and all(map(isfinite, (*self.light_center, *self.chroma_offset_px)))
            and self.chroma in FACTORS
            and self.chroma_upsampling in INTERPOLATION
            and 1 <= quality <= 100
            and 0.0 <= self.vignetting_power <= 100.0
            and 0.0 <= self.exposure_time <= 1.0
            and 0.0 <= self.readout_time <= 1.0
            and 0.0 <= self.flicker.depth <= 1.0
            and 0.0 < well < 1e9
            and 0.0 <= self.hot_pixels <= 1.0
            and (self.bayer is None or self.bayer in BAYER)
            and 0.1 <= self.gamma <= 10.0
        )
        changes = (*self.exposure_changes, *self.white_balance_changes)
        if not (sound and all(map(_is_sound, changes))):
            raise SimulationError(f"sensor parameters out of range: {self}")

    @property
    def blur_radius(self) -> int:
        """How far the lens spreads a point [px]."""
        return blur_radius(self.blur_px)

    def blur(self, image: NDArray[np.float32]) -> NDArray[np.float32]:
        """Look through the lens.

        Args:
            image: shape (H, W, C).

        Returns:
            The blurred image, same shape.
        """
        return blurred(image, self.blur_px)

    def light(self, size_px: tuple[int, int], margin: int = 0) -> NDArray[np.float32]:
        """Brightness under one lamp, falling off with the square of the distance.

        Args:
            size_px: width and height of the image [px].
            margin: further pixels on every side [px].

        Returns:
            Shape (H + 2 margin, W + 2 margin): 1 at the brightest and 1 - uneven_light at the
            darkest pixel of the image, the margin apart.
        """
        return lamp_light(size_px, margin, self.uneven_light, self.light_center)

    def shutter(self, rows: int) -> Shutter:
        """When the rows are exposed.

        Args:
            rows: height of the image [px].

        Returns:
            The shutter.
        """
        return Shutter(self.exposure_time, self.readout_time, rows)

    def lens(self, camera: CameraModel) -> tuple[Stage, ...]:
        """What the lens does to the brightness.

        Args:
            camera: whose lens it is.

        Returns:
            Stages that leave linear light.
        """
        power = self.vignetting_power
        return (Vignetting(camera, power),) if power else ()

    def stages(self, size_px: tuple[int, int], seed: int) -> tuple[Stage, ...]:
        """Exposure and electronics, first to last.

        Args:
            size_px: width and height of the frames [px].
            seed: of all that is random, >= 0.

        Returns:
            Stages that turn a float32 frame into a uint8 one.
        """
        stages: list[Stage] = []
        if self.exposure_changes or self.flicker.depth:
            shutter = self.shutter(size_px[1])
            stages.append(Exposure(self.exposure_changes, self.flicker, shutter))
        stages += [*self._photosites(size_px, seed), *self._codec()]
        return tuple(stages)

    def _photosites(self, size_px: tuple[int, int], seed: int) -> list[Stage]:
        """From light to 8 bits."""
        stages: list[Stage] = []
        if self.full_well is not None:
            stages.append(ShotNoise(self.full_well, size_px, seed))
        if self.hot_pixels:
            stages.append(HotPixels(self.hot_pixels, size_px, seed))
        behind: list[Stage] = []
        if self.white_balance_changes:
            behind.append(WhiteBalance(self.white_balance_changes))
        if self.bayer is not None:
            behind.append(Mosaic(self.bayer, size_px))
        if behind or self.gamma != 1.0:
            behind.append(Encoding(self.gamma))
        return [*stages, ReadNoise(self.read_noise, size_px, seed, not behind), *behind]

    def _codec(self) -> list[Stage]:
        """From 8 bits to 8 bits."""
        stages: list[Stage] = []
        own = self.chroma if self.jpeg_quality is None else "444"  # JPEG subsamples itself
        if own != "444" or any(self.chroma_offset_px):
            stages.append(ChromaLoss(own, self.chroma_offset_px, self.chroma_upsampling))
        if self.jpeg_quality is not None:
            stages.append(JpegLoss(self.jpeg_quality, self.chroma))
        return stages


def _is_sound(change: Change) -> bool:
    """Whether a change can happen."""
    gains = all(0.0 <= gain < 1e6 for gain in change.gains)
    return gains and isfinite(change.at) and 0.0 <= change.duration < 1e9
