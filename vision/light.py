"""The light on the robots: how colours look now, against how they looked to the palette."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from vision.compiled import compiled

Floats = NDArray[np.float64]
Bytes = NDArray[np.uint8]

_LATTICE = (24, 18)  # columns and rows of pixels by which two frames are compared
_JUMP = 0.04  # a smaller change of the whole picture is left to the tags to tell
_DARK, _BRIGHT = 6, 249  # values beyond say little of the light
_BAND = (-0.45, 0.05)  # log brightness of tags for which the palette is right, see `taught`
_RATE = 0.2  # share of a difference that a frame takes over
_MOST = 1.5  # log of the largest factor, either way


@dataclass(frozen=True, slots=True)
class Light:
    """Exposure and white balance, as factors on the colours the palette was learned from.

    Attributes:
        blue: factor of the blue channel.
        green: of the green channel.
        red: of the red channel.
        view: shape (N, 3), BGR of a lattice of pixels of the last frame, None before the first.
    """

    blue: float = 1.0
    green: float = 1.0
    red: float = 1.0
    view: Bytes | None = field(default=None, compare=False, repr=False)

    @property
    def gains(self) -> Floats:
        """The factors as an array, shape (3,), BGR."""
        return np.array((self.blue, self.green, self.red))


PALETTE_LIGHT = Light()
"""The light in which the palette was learned."""


def watched(light: Light, image: Bytes) -> Light:
    """Follow a jump of exposure or white balance, by what the whole picture does.

    The median over a lattice of pixels of the ratio to the last frame is robust against robots and
    hands that move.

    Args:
        light: of the last frame.
        image: the new frame, shape (H, W, 3), BGR.

    Returns:
        The light to expect in the new frame.
    """
    view = np.empty((_LATTICE[0] * _LATTICE[1], 3), np.uint8)
    _sample(image, view)
    if light.view is None or not _has_jumped(light.view, view):
        return Light(light.blue, light.green, light.red, view)
    return _made(light.gains * _ratios(light.view, view), view)


def taught(light: Light, ratios: Floats) -> Light:
    """Follow the light slowly, by how confirmed tags look.

    White balance is followed wholly. Brightness is followed only where it leaves the range in which
    the palette is right anyway, since tags in a dark corner say nothing of the rest of the field.

    Args:
        light: in which they were seen.
        ratios: shape (N, 3), their colours over what the palette has learned, BGR.

    Returns:
        The light as they show it.
    """
    if len(ratios) == 0:
        return light
    blue, green, red = _pulled(ratios, (light.blue, light.green, light.red))
    return Light(blue, green, red, light.view)


@compiled
def _pulled(ratios: Floats, gains: tuple[float, float, float]) -> tuple[float, float, float]:
    """Gains pulled towards the medians of ratios."""
    off = np.empty(3)
    for channel in range(3):
        off[channel] = np.log(np.median(ratios[:, channel]) / gains[channel])
    brightness = off.mean()
    beyond = brightness - min(max(brightness, _BAND[0]), _BAND[1])
    off += beyond - brightness
    for channel in range(3):
        log = np.log(gains[channel]) + _RATE * off[channel]
        off[channel] = np.exp(min(max(log, -_MOST), _MOST))
    return off[0], off[1], off[2]


@compiled
def _sample(image: Bytes, view: Bytes) -> None:
    """Pick the pixels of the lattice."""
    for row in range(_LATTICE[1]):
        y = (2 * row + 1) * image.shape[0] // (2 * _LATTICE[1])
        for column in range(_LATTICE[0]):
            x = (2 * column + 1) * image.shape[1] // (2 * _LATTICE[0])
            view[row * _LATTICE[0] + column] = image[y, x]


def _made(gains: Floats, view: Bytes | None) -> Light:
    """A light with its factors kept within reason."""
    blue, green, red = np.exp(np.clip(np.log(gains), -_MOST, _MOST)).tolist()
    return Light(blue, green, red, view)


@compiled
def _has_jumped(before: Bytes, now: Bytes) -> bool:
    """Whether the sum of a channel has changed much."""
    for channel in range(3):
        one, two = 1.0, 1.0
        for n in range(len(before)):
            one += before[n, channel]
            two += now[n, channel]
        if abs(two / one - 1.0) > _JUMP:
            return True
    return False


def _ratios(before: Bytes, now: Bytes) -> Floats:
    """Median factors of the channels, 1 where too few pixels tell."""
    factors = np.ones(3)
    for channel in range(3):
        one, two = before[:, channel].astype(np.float64), now[:, channel].astype(np.float64)
        fit = (np.minimum(one, two) > _DARK) & (np.maximum(one, two) < _BRIGHT)
        if np.count_nonzero(fit) >= len(one) // 8:
            factors[channel] = np.median(two[fit] / one[fit])
    return factors
