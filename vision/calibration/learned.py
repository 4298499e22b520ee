"""A palette from measured pixels, extended to places where the light is brighter or darker."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from vision.errors import VisionError
from vision.palette import (
    BGR_FROM_YCC,
    YCC_FROM_BGR,
    ColorSamples,
    Palette,
    learn_palette,
)

Floats = NDArray[np.float64]
Pixels = NDArray[np.uint8]

_GAINS = 9  # steps of the light
_DEPTHS = (0.8, 1.0, 1.2)  # of the colour: what neighbours and codecs add to chroma or take
_NOISE = 5.0  # every pixel stands for a small cloud about it [grey levels]
_TINT = 0.1  # log of what another lamp or white balance makes of the floor's blue and red
_BACKGROUND = 0.3  # weight of black and floor where the geometry already told that a tag is there


@dataclass(frozen=True, slots=True)
class Print:
    """A printed colour, all prints of a set in the same light.

    Attributes:
        name: of the colour.
        bgr: blue, green, red; may exceed 255.
    """

    name: str
    bgr: tuple[float, float, float]


def palette_from_samples(
    samples: tuple[ColorSamples, ...],
    prints: tuple[Print, ...],
    light: tuple[float, float] = (0.45, 1.8),
    background: tuple[str, ...] = ("black", "floor"),
) -> Palette:
    """Learn a palette from pixels of one scene, for all of its places.

    Args:
        samples: of every colour, measured.
        prints: the colours that are searched for, in a common light.
        light: how much darker and brighter than measured a colour may appear, as factors.
        background: names that compete with the others but are not searched for; the floor is
            known in all its lights and only extended to other tints.

    Returns:
        The palette.

    Raises:
        VisionError: if the light range is not positive and ascending, or the prints' names are not
            those of the samples.
    """
    if not 0.0 < light[0] <= light[1]:
        raise VisionError(f"light range {light[0]} to {light[1]}: need 0 < low <= high")
    known = {p.name: p.bgr for p in prints}
    wanted = {s.name for s in samples} - set(background)
    if wanted != known.keys():
        raise VisionError(f"samples of {sorted(wanted)}, but prints of {sorted(known)}")
    gains = np.geomspace(*light, _GAINS)
    extended = tuple(
        ColorSamples(
            s.name, _in_tints(s.pixels) if s.name == "floor" else _in_lights(s.pixels, gains)
        )
        for s in samples
    )
    palette = learn_palette(extended, background)
    typical = np.array([(0.0, 0.0, 0.0), *(known[name] for name in palette.names)])
    weights = np.array((_BACKGROUND, *[1.0] * len(palette.names)), np.float32)
    posterior = np.asarray(palette.posterior * weights, np.float32)
    posterior /= posterior.sum(axis=1, keepdims=True)
    for array in (typical, posterior):
        array.flags.writeable = False
    return replace(palette, posterior=posterior, typical=typical)


def _in_tints(pixels: Pixels) -> Pixels:
    """The pixels as they are, and a little bluer, redder, greener and the opposite."""
    turns = np.array([(0, 0), (0, 0), (1, -1), (-1, 1), (1, 0), (-1, 0), (0, 1), (0, -1)])
    factors = np.exp(_TINT * np.column_stack((turns[:, 0], np.zeros(len(turns)), turns[:, 1])))
    seen = pixels.astype(np.float64) * factors[:, None]
    found: Pixels = np.clip(np.rint(seen), 0, 255).astype(np.uint8).reshape(-1, 3)
    return found


def _in_lights(pixels: Pixels, gains: Floats) -> Pixels:
    """The pixels in all lights, paler and deeper, each with its cloud."""
    cloud = _NOISE * np.concatenate((np.zeros((1, 3)), np.eye(3), -np.eye(3)))
    ycc = pixels.astype(np.float64) @ YCC_FROM_BGR.T
    deep = ycc * np.column_stack((np.ones(len(_DEPTHS)), _DEPTHS, _DEPTHS))[:, None]
    seen = gains[:, None, None, None] * (deep @ BGR_FROM_YCC.T)[:, :, None].reshape(-1, 1, 3)
    found: Pixels = np.clip(np.rint(seen + cloud), 0, 255).astype(np.uint8).reshape(-1, 3)
    return found
