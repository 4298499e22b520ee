"""The renderer is a camera: it takes true states and yields what a `CameraModel` would deliver.

Tags are projected corner by corner and drawn by exact area coverage, never rounded to pixels. As a
lens blurs before pixels integrate, the scene is drawn on dots finer than the pixels, blurred, and
only then averaged. All this is linear in the coverages, so the lens blurs only the difference that
robots make to the floor, in small windows; the empty floor is blurred once. Only where something
else moves or shines is the whole scene composed and blurred anew.
"""

from dataclasses import replace
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from control.command import RobotId
from datasets.cycle import RobotState
from datasets.drawing import Drawing
from datasets.errors import SimulationError
from datasets.floor import Floor, paint_floor
from datasets.sensor import SensorModel, frame_number, linear_light
from datasets.surroundings import Painter, Surroundings
from vision.camera import CameraModel
from vision.palette import NamedColor
from vision.tags import TagSet

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Rectangle = tuple[slice, slice]

BLACK = NamedColor("black", (12, 12, 12))
_FINE = 2  # dots along a pixel's side
_BENT_PIECES = 4  # of every edge where a lens bends it: its bow is then below 0.002 px
_STEPS = 16  # points on each side of the image when its view of the floor is measured


_NOTHING = Surroundings()


class _Painted(NamedTuple):
    """Robots in their windows: inks (R, h, w, 3), plates (R, h, w), origins (R, 2), (h, w)."""

    inks: Singles
    plates: Singles
    origins: NDArray[np.intp]
    size: tuple[int, int]


class Renderer:
    """A camera above a floor with robots; the same seed and moment give the same picture."""

    def __init__(
        self,
        camera: CameraModel,
        tags: TagSet,
        colors: tuple[NamedColor, ...],
        sensor: SensorModel,
        seed: int = 0,
        floor: Floor | None = None,
        surroundings: Surroundings = _NOTHING,
    ) -> None:
        """Paint, light and blur the empty floor.

        Args:
            camera: where it hangs and how it projects.
            tags: what the robots wear.
            colors: how the tags' colours look under full light; black need not be given.
            sensor: what the camera does to the light.
            seed: of noise, floor and clutter, >= 0.
            floor: how the floor looks, by default dark with a field's lines.
            surroundings: what else is in view, and what it does to the light.

        Raises:
            SimulationError: if a tag has a colour that is not given.
        """
        self._colors = {c.name: _linear(c.bgr, sensor.gamma) for c in (BLACK, *colors)}
        missing = [color for color in tags.colors if color not in self._colors]
        if missing:
            raise SimulationError(f"tags use {missing}, but only {list(self._colors)} are given")
        width, height = camera.size_px
        self._camera = fine = camera.scaled_to((_FINE * width, _FINE * height))
        self._sensor = optics = replace(sensor, blur_px=_FINE * sensor.blur_px)
        self._shutter = sensor.shutter(_FINE * height)
        self._tags = {tag.robot_id: tag for tag in tags.tags}
        self._drawings: dict[tuple[RobotId, ...], Drawing] = {}
        self._low, self._high = _seen_floor(camera, tags.outer_radius)
        self._stages = (*sensor.lens(camera), *sensor.stages(camera.size_px, seed))
        self._margin = margin = -(-optics.blur_radius // _FINE) * _FINE
        self._light = light = sensor.light(fine.size_px, margin)[..., None]
        self._painter = Painter(surroundings, fine, optics, light, margin, seed)
        paint = _in_linear_light(floor or Floor(), sensor.gamma)
        self._sharp = paint_floor(fine, paint, margin, seed) * light
        self._painter.ground(self._sharp, 0.0, standing=True)
        self._empty = self._through_lens(self._sharp)

    def render(self, states: tuple[RobotState, ...], t: float) -> NDArray[np.uint8]:
        """Take a picture.

        Args:
            states: true states at the moment of capture, the middle of the exposure of the middle
                row; where bodies overlap, the earlier robot hides the later one.
            t: moment of capture; it numbers the frame for all that is random [s].

        Returns:
            Shape (H, W, 3), BGR, read-only.

        Raises:
            SimulationError: if a robot wears no tag or a state is not finite.
        """
        image, frame = self.light(states, t), frame_number(t)
        for stage in self._stages:
            image = stage(image, frame)
        picture: NDArray[np.uint8] = image.astype(np.uint8, copy=False)
        picture.flags.writeable = False
        return picture

    def light(self, states: tuple[RobotState, ...], t: float) -> Singles:
        """What falls on the pixels, before anything that the sensor does to it.

        Args:
            states: as for `render`.
            t: moment of capture [s].

        Returns:
            Shape (H, W, 3), linear in the light, of 255.

        Raises:
            SimulationError: if a robot wears no tag or a state is not finite.
        """
        robots = self._paint(self._in_view(states))
        return self._calm(robots) if self._painter.still else self._busy(robots, t)

    def _in_view(self, states: tuple[RobotState, ...]) -> tuple[RobotState, ...]:
        """Robots that may appear; beyond the seen floor a lens model means nothing."""
        for state in states:
            if state.robot_id not in self._tags:
                raise SimulationError(f"robot {state.robot_id} wears no tag")
            if not np.isfinite(_motion(state)).all():
                raise SimulationError(f"robot {state.robot_id} to be rendered is at {state.state}")
        (x0, y0), (x1, y1) = self._low, self._high
        return tuple(s for s in states if x0 < s.state.x < x1 and y0 < s.state.y < y1)

    def _paint(self, states: tuple[RobotState, ...]) -> _Painted | None:
        """Draw the robots into windows, moving while the shutter is open."""
        if not states:
            return None
        drawing = self._drawing(tuple(state.robot_id for state in states))
        motions = np.array([_motion(state) for state in states])
        views = drawing.views(motions, self._camera, self._shutter) + 0.5  # to corner coordinates
        origins, size = drawing.windows(views, self._margin, _FINE)
        return _Painted(*drawing.painted(views, origins, size), origins, size)

    def _calm(self, robots: _Painted | None) -> Singles:
        """Add to the empty picture what the robots change."""
        image = self._empty.copy()
        if robots is None:
            return image
        size = robots.size
        change = np.zeros(robots.inks.shape, np.float32)
        for index, origin in enumerate(robots.origins + self._margin):
            there, here = _overlap(origin, size, self._sharp.shape)
            ink, plate = robots.inks[index][here], robots.plates[index][here][..., None]
            change[index][here] = ink * self._light[there] - plate * self._sharp[there]
        pixels = (size[0] // _FINE, size[1] // _FINE)
        seen = _averaged(self._sensor.blur(change.reshape(-1, size[1], 3)))
        seen = seen.reshape(len(change), *pixels, 3)
        for index, origin in enumerate(robots.origins // _FINE):
            there, here = _overlap(origin, pixels, image.shape)
            image[there] += seen[index][here]
        return image

    def _busy(self, robots: _Painted | None, t: float) -> Singles:
        """Compose the whole scene, then look at it through the lens."""
        ground = self._sharp.copy()
        self._painter.ground(ground, t, standing=False)
        scene = ground.copy()
        if robots is not None:
            for index, origin in enumerate(robots.origins + self._margin):
                there, here = _overlap(origin, robots.size, scene.shape)
                ink, plate = robots.inks[index][here], robots.plates[index][here][..., None]
                scene[there] += ink * self._light[there] - plate * ground[there]
        self._painter.above(scene, t)
        return self._through_lens(scene)

    def _through_lens(self, scene: Singles) -> Singles:
        """Blur a scene with its margins, and cut them off."""
        margin = self._margin
        inside = slice(margin, scene.shape[0] - margin), slice(margin, -margin or None)
        return _averaged(self._sensor.blur(scene)[inside])

    def _drawing(self, ids: tuple[RobotId, ...]) -> Drawing:
        """The polygons of some robots, made once."""
        if ids not in self._drawings:
            tags, bent = tuple(self._tags[i] for i in ids), any(self._camera.distortion)
            self._drawings[ids] = Drawing(tags, self._colors, _BENT_PIECES if bent else 1)
        return self._drawings[ids]


def _averaged(dots: Singles) -> Singles:
    """Pixels, as means of their dots."""
    height, width = dots.shape[0] // _FINE, dots.shape[1] // _FINE
    small = cv2.resize(dots, (width, height), interpolation=cv2.INTER_AREA)
    return np.asarray(small, np.float32)


def _motion(robot: RobotState) -> tuple[float, float, float, float, float]:
    """x, y, theta, v, omega of a robot."""
    s = robot.state
    return s.x, s.y, s.theta, s.v, s.omega


def _linear(bgr: tuple[float, float, float], gamma: float) -> tuple[float, float, float]:
    """The light of a colour that the camera shows as `bgr`."""
    blue, green, red = linear_light(bgr, gamma).tolist()
    return blue, green, red


def _in_linear_light(floor: Floor, gamma: float) -> Floor:
    """The floor's light instead of its look."""
    return replace(floor, bgr=_linear(floor.bgr, gamma), line_bgr=_linear(floor.line_bgr, gamma))


def _overlap(
    origin: NDArray[np.intp], size: tuple[int, int], shape: tuple[int, ...]
) -> tuple[Rectangle, Rectangle]:
    """The part of a window inside an image: in the image's indices and in the window's."""
    there, here = [], []
    for first, length, limit in zip(origin[::-1], size, shape, strict=False):
        low, high = min(max(first, 0), limit), min(max(first + length, 0), limit)
        there.append(slice(low, high))
        here.append(slice(low - first, high - first))
    return (there[0], there[1]), (here[0], here[1])


def _seen_floor(camera: CameraModel, radius: float) -> tuple[Floats, Floats]:
    """Least and greatest x, y of tags that may show, shape (2,) each [m]."""
    width, height = camera.size_px
    along = np.linspace(0.0, 1.0, _STEPS)
    rims = np.repeat((0.0, 1.0), _STEPS)
    border = np.column_stack((np.tile(along, 4), np.tile(rims, 2)))
    border[2 * _STEPS :] = border[2 * _STEPS :, ::-1]
    seen = camera.to_floor(border * (width, height) - 0.5, camera.tag_height)
    reach = 2.0 * radius
    return np.nanmin(seen, axis=0) - reach, np.nanmax(seen, axis=0) + reach
