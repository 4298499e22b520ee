"""How much light is collected: steps and drifts of exposure and white balance, flickering lamps."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from datasets.sensor.shutter import Shutter
from datasets.sensor.stage import Image, frame_time

Floats = NDArray[np.float64]

FULL = 255.0  # brightest level, and the level of a full photosite


@dataclass(frozen=True, slots=True)
class Change:
    """From a moment on the channels have other gains; they last until the next change.

    Attributes:
        at: when it begins [s].
        gains: factors of blue, green and red, >= 0; 1 is the state at the start.
        duration: of a slow drift towards the new gains; 0: a step [s].
    """

    at: float
    gains: tuple[float, float, float]
    duration: float = 0.0


@dataclass(frozen=True, slots=True)
class Flicker:
    """A lamp on the mains: 1 + depth cos(2 pi frequency t).

    Attributes:
        depth: 0 none, 1 dark once a period.
        frequency: of the light, twice that of the mains [Hz].
    """

    depth: float = 0.0
    frequency: float = 100.0

    def mean(self, t: Floats, exposure: float) -> Floats:
        """Average brightness over exposures.

        Args:
            t: shape (N,), middles of the exposures [s].
            exposure: how long each lasts [s].

        Returns:
            Shape (N,).
        """
        left = self.depth * np.sinc(self.frequency * exposure)
        return np.asarray(1.0 + left * np.cos(2.0 * np.pi * self.frequency * t))


def gains_at(changes: tuple[Change, ...], t: Floats) -> Floats:
    """The gains that changes have led to.

    Args:
        changes: one after the other.
        t: shape (N,) [s].

    Returns:
        Shape (N, 3), BGR.
    """
    gains = np.ones((len(t), 3))
    for change in changes:
        late = t - change.at
        share = np.clip(late / change.duration, 0.0, 1.0) if change.duration else late >= 0.0
        gains += np.asarray(share, float)[:, None] * (change.gains - gains)
    return gains


class Exposure:
    """Light collected by every row: what lamp, iris and exposure control do, in linear light."""

    def __init__(self, changes: tuple[Change, ...], flicker: Flicker, shutter: Shutter) -> None:
        """Remember how the light goes.

        Args:
            changes: of lamp, iris or exposure, one after the other.
            flicker: of the lamp.
            shutter: when the rows are exposed.
        """
        self._changes, self._flicker, self._shutter = changes, flicker, shutter
        rows = np.arange(shutter.rows if shutter.readout else 1, dtype=float)
        middle = 0.0 if len(rows) == 1 else shutter.row_offset(rows)
        self._offsets = np.broadcast_to(middle, rows.shape)

    def __call__(self, image: Image, frame: int) -> Image:
        """Collect the light.

        Args:
            image: float32, shape (H, W, 3), linear light.
            frame: its number.

        Returns:
            The image as bright as it is collected, same shape; may exceed 255.
        """
        t = frame_time(frame) + self._offsets
        rows = self._flicker.mean(t, self._shutter.exposure)[:, None] * gains_at(self._changes, t)
        return np.multiply(image, rows[:, None].astype(np.float32), out=image)


class WhiteBalance:
    """Gains of the channels behind the photosites; what was full stays full, and turns coloured."""

    def __init__(self, changes: tuple[Change, ...]) -> None:
        """Remember the gains.

        Args:
            changes: of the gains, one after the other.
        """
        self._changes = changes

    def __call__(self, image: Image, frame: int) -> Image:
        """Amplify.

        Args:
            image: float32, shape (H, W, 3), linear light.
            frame: its number.

        Returns:
            The amplified image, same shape.
        """
        gains = gains_at(self._changes, np.array([frame_time(frame)]))
        full = np.minimum(image, np.float32(FULL), out=image)
        return np.multiply(full, gains.astype(np.float32), out=full)
