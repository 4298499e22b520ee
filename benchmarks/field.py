"""Robots strewn over a field, a camera that draws them, and an eye that looks for them."""

from dataclasses import dataclass
from functools import cache
from itertools import product

import numpy as np
from numpy.typing import NDArray

from control.command import RobotId
from control.geometry import Pose2D
from control.unicycle import UnicycleState
from datasets.cycle import RobotState
from datasets.floor import Floor
from datasets.render import Renderer
from datasets.sensor import SensorModel
from vision.camera import CameraModel, overhead_camera
from vision.eye import Eye, make_eye
from vision.frame import Frame, as_frame
from vision.locate import Prediction
from vision.optics import ChromaModel, Optics
from vision.palette import NamedColor, Palette, palette_from_colors
from vision.tags import Layout, Part, TagSet, polygon_array

Floats = NDArray[np.float64]

SIDE = 0.075  # of a plate [m]
MOUNT, TAG_HEIGHT = 2.5, 0.075  # of the camera and the tags above the floor [m]
COLORS = (
    NamedColor("black", (12, 12, 12)),
    NamedColor("yellow", (30, 225, 255)),
    NamedColor("red", (40, 20, 190)),
    NamedColor("green", (40, 140, 15)),
    NamedColor("blue", (210, 70, 30)),
    NamedColor("magenta", (180, 30, 200)),
    NamedColor("cyan", (180, 155, 10)),
    NamedColor("orange", (10, 110, 235)),
    NamedColor("violet", (200, 40, 110)),
    NamedColor("white", (230, 235, 233)),  # of printed codes
)
OFF = np.array([0.001, 0.001, np.radians(1.0)])  # of predictions, standard deviation [m, m, rad]


@dataclass(frozen=True, slots=True)
class Field:
    """A camera that draws robots, and an eye that knows its sharpness and noise.

    Attributes:
        eye: who looks.
        renderer: who draws.
        sensor: what happens to the pictures.
    """

    eye: Eye
    renderer: Renderer
    sensor: SensorModel

    def picture(self, poses: Floats, number: int) -> Frame:
        """Draw the robots.

        Args:
            poses: shape (R, 3), of the robots in the order of the tags [m, m, rad].
            number: of the frame; its noise depends on it.

        Returns:
            The frame.
        """
        return draw(self.renderer, self.eye.tags.ids, poses, number)

    def predictions(self, poses: Floats, rng: np.random.Generator) -> tuple[Prediction, ...]:
        """What an estimator would expect: the truth, off by `OFF`.

        Args:
            poses: shape (R, 3), true [m, m, rad].
            rng: source of the errors.

        Returns:
            One prediction per robot.
        """
        return predicted(self.eye.tags.ids, poses, rng)


def draw(renderer: Renderer, ids: tuple[RobotId, ...], poses: Floats, number: int) -> Frame:
    """Take a picture of robots.

    Args:
        renderer: the camera.
        ids: of R robots.
        poses: shape (R, 3) [m, m, rad].
        number: of the frame; its noise depends on it.

    Returns:
        The frame.
    """
    states = tuple(
        RobotState(robot_id, UnicycleState(x, y, theta, 0.0, 0.0))
        for robot_id, (x, y, theta) in zip(ids, poses.tolist(), strict=True)
    )
    return as_frame(renderer.render(states, number / 30.0), number / 30.0, number)


def predicted(
    ids: tuple[RobotId, ...], poses: Floats, rng: np.random.Generator
) -> tuple[Prediction, ...]:
    """What an estimator would expect: the truth, off by `OFF`.

    Args:
        ids: of R robots.
        poses: shape (R, 3), true [m, m, rad].
        rng: source of the errors.

    Returns:
        One prediction per robot.
    """
    near = poses + rng.standard_normal(poses.shape) * OFF
    return tuple(
        Prediction(robot_id, Pose2D(x, y, theta), np.diag(OFF**2))
        for robot_id, (x, y, theta) in zip(ids, near.tolist(), strict=True)
    )


def make_field(
    camera: CameraModel, tags: TagSet, sensor: SensorModel, floor: Floor | None = None
) -> Field:
    """Build a field whose eye knows the sensor.

    Args:
        camera: where it hangs.
        tags: what the robots wear.
        sensor: what the camera does to the light.
        floor: how the floor looks, the renderer's own if None.

    Returns:
        The field.
    """
    palette = _palette(tags.colors, sensor.read_noise)
    chroma = ChromaModel(sensor.chroma, sensor.chroma_offset_px, sensor.chroma_upsampling)
    eye = make_eye(camera, tags, palette, Optics(sensor.blur_px, sensor.read_noise, chroma))
    return Field(eye, Renderer(camera, tags, COLORS, sensor, 0, floor), sensor)


@cache
def _palette(names: tuple[str, ...], noise: float) -> Palette:
    used = tuple(color for color in COLORS if color.name in names)
    return palette_from_colors(used, noise=max(noise, 1.0))


def make_camera(size_px: tuple[int, int], field_width: float = 2.4) -> CameraModel:
    """A camera 2.5 m above the field.

    Args:
        size_px: width and height of the image [px].
        field_width: width of the floor it sees [m].

    Returns:
        The camera.
    """
    return overhead_camera(size_px, field_width, (0.5, 0.4), MOUNT, TAG_HEIGHT)


def strewn(camera: CameraModel, radius: float, count: int, rng: np.random.Generator) -> Floats:
    """Poses at random: robots wholly in the picture, none touching another.

    Args:
        camera: that looks straight down.
        radius: of a tag, to its farthest corner [m].
        count: of robots, R.
        rng: source of the poses.

    Returns:
        Shape (R, 3), x, y, theta [m, m, rad].
    """
    rims = np.array([(-0.5, -0.5), np.array(camera.size_px) - 0.5])
    seen = np.sort(camera.to_floor(rims, camera.tag_height), axis=0)
    low, high = seen[0] + radius, seen[1] - radius
    places = np.empty((0, 2))
    while len(places) < count:
        place = rng.uniform(low, high)
        if (np.hypot(*(places - place).T) > 2.05 * radius).all():
            places = np.vstack((places, place))
    return np.column_stack((places, rng.uniform(-np.pi, np.pi, count)))


def box(x0: float, x1: float, y0: float, y1: float) -> Floats:
    """An axis-parallel rectangle.

    Args:
        x0: rear [mm].
        x1: front [mm].
        y0: right [mm].
        y1: left [mm].

    Returns:
        Its corners, shape (4, 2) [m].
    """
    return polygon_array(np.array([[x1, y1], [x0, y1], [x0, y0], [x1, y0]]) * 1e-3)


TWO_PATCH = Layout(
    "two_patch",
    (
        Part("plate", box(-37.5, 37.5, -37.5, 37.5), "black"),
        Part("front", box(3, 32, -32, 32), "$front"),
        Part("rear", box(-32, -3, -32, 32), "$rear"),
    ),
)


THREE_PATCH = Layout(
    "three_patch",
    (
        Part("plate", box(-37.5, 37.5, -37.5, 37.5), "black"),
        Part("front", box(3, 32, -32, 32), "$front"),
        Part("left", box(-32, -3, 3, 32), "$left"),
        Part("right", box(-32, -3, -32, -3), "$right"),
    ),
    mirror_twins=True,
)
FRONTS = ("yellow", "cyan")
REARS = ("red", "green", "blue", "magenta", "orange", "violet")


@cache
def two_patch(count: int) -> TagSet:
    """Robots told apart by a patch in front and one behind.

    Args:
        count: of robots, at most 12.

    Returns:
        Their tags.
    """
    pairs = enumerate(product(FRONTS, REARS), 1)
    worn = (TWO_PATCH.worn_by(n, (("$front", f), ("$rear", r))) for n, (f, r) in pairs)
    return TagSet(tuple(worn)[:count])


@cache
def three_patch(count: int) -> TagSet:
    """Robots told apart by a patch in front and two behind.

    With two patches both of which vary, a tag turned by 180 deg would be that of another robot.

    Args:
        count: of robots, at most 72.

    Returns:
        Their tags.
    """
    triples = enumerate(product(FRONTS, REARS, REARS), 1)
    worn = (
        THREE_PATCH.worn_by(n, (("$front", f), ("$left", a), ("$right", b)))
        for n, (f, a, b) in triples
    )
    return TagSet(tuple(worn)[:count], mirror_twins=True)
