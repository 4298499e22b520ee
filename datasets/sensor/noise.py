"""Noise of the photosites: shot noise of the light, hot pixels, read noise of the amplifier.

A frame's noise is a piece of a long seeded row of samples, beginning at a place that depends on the
frame: as good as fresh samples, and 30 times as fast.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from datasets.sensor.exposure import FULL
from datasets.sensor.stage import Image

Singles = NDArray[np.float32]

_SPARE = 1 << 20  # noise samples beyond one frame: that many different frames
_SHOT, _HOT = 2, 3  # streams of randomness beside the read noise's
_FAINTEST = 64.0  # what the weakest hot pixel adds, of 255


class ReadNoise:
    """Gaussian noise, independent in every pixel, channel and frame; then, as a rule, 8 bits."""

    def __init__(
        self, sigma: float, size_px: tuple[int, int], seed: int, digital: bool = True
    ) -> None:
        """Make the samples.

        Args:
            sigma: standard deviation, of 255.
            size_px: width and height of the frames [px].
            seed: of the samples, >= 0.
            digital: whether frames are digitised here; False if a later stage does it.
        """
        self._seed, self._digital = seed, digital
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
            uint8, rounded, values beyond 0 and 255 clipped; float32, unclipped, if not digital.
        """
        if self._samples is None:
            return _digitised(image) if self._digital else image
        first = np.random.default_rng((self._seed, frame)).integers(_SPARE)
        noise = self._samples[first : first + image.size].reshape(image.shape)
        return cv2.add(image, noise, dtype=cv2.CV_8U if self._digital else cv2.CV_32F)


class ShotNoise:
    """Photons come one by one: a photosite with N electrons varies by sqrt(N).

    Poisson's law with its variance, drawn as a Gaussian, which from some twenty electrons on makes
    no difference. A photosite cannot hold more than its full well.
    """

    def __init__(self, full_well: float, size_px: tuple[int, int], seed: int) -> None:
        """Make the samples.

        Args:
            full_well: electrons of a photosite at level 255.
            size_px: width and height of the frames [px].
            seed: of the samples, >= 0.
        """
        self._seed = seed
        rng = np.random.default_rng((seed, _SHOT))
        count = 3 * size_px[0] * size_px[1] + _SPARE
        self._samples = rng.standard_normal(count, np.float32)
        self._samples *= np.float32((FULL / full_well) ** 0.5)

    def __call__(self, image: Image, frame: int) -> Image:
        """Count photons.

        Args:
            image: float32, shape (H, W, 3), mean level of every photosite, linear light.
            frame: number of the frame.

        Returns:
            The counted levels, 0 to 255, float32.
        """
        first = np.random.default_rng((self._seed, frame, _SHOT)).integers(_SPARE)
        noise = self._samples[first : first + image.size].reshape(image.shape)
        level = np.clip(image, 0.0, FULL, out=image)
        level += np.sqrt(level) * noise
        return np.clip(level, 0.0, FULL, out=level)


class HotPixels:
    """Photosites with a large dark current: the same ones in every frame, always too bright."""

    def __init__(self, share: float, size_px: tuple[int, int], seed: int) -> None:
        """Choose them.

        Args:
            share: of all pixels, 0 to 1.
            size_px: width and height of the frames [px].
            seed: of the choice, >= 0.
        """
        rng = np.random.default_rng((seed, _HOT))
        hot = rng.random(size_px[::-1]) < share
        added = np.where(hot, rng.uniform(_FAINTEST, FULL, hot.shape), 0.0)
        self._added = np.asarray(added[..., None], np.float32)

    def __call__(self, image: Image, frame: int) -> Image:  # noqa: ARG002 (a Stage takes it)
        """Add what the hot pixels add.

        Args:
            image: float32, shape (H, W, 3).
            frame: not used.

        Returns:
            The changed image, same shape.
        """
        return np.add(image, self._added, out=image)


def _digitised(image: Singles) -> Image:
    """Round and clip to 8 bits."""
    return np.clip(np.rint(image), 0, 255).astype(np.uint8)
