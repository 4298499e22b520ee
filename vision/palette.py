"""Named colours: from a pixel to its class by one look-up, learned from samples.

A colour is packed to 15 bit (5 each of blue, green and red) and looked up in a table of 32 768
entries. The table is a kernel density estimate per colour over these 32 x 32 x 32 cells.
"""

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.errors import VisionError
from vision.light import PALETTE_LIGHT, Light

Pixels = NDArray[np.uint8]
Floats = NDArray[np.float64]

LEVELS = 32  # cells along each of blue, green and red
_KERNEL_CELLS = 1.0  # standard deviation of the kernel [cells of 8 grey levels]
_LIGHT_STEP = 0.03  # of the logarithm of a factor, in which tables for other lights are made
_CLUTTER = 2.0  # weight of "any colour" (uniform) against one named colour
_BGR_TO_YCC = np.array(
    [[0.114, 0.587, 0.299], [0.5, -0.331264, -0.168736], [-0.081312, -0.418688, 0.5]]
)
YCC_FROM_BGR: Floats = _BGR_TO_YCC  # luma, blue and red chroma (zero mean), ITU-R BT.601 full range
BGR_FROM_YCC: Floats = np.linalg.inv(_BGR_TO_YCC)


@dataclass(frozen=True, slots=True)
class NamedColor:
    """A colour as it looks under full light.

    Attributes:
        name: e.g. "yellow".
        bgr: blue, green, red [0..255].
    """

    name: str
    bgr: tuple[int, int, int]


@dataclass(frozen=True, slots=True)
class ColorSamples:
    """Pixels known to show a colour.

    Attributes:
        name: of the colour.
        pixels: shape (N, 3), N >= 1, BGR.
    """

    name: str
    pixels: Pixels


@dataclass(frozen=True, slots=True, eq=False)
class Palette:
    """Colour classes; class 0 is "nothing", class i is `names[i - 1]`.

    Attributes:
        names: of the classes that are searched for.
        table: shape (32768,), class of a packed colour, read-only.
        posterior: shape (32768, 1 + len(names)), probability of every class for a packed colour,
            read-only.
        typical: shape (1 + len(names), 3), mean BGR of the samples of every class, 0 for "nothing",
            read-only.
    """

    names: tuple[str, ...]
    table: Pixels
    posterior: NDArray[np.float32]
    typical: Floats

    def class_of(self, name: str) -> int:
        """Number of a colour's class.

        Args:
            name: of the colour.

        Returns:
            Its class, 0 if the palette does not search for it.
        """
        return self.names.index(name) + 1 if name in self.names else 0

    def classify(self, image: Pixels, light: Light = PALETTE_LIGHT) -> Pixels:
        """Look up the class of every pixel.

        Args:
            image: shape (H, W, 3), BGR.
            light: in which it was taken.

        Returns:
            Classes, shape (H, W).
        """
        steps = np.rint(np.log(light.gains) / _LIGHT_STEP).astype(int)
        packed = cv2.cvtColor(image, cv2.COLOR_BGR2BGR555).view(np.uint16)[..., 0]
        return _looked_up(_lit(self, tuple(steps.tolist())), packed)

    def probabilities(self, colors: Floats) -> NDArray[np.float32]:
        """Probability of every class, for colours that need not be whole numbers.

        Args:
            colors: shape (..., 3), BGR; clipped to 0..255.

        Returns:
            Probabilities, shape (..., 1 + len(names)).
        """
        cells = np.clip(np.nan_to_num(colors), 0, 255).astype(np.int64) >> 3
        found: NDArray[np.float32] = self.posterior[cells @ _PLACES]
        return found


@lru_cache(maxsize=64)
def _lit(palette: Palette, steps: tuple[int, int, int]) -> Pixels:
    """The table of a palette under another light, in steps of `_LIGHT_STEP`; twice in a row."""
    if not any(steps):
        return np.concatenate((palette.table, palette.table))
    middle = 8.0 * np.arange(LEVELS) + 4.0
    cells = np.clip(np.outer(np.exp(-_LIGHT_STEP * np.array(steps)), middle), 0, 255) // 8
    blue, green, red = cells.astype(np.intp)
    table: Pixels = palette.table.reshape(LEVELS, LEVELS, LEVELS)[np.ix_(red, green, blue)].reshape(
        -1
    )
    return np.concatenate((table, table))


_PLACES = np.array([1, LEVELS, LEVELS**2])  # of blue, green, red in the packed colour


def pack(pixels: Pixels) -> NDArray[np.int64]:
    """Pack colours to 15 bit, as OpenCV's BGR555.

    Args:
        pixels: shape (..., 3), BGR.

    Returns:
        Packed colours, shape (...).
    """
    packed: NDArray[np.int64] = (pixels.astype(np.int64) >> 3) @ _PLACES
    return packed


def learn_palette(
    samples: tuple[ColorSamples, ...], background: tuple[str, ...] = ("black", "floor")
) -> Palette:
    """Learn the classes from samples; colours far from all samples become class 0.

    Args:
        samples: of every colour; samples of one name are added up.
        background: names that compete with the others but are not searched for.

    Returns:
        The palette; its names are those of the samples, in order, without the background.

    Raises:
        VisionError: if a name has no pixels, or there are more than 255 names.
    """
    for sample in samples:
        if sample.pixels.ndim != 2 or sample.pixels.shape[1] != 3 or len(sample.pixels) == 0:
            raise VisionError(
                f"colour {sample.name}: need samples (N, 3), got shape {sample.pixels.shape}"
            )
    every = tuple(dict.fromkeys(sample.name for sample in samples))
    names = tuple(name for name in every if name not in background)
    if not 1 <= len(names) <= 255:
        raise VisionError(f"a palette has 1 to 255 colours, got {len(names)}")
    likelihood = np.full((1 + len(names), LEVELS**3), _CLUTTER / LEVELS**3)
    likelihood[1:] = [_density(samples, name) for name in names]
    for name in set(every) - set(names):
        likelihood[0] += _density(samples, name)
    means = [np.concatenate([s.pixels for s in samples if s.name == n]).mean(0) for n in names]
    return _palette(names, likelihood, np.array([np.zeros(3), *means]))


@lru_cache(maxsize=8)
def palette_from_colors(
    colors: tuple[NamedColor, ...],
    light: tuple[float, float] = (0.45, 1.15),
    noise: float = 3.0,
    background: tuple[str, ...] = ("black", "floor"),
) -> Palette:
    """Make a palette from nominal colours, by imagining how a camera shows them.

    Args:
        colors: under full light.
        light: darkest and brightest light, as factors of full light.
        noise: of the sensor, standard deviation [grey levels].
        background: names that compete with the others but are not searched for.

    Returns:
        The palette.

    Raises:
        VisionError: if the light range is not positive and ascending, or no colour is searched for.
    """
    if not 0.0 < light[0] <= light[1]:
        raise VisionError(f"light range {light[0]} to {light[1]}: need 0 < low <= high")
    samples = (ColorSamples(c.name, _imagined(c.bgr, light, noise)) for c in colors)
    return learn_palette(tuple(samples), background)


def _imagined(bgr: tuple[int, int, int], light: tuple[float, float], noise: float) -> Pixels:
    """Pixels of one colour under all lights, with chroma diluted by a neutral neighbour."""
    gain, dilution = np.meshgrid(np.linspace(*light, 48), np.linspace(0.65, 1.15, 11))
    ycc = gain.reshape(-1, 1) * (YCC_FROM_BGR @ np.array(bgr, float))
    ycc[:, 1:] *= dilution.reshape(-1, 1)
    clean = np.clip(ycc @ BGR_FROM_YCC.T, 0.0, 255.0)
    # Noise as a fixed cloud of points (a 3-D cross), so that the palette does not depend on luck.
    spread = 1.5 * noise * np.concatenate((np.zeros((2, 3)), np.eye(3), -np.eye(3)))
    cloud = clean[:, None] + spread
    pixels: Pixels = np.clip(np.rint(cloud), 0, 255).astype(np.uint8)
    return pixels.reshape(-1, 3)


def _density(samples: tuple[ColorSamples, ...], name: str) -> Floats:
    """Smoothed histogram of one colour over the packed colours, sum about 1."""
    pixels = np.concatenate([sample.pixels for sample in samples if sample.name == name])
    counts = np.bincount(pack(pixels), minlength=LEVELS**3) / len(pixels)
    cube = counts.reshape(LEVELS, LEVELS, LEVELS)
    for _ in range(3):  # along the first axis, which becomes the last
        cube = np.tensordot(cube, _smoothing(), axes=(0, 1))
    return cube.reshape(-1)


def _smoothing() -> Floats:
    """Gaussian of `_KERNEL_CELLS`, four cells to either side, as a matrix (LEVELS, LEVELS)."""
    weights = np.exp(-0.5 * (np.arange(-4, 5) / _KERNEL_CELLS) ** 2)
    weights /= weights.sum()
    bands = (weight * np.eye(LEVELS, k=k) for k, weight in enumerate(weights, start=-4))
    return np.asarray(sum(bands), np.float64)


def _palette(names: tuple[str, ...], likelihood: Floats, typical: Floats) -> Palette:
    """Turn likelihoods (classes, colours) into the table and the posterior."""
    posterior = np.ascontiguousarray((likelihood / likelihood.sum(axis=0)).T, np.float32)
    table = posterior.argmax(axis=1).astype(np.uint8)
    for array in (posterior, table, typical):
        array.flags.writeable = False
    return Palette(names, table, posterior, typical)


def _looked_up(table: Pixels, packed: NDArray[np.uint16]) -> Pixels:
    """Look up a table of 16 bit; OpenCV from version 5 does it in half the time."""
    if _WIDE_LUT:
        return np.asarray(cv2.LUT(packed, table.reshape(1, -1)), np.uint8)
    return table.take(packed)


def _has_wide_lut() -> bool:
    """Whether this OpenCV looks up 16-bit images."""
    try:
        cv2.LUT(np.zeros((2, 2), np.uint16), np.zeros((1, 65536), np.uint8))
    except cv2.error:
        return False
    return True


_WIDE_LUT = _has_wide_lut()
