"""The light on the robots: how colours look now, against how they looked to the palette."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from vision.compiled import compiled, compiled_part

Floats = NDArray[np.float64]
Bytes = NDArray[np.uint8]

_LATTICE = (24, 18)  # columns and rows of pixels by which two frames are compared
_JUMP = 0.04  # a smaller change of the whole picture is left to the tags to tell
_DARK, _BRIGHT = 6, 249  # values beyond say little of the light
_BAND = (-0.5, 0.3)  # log brightness of tags for which the palette is right, see `taught`
_TINT = 0.05  # and log tint, either way
_TURNS = 3  # of brightness and tint
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
        supposed: which of `BRIGHTNESSES` is supposed while nobody is found.
        misfit_px: usual residual of tags through this camera, 0 before the first [px].
    """

    blue: float = 1.0
    green: float = 1.0
    red: float = 1.0
    view: Bytes | None = field(default=None, compare=False, repr=False)
    supposed: int = 0
    misfit_px: float = 0.0

    @property
    def gains(self) -> Floats:
        """The factors as an array, shape (3,), BGR."""
        return np.array((self.blue, self.green, self.red))


BRIGHTNESSES = (1.0, 0.55, 0.3, 1.7)
"""Factors of the palette's light that are tried while nobody is found."""

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
        return replace(light, view=view)
    return _made(replace(light, view=view), light.gains * _ratios(light.view, view))


def taught(light: Light, ratios: Floats) -> Light:
    """Follow the light slowly, by how confirmed tags look.

    Brightness and tint are followed only where they leave the range in which the palette is right
    anyway: tags in a dark corner say nothing of the rest of the field, and few colours little of
    the tint.

    Args:
        light: in which they were seen.
        ratios: shape (N, K, 3), colours of the K parts of N tags over what the palette has learned,
            BGR, NaN where nothing can be said.

    Returns:
        The light as they show it.
    """
    blue, green, red = _pulled(ratios, (light.blue, light.green, light.red))
    return replace(light, blue=blue, green=green, red=red)


def refitted(light: Light, residuals_px: list[float]) -> Light:
    """Follow how well tags usually fit: halos, prints and lenses that nobody measured.

    Args:
        light: of this frame.
        residuals_px: of the tags that were accepted [px].

    Returns:
        The light with the usual misfit.
    """
    if not residuals_px:
        return light
    middle = sorted(residuals_px)[len(residuals_px) // 2]
    share = _RATE if light.misfit_px else 1.0
    return replace(light, misfit_px=light.misfit_px + share * (middle - light.misfit_px))


def relit(light: Light) -> Light:
    """Suppose another brightness, where nobody is found and nobody is known.

    Args:
        light: that was supposed in vain.

    Returns:
        The next of `BRIGHTNESSES`, in turn.
    """
    n = (light.supposed + 1) % len(BRIGHTNESSES)
    factor = BRIGHTNESSES[n] / BRIGHTNESSES[light.supposed]
    return _made(light, light.gains * factor, supposed=n)


@compiled
def _pulled(ratios: Floats, gains: tuple[float, float, float]) -> tuple[float, float, float]:
    """Gains pulled towards brightness and tint of the tags.

    Every tag has a brightness of its own, all have the tint in common: log ratio = brightness of
    the tag + tint of the channel. Solved by turns, with medians.
    """
    count, parts = ratios.shape[0], ratios.shape[1]
    own, tint, pool = np.zeros(count), np.zeros(3), np.empty(count * parts + 1)
    for _ in range(_TURNS):
        for n in range(count):
            own[n] = _brightness(ratios[n], gains, tint)
        for channel in range(3):
            many = 0
            for n in range(count):
                for k in range(parts):
                    pool[many] = np.log(ratios[n, k, channel] / gains[channel]) - own[n]
                    many += pool[many] == pool[many]
            tint[channel] = _median(pool, many)
        mean = (tint[0] + tint[1] + tint[2]) / 3.0
        for channel in range(3):
            tint[channel] -= mean
    many = 0
    for n in range(count):
        pool[many] = own[n]
        many += own[n] == own[n]
    if many == 0:
        return gains
    brightness = _median(pool, many)
    beyond = brightness - min(max(brightness, _BAND[0]), _BAND[1])
    for channel in range(3):
        off = tint[channel] - min(max(tint[channel], -_TINT), _TINT)
        log = np.log(gains[channel]) + _RATE * (beyond + off)
        tint[channel] = np.exp(min(max(log, -_MOST), _MOST))
    return tint[0], tint[1], tint[2]


@compiled_part
def _brightness(ratios: Floats, gains: tuple[float, float, float], tint: Floats) -> float:
    """Mean log ratio (K, 3) of a tag without the tint, nan if nothing can be said."""
    total, telling = 0.0, 0
    for k in range(len(ratios)):
        for channel in range(3):
            off = np.log(ratios[k, channel] / gains[channel]) - tint[channel]
            if off == off:
                total, telling = total + off, telling + 1
    return total / telling if telling else np.nan


@compiled_part
def _median(pool: Floats, count: int) -> float:
    """Median of the first elements, 0 if there are none; sorts them."""
    for n in range(1, count):
        value, place = pool[n], n
        while place > 0 and pool[place - 1] > value:
            pool[place] = pool[place - 1]
            place -= 1
        pool[place] = value
    if count == 0:
        return 0.0
    return float(0.5 * (pool[count // 2] + pool[(count - 1) // 2]))


@compiled
def _sample(image: Bytes, view: Bytes) -> None:
    """Pick the pixels of the lattice."""
    for row in range(_LATTICE[1]):
        y = (2 * row + 1) * image.shape[0] // (2 * _LATTICE[1])
        for column in range(_LATTICE[0]):
            x = (2 * column + 1) * image.shape[1] // (2 * _LATTICE[0])
            for channel in range(3):
                view[row * _LATTICE[0] + column, channel] = image[y, x, channel]


def _made(light: Light, gains: Floats, supposed: int | None = None) -> Light:
    """A light with other factors, kept within reason."""
    blue, green, red = np.exp(np.clip(np.log(gains), -_MOST, _MOST)).tolist()
    supposed = light.supposed if supposed is None else supposed
    return replace(light, blue=blue, green=green, red=red, supposed=supposed)


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
