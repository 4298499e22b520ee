"""What else is in the room: clutter, hands, cables, shadows and glare, and how they are painted."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from datasets.clutter import Clutter
from datasets.lights import Glare, Shadow
from datasets.paths import Waypoints
from datasets.sensor import SensorModel, linear_light
from datasets.things import Thing
from vision.camera import CameraModel

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class Surroundings:
    """Everything in view that is neither floor nor robot.

    Attributes:
        things: on the floor, or above the robots; later ones hide earlier ones.
        clutter: strewn over the seen floor.
        shadows: that fall on everything but things above the robots.
        glares: mirror images of lamps.
    """

    things: tuple[Thing, ...] = ()
    clutter: Clutter | None = None
    shadows: tuple[Shadow, ...] = ()
    glares: tuple[Glare, ...] = ()


class Painter:
    """Paints surroundings into a picture in linear light, before the lens.

    Attributes:
        still: whether nothing changes from frame to frame.
    """

    def __init__(
        self,
        surroundings: Surroundings,
        camera: CameraModel,
        sensor: SensorModel,
        light: Singles,
        margin: int,
        seed: int,
    ) -> None:
        """Strew the clutter, work out what never changes.

        Args:
            surroundings: what there is.
            camera: who looks.
            sensor: its shutter and tone curve.
            light: of the lamp, shape (H + 2 margin, W + 2 margin, 1).
            margin: further pixels on every side [px].
            seed: of the clutter, >= 0.
        """
        self._camera, self._gamma, self._light = camera, sensor.gamma, light
        self._shutter = sensor.shutter(camera.size_px[1])
        self._margin = margin
        things = surroundings.things
        if surroundings.clutter is not None:
            low, high = _seen_box(camera)
            things = (*surroundings.clutter.things(low, high, seed), *things)
        self._under = tuple(t for t in things if t.height <= camera.tag_height)
        self._over = tuple(t for t in things if t.height > camera.tag_height)
        self._shadows, self._glare = surroundings.shadows, np.zeros(light.shape, np.float32)
        self._floor = np.zeros((0, 0, 2), np.float32)
        if surroundings.shadows or surroundings.glares:
            self._floor = _floor_points(camera, margin)
        for glare in surroundings.glares:
            self._glare += glare.light(self._floor)[..., None]
        moving = [thing for thing in self._under if not _stands(thing)]
        self.still = not (moving or self._over or self._shadows or surroundings.glares)

    def ground(self, image: Singles, t: float, standing: bool) -> None:
        """Paint what lies on the floor.

        Args:
            image: of the lamplit floor with its margins, shape (H, W, 3); changed in place.
            t: moment of the frame [s].
            standing: whether to paint what never moves, or what does.
        """
        self._lay(image, tuple(thing for thing in self._under if _stands(thing) == standing), t)

    def above(self, image: Singles, t: float) -> None:
        """Shade, add glare, and cover with what is above the robots.

        Args:
            image: with robots and margins, shape (H, W, 3); changed in place.
            t: moment of the frame [s].
        """
        for shadow in self._shadows:
            image *= shadow.light(self._floor, t)[..., None]
        image += self._glare
        self._lay(image, self._over, t)

    def _lay(self, image: Singles, things: tuple[Thing, ...], t: float) -> None:
        for thing in things:
            seen = thing.mask(self._camera, self._shutter, t, self._margin, image.shape[:2])
            if seen is not None:
                window, covered = seen
                color = linear_light(thing.bgr, self._gamma).astype(np.float32)
                part = image[window]
                part += covered[..., None] * (color * self._light[window] - part)


def _stands(thing: Thing) -> bool:
    """Whether a thing is always there, at one place."""
    lasting = not (np.isfinite(thing.begin) or np.isfinite(thing.end))
    return lasting and isinstance(thing.path, Waypoints) and len(thing.path.times) == 1


def _floor_points(camera: CameraModel, margin: int) -> Singles:
    """Floor point of every pixel, margins included, shape (H, W, 2) [m]."""
    width, height = camera.size_px
    rows, columns = np.indices((height + 2 * margin, width + 2 * margin)) - margin
    pixels = np.column_stack((columns.ravel(), rows.ravel())).astype(float)
    return np.asarray(camera.to_floor(pixels, 0.0).reshape(*rows.shape, 2), np.float32)


def _seen_box(camera: CameraModel) -> tuple[Floats, Floats]:
    """Least and greatest x, y of the image's corners on the floor, shape (2,) each [m]."""
    width, height = camera.size_px
    corners = np.array([[0, 0], [width, 0], [width, height], [0, height]], float) - 0.5
    seen = camera.to_floor(corners, 0.0)
    return np.nanmin(seen, axis=0), np.nanmax(seen, axis=0)
