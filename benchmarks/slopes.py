"""Noise-free pictures of a tag and their slopes, taken from the renderer itself.

What a renderer paints is linear in the colours. A tag with three parts in blue, green and red
thus shows at once how much every pixel sees of each; what it sees of none of them is floor.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import ceil

import numpy as np
from numpy.typing import NDArray

from control.unicycle import UnicycleState
from datasets.cycle import RobotState
from datasets.floor import Floor
from datasets.render import Renderer
from datasets.sensor import SensorModel
from vision.camera import CameraModel
from vision.palette import NamedColor
from vision.tags import Tag, TagSet

Floats = NDArray[np.float64]
Window = tuple[int, int, int, int]

_AROUND_PX = 3  # of floor seen around the tag, beyond the reach of the lens
_STEP_PX = 0.02  # of the derivative; a picture has some 1e-5 grey levels of rounding
_NO_FLOOR = Floor((0.0, 0.0, 0.0), texture=0.0, line_width=0.0)
_PURE = ((255, 0, 0), (0, 255, 0), (0, 0, 255))  # BGR


@dataclass(frozen=True, slots=True)
class Slopes:
    """A noise-free picture around a tag, in B blocks of 2 x 2 pixels.

    Attributes:
        picture: shape (B, 12), brightness of pixel and channel: pixels row by row, BGR in each.
        by_pose: shape (B, 12, 3), its derivative by x, y, theta [per m, per m, per rad].
        by_color: shape (B, 12, 3 (K + 1)), by blue, green and red of all parts and the floor.
        window: first column and row, width and height of the blocks in the picture [px], all even.
    """

    picture: Floats
    by_pose: Floats
    by_color: Floats
    window: Window


class Views:
    """How much of every part of a tag the pixels see, under even light."""

    def __init__(self, tag: Tag, camera: CameraModel, sensor: SensorModel) -> None:
        """Dress the tag in pure colours, three parts at a time.

        Args:
            tag: of K parts; its colours do not matter.
            camera: who looks.
            sensor: its lens.
        """
        self.tag, self.camera = tag, camera
        self._around = ceil(4.0 * sensor.blur_px) + _AROUND_PX
        optics = SensorModel(0.0, sensor.blur_px, chroma="444")
        self._renderers = [
            _dressed(tag, first, camera, optics) for first in range(0, len(tag.parts), 3)
        ]

    def visible(self, pose: Floats, window: Window) -> Floats:
        """Look at the tag.

        Args:
            pose: shape (3,), x, y, theta [m, m, rad].
            window: first column and row, width and height [px].

        Returns:
            Share of every pixel that shows each part, and last the floor, shape (h, w, K + 1).
        """
        column, row, width, height = window
        x, y, theta = pose.tolist()
        robot = RobotState(self.tag.robot_id, UnicycleState(x, y, theta, 0.0, 0.0))
        seen = [
            renderer.light((robot,), 0.0)[row : row + height, column : column + width]
            for renderer in self._renderers
        ]
        parts = np.concatenate(seen, axis=2)[..., : len(self.tag.parts)] / 255.0
        return np.concatenate((parts, 1.0 - parts.sum(axis=2, keepdims=True)), axis=2)

    def around(self, pose: Floats) -> Window:
        """A window around the tag.

        Args:
            pose: shape (3,), x, y, theta [m, m, rad].

        Returns:
            First column and row, width and height [px], all even.
        """
        c, s = np.cos(pose[2]), np.sin(pose[2])
        corners = np.vstack([part.polygon for part in self.tag.parts])
        places = corners @ np.array([[c, s], [-s, c]]) + pose[:2]
        height = np.full(len(places), self.camera.tag_height)
        pixels = self.camera.project(np.column_stack((places, height))) + 0.5
        low = np.floor(pixels.min(axis=0)).astype(int) - self._around
        low -= low % 2
        size = np.ceil(pixels.max(axis=0)).astype(int) + self._around - low
        size += size % 2
        return int(low[0]), int(low[1]), int(size[0]), int(size[1])


def make_slopes(
    views: Views,
    pose: Floats,
    worn: Sequence[str],
    colors: tuple[NamedColor, ...],
    floor_bgr: tuple[float, float, float],
) -> Slopes:
    """Differentiate the noise-free picture of a tag on a floor of one colour.

    Args:
        views: of the tag.
        pose: shape (3,), x, y, theta [m, m, rad].
        worn: names of the colours of its parts.
        colors: how they look.
        floor_bgr: colour of the floor, of 255.

    Returns:
        The picture and its slopes.
    """
    bgr = {color.name: color.bgr for color in colors}
    palette = np.array([bgr[name] for name in worn] + [floor_bgr], float)
    window, steps = views.around(pose), _steps(views, pose)
    seen = views.visible(pose, window)
    changes = [
        (views.visible(pose + step, window) - views.visible(pose - step, window)) / step.sum()
        for step in np.diag(steps)
    ]
    by_pose = 0.5 * np.stack(changes, axis=-2) @ palette  # (h, w, 3, BGR)
    by_color = np.einsum("hwk,cd->hwckd", seen, np.eye(3)).reshape(*seen.shape[:2], 3, -1)
    return Slopes(
        in_blocks((seen @ palette)[..., None])[..., 0],
        in_blocks(by_pose.swapaxes(2, 3)),
        in_blocks(by_color),
        window,
    )


def in_blocks(image: Floats) -> Floats:
    """Sort a picture, or its slopes, into blocks of 2 x 2 pixels.

    Args:
        image: shape (h, w, 3, P), h and w even.

    Returns:
        Shape (B, 12, P).
    """
    h, w, _, slopes = image.shape
    sorted_ = image.reshape(h // 2, 2, w // 2, 2, 3, slopes).transpose(0, 2, 1, 3, 4, 5)
    return np.ascontiguousarray(sorted_).reshape(-1, 12, slopes)


def _dressed(tag: Tag, first: int, camera: CameraModel, optics: SensorModel) -> Renderer:
    """A renderer to which part `first` and the next two are pure colours, all others black."""
    names = [f"part {n}" for n in range(len(tag.parts))]
    parts = [replace(part, color=name) for part, name in zip(tag.parts, names, strict=True)]
    pure = dict(zip(names[first : first + 3], _PURE, strict=False))
    colors = tuple(NamedColor(name, pure.get(name, (0, 0, 0))) for name in names)
    tags = TagSet((Tag(tag.robot_id, tuple(parts)),), mirror_twins=True)
    return Renderer(camera, tags, colors, optics, floor=_NO_FLOOR)


def _steps(views: Views, pose: Floats) -> Floats:
    """Steps of x, y and theta for the derivatives [m, m, rad]."""
    point = np.array([[pose[0], pose[1], views.camera.tag_height]])
    px = float(np.sqrt(abs(np.linalg.det(views.camera.affine_at(point)[0]))))  # per m
    return _STEP_PX / px * np.array((1.0, 1.0, 2.0 / views.tag.side))
