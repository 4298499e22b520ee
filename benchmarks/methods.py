"""What is compared: this project's two ways of looking, what others use, and the floors."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from importlib.util import find_spec
from itertools import cycle

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks import peers
from benchmarks.field import (
    COLORS,
    draw,
    make_camera,
    make_field,
    predicted,
    strewn,
    three_patch,
    two_patch,
)
from benchmarks.markers import APRILTAG, ARUCO, printed
from benchmarks.timing import Call
from datasets.render import Renderer
from datasets.sensor import SensorModel
from vision.eye import Eye
from vision.frame import Frame
from vision.locate import Prediction, locate
from vision.tags import TagSet

Floats = NDArray[np.float64]

SENSOR = SensorModel(read_noise=3.0, blur_px=0.6, uneven_light=0.3, chroma="420")  # of `paper`


@dataclass(frozen=True, slots=True)
class Setting:
    """One size of pictures with a number of robots.

    Attributes:
        size_px: width and height [px].
        robots: how many.
        frames: pictures for the errors, all different.
        rounds: calls for the times.
        crowd: many robots: only tracking, on tags with three patches.
    """

    size_px: tuple[int, int]
    robots: int
    frames: int
    rounds: int
    crowd: bool = False

    @property
    def tags(self) -> TagSet:
        """What the robots wear."""
        return three_patch(self.robots) if self.crowd else two_patch(self.robots)


@dataclass(frozen=True, slots=True)
class Shot:
    """A picture, its truth and what an estimator would expect.

    Attributes:
        frame: the picture.
        poses: shape (R, 3), of robots 1 to R [m, m, rad].
        expected: one prediction per robot.
    """

    frame: Frame
    poses: Floats
    expected: tuple[Prediction, ...]


Look = Callable[[Shot], peers.Sightings]


@dataclass(frozen=True, slots=True)
class Method:
    """A way of looking at robots with some tags.

    Attributes:
        name: of the method.
        tags: what the robots wear.
        look: the call that is timed; None: it could not be run.
    """

    name: str
    tags: TagSet
    look: Look | None


def shots(setting: Setting, tags: TagSet) -> Iterator[Shot]:
    """Robots at new places in every picture; the same places for all tags.

    Args:
        setting: size and numbers.
        tags: what the robots wear.

    Yields:
        The pictures.
    """
    camera, rng = make_camera(setting.size_px), np.random.default_rng(1)
    renderer = Renderer(camera, tags, COLORS, SENSOR)
    for number in range(setting.frames):
        poses = strewn(camera, setting.tags.outer_radius, setting.robots, rng)
        frame = draw(renderer, tags.ids, poses, number)
        yield Shot(frame, poses, predicted(tags.ids, poses, rng))


def own_methods(setting: Setting, eye: Eye) -> list[Method]:
    """This project's ways of looking.

    Args:
        setting: size and numbers.
        eye: for the setting's tags.

    Returns:
        Full search and tracking; of a crowd only tracking.
    """

    def look(shot: Shot, tracked: bool) -> peers.Sightings:
        scene = locate(shot.frame, eye, shot.expected if tracked else ())
        poses = ((d.robot_id, d.pose) for d in scene.detections)
        return [(robot_id, np.array((p.x, p.y, p.theta))) for robot_id, p in poses]

    both = [
        Method("echelon, full search", setting.tags, partial(look, tracked=False)),
        Method("echelon, tracked", setting.tags, partial(look, tracked=True)),
    ]
    return both[1:] if setting.crowd else both


def peer_methods(setting: Setting) -> list[Method]:
    """What others use.

    Args:
        setting: size and numbers.

    Returns:
        Printed codes and typed colour ranges; of a crowd nothing.
    """
    if setting.crowd:
        return []
    camera, count, colored = make_camera(setting.size_px), setting.robots, setting.tags
    april = peers.apriltag(camera) if find_spec("pupil_apriltags") else None
    looks = [
        ("cv2.aruco 4x4, default", printed(ARUCO, count), peers.aruco(camera, tuned=False)),
        ("cv2.aruco 4x4, tuned, sub-pixel", printed(ARUCO, count), peers.aruco(camera, tuned=True)),
        ("pupil-apriltags 36h11", printed(APRILTAG, count), april),
        ("HSV ranges and contours", colored, peers.hsv(camera, colored)),
    ]
    return [Method(name, tags, _at_picture(look) if look else None) for name, tags, look in looks]


def floors(eye: Eye, some: Sequence[Shot]) -> list[tuple[str, Call]]:
    """What no search of the whole picture can do without.

    Args:
        eye: whose colours are looked up.
        some: pictures.

    Returns:
        Names and calls: copying, packing and looking up, connected components.
    """
    images = cycle([shot.frame.image for shot in some])
    masks = cycle([eye.palette.classify(shot.frame.image) for shot in some])
    return [
        ("floor: copy of the frame", lambda: next(images).copy()),
        ("floor: pack to 15 bit and look up", lambda: eye.palette.classify(next(images))),
        (
            "floor: connected components, 16 bit",
            lambda: cv2.connectedComponentsWithStats(next(masks), connectivity=8, ltype=cv2.CV_16U),
        ),
    ]


def in_turn(look: Look, some: Sequence[Shot]) -> Call:
    """A call that looks at one picture after the other.

    Args:
        look: at a picture.
        some: pictures.

    Returns:
        The call.
    """
    turn = cycle(some)
    return lambda: look(next(turn))


def make_eye_for(setting: Setting) -> Eye:
    """The eye for a setting.

    Args:
        setting: size and numbers.

    Returns:
        The eye.
    """
    return make_field(make_camera(setting.size_px), setting.tags, SENSOR).eye


def _at_picture(look: peers.Look) -> Look:
    return lambda shot: look(shot.frame.image)
