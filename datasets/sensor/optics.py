"""The lamp and the lens: light that falls off, points that spread, corners that darken."""

from math import ceil

import cv2
import numpy as np
from numpy.typing import NDArray

from datasets.sensor.stage import Image
from vision.camera import CameraModel

Singles = NDArray[np.float32]


def blur_radius(sigma: float) -> int:
    """How far a lens spreads a point.

    Args:
        sigma: standard deviation of its Gaussian point spread [px].

    Returns:
        The distance beyond which nothing arrives [px].
    """
    return ceil(4.0 * sigma)


def blurred(image: Singles, sigma: float) -> Singles:
    """Look through a lens.

    Args:
        image: shape (H, W, C).
        sigma: standard deviation of the lens's Gaussian point spread [px].

    Returns:
        The blurred image, same shape.
    """
    if not sigma:
        return image
    size = 2 * blur_radius(sigma) + 1
    return np.asarray(cv2.GaussianBlur(image, (size, size), sigma), np.float32)


def lamp_light(
    size_px: tuple[int, int], margin: int, share: float, center: tuple[float, float]
) -> Singles:
    """Brightness under one lamp, falling off with the square of the distance.

    Args:
        size_px: width and height of the image [px].
        margin: further pixels on every side [px].
        share: how much less light the darkest pixel of the image gets than the brightest.
        center: brightest place, as shares of the image's width and height.

    Returns:
        Shape (H + 2 margin, W + 2 margin): 1 at the brightest and 1 - share at the darkest pixel of
        the image, the margin apart.
    """
    width, height = size_px
    x = np.arange(-margin, width + margin) - center[0] * (width - 1)
    y = np.arange(-margin, height + margin) - center[1] * (height - 1)
    square = (x * x)[None, :] + (y * y)[:, None]
    inner = square[margin : margin + height, margin : margin + width]
    near, far = inner.min(), inner.max()
    falloff = share / ((1.0 - share) * max(far - near, 1.0))
    light = 1.0 / (1.0 + falloff * np.maximum(square - near, 0.0))
    return np.asarray(light, np.float32)


class Vignetting:
    """Light lost towards the corners: cos^n of the angle between a pixel's ray and the axis.

    A thin lens without a stop of its own follows n = 4; narrow lens barrels lose more.
    """

    def __init__(self, camera: CameraModel, power: float) -> None:
        """Work out the loss of every pixel.

        Args:
            camera: its focal lengths and principal point give the angles; distortion is left out.
            power: n, >= 0.
        """
        width, height = camera.size_px
        (fx, _, cx), (_, fy, cy) = camera.matrix[:2].tolist()
        x, y = (np.arange(width) - cx) / fx, (np.arange(height) - cy) / fy
        cosines = 1.0 / np.sqrt(1.0 + (x * x)[None, :] + (y * y)[:, None])
        self._share = np.asarray(cosines**power, np.float32)[..., None]

    def __call__(self, image: Image, frame: int) -> Image:  # noqa: ARG002 (a Stage takes it)
        """Darken the corners.

        Args:
            image: float32, shape (H, W, 3), linear light.
            frame: not used.

        Returns:
            The darkened image, same shape.
        """
        return np.multiply(image, self._share, out=image)
