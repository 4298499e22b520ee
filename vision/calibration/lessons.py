"""What named tags teach: pixels of every colour, and how far its robots agree on it."""

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from vision.calibration.rivals import Rival, Spread, compare_colors, confused_robots, spread_of
from vision.calibration.samples import draw_tag, floor_pixels, part_pixels, representative
from vision.eye import Eye
from vision.palette import ColorSamples

Floats = NDArray[np.float64]
Pixels = NDArray[np.uint8]

MOST_SAMPLES = 200  # of a colour that are kept
_MOST_OF_PART = 24  # pixels of one part of one tag


@dataclass(frozen=True, slots=True)
class Lesson:
    """A tag whose robot is beyond doubt.

    Attributes:
        frame: index of the picture.
        tag: index of the robot's tag in the set.
        pose: x, y, theta, shape (3,) [m, m, rad].
        light: on it, relative to the prints.
        colors: shape (K, 3), BGR of its parts as they would look without blur.
        margin: how much more any other robot would have cost there.
    """

    frame: int
    tag: int
    pose: Floats
    light: float
    colors: Floats
    margin: float


@dataclass(frozen=True, slots=True)
class Collected:
    """Pixels of a colour.

    Attributes:
        samples: those that are kept.
        count: how many there were.
    """

    samples: ColorSamples
    count: int


def collect(
    images: tuple[Pixels, ...], lessons: tuple[Lesson, ...], places: tuple[Floats, ...], eye: Eye
) -> tuple[Collected, ...]:
    """Collect pixels of every colour on the tags, and of the floor.

    Args:
        images: the pictures, each (H, W, 3), BGR.
        lessons: the tags.
        places: for every picture the poses (R, 3) of all tags in it, sure or not [m, m, rad].
        eye: camera and tags.

    Returns:
        One collection per colour in the order of the tag set, then that of "floor".
    """
    pixels: dict[str, list[Pixels]] = {color: [] for color in eye.tags.colors}
    for lesson in lessons:
        tag = eye.tags.tags[lesson.tag]
        inside = part_pixels(images[lesson.frame], eye.camera, draw_tag(tag), lesson.pose)
        for part, own, fitted in zip(tag.parts, inside, lesson.colors, strict=False):
            some = representative(own, _MOST_OF_PART)
            sharp = np.clip(np.rint(fitted), 0, 255).astype(np.uint8)
            pixels[part.color] += [some, np.tile(sharp, (max(len(some) // 4, 1), 1))]
    radius = eye.tags.outer_radius
    pixels["floor"] = [
        floor_pixels(image, eye.camera, poses, radius)
        for image, poses in zip(images, places, strict=True)
    ]
    found = {name: np.concatenate(parts) for name, parts in pixels.items() if parts}
    return tuple(
        Collected(ColorSamples(name, representative(every, MOST_SAMPLES)), len(every))
        for name, every in found.items()
    )


def find_rivals(lessons: tuple[Lesson, ...], eye: Eye) -> tuple[Rival, ...]:
    """Compare all pairs of colours.

    Args:
        lessons: the tags.
        eye: tags and names of colours.

    Returns:
        The pairs, the closest first.
    """
    spreads = [_spread(name, lessons, eye) for name in eye.palette.names]
    pairs = [
        Rival(
            eye.palette.names[i],
            eye.palette.names[j],
            compare_colors(spreads[i], spreads[j]),
            confused_robots(eye.tags, eye.palette.names[i], eye.palette.names[j]),
        )
        for i, j in combinations(range(len(spreads)), 2)
    ]
    return tuple(sorted(pairs, key=lambda rival: -rival.error))


def _spread(name: str, lessons: tuple[Lesson, ...], eye: Eye) -> Spread:
    """How one colour looks on all tags, in light 1."""
    seen = [
        np.maximum(color, 1.0) / lesson.light
        for lesson in lessons
        for part, color in zip(eye.tags.tags[lesson.tag].parts, lesson.colors, strict=False)
        if part.color == name
    ]
    return spread_of(np.array(seen))
