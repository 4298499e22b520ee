"""The tags of some robots as polygons: corners on the floor, coverage in windows, and inks.

What is visible of a part is its coverage minus that of its children. Summed with their colours this
is one term per part: its coverage times the difference between its colour and its parent's.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from datasets.coverage import edge_coverage
from datasets.motion import moved
from datasets.sensor.shutter import Shutter
from vision.camera import CameraModel
from vision.tags import Tag

Floats = NDArray[np.float64]
Integers = NDArray[np.intp]


class Drawing:
    """The tags of R robots with L parts and V corners in all."""

    def __init__(
        self,
        tags: tuple[Tag, ...],
        colors: Mapping[str, tuple[float, float, float]],
        pieces: int = 1,
    ) -> None:
        """Gather the parts of all tags.

        Args:
            tags: one per robot, at least one.
            colors: blue, green, red of 255 of every colour the tags use.
            pieces: in which straight edges are drawn; more than 1 where a lens bends them.
        """
        parts = [(robot, part) for robot, tag in enumerate(tags) for part in tag.parts]
        outlines = [_divided(part.polygon, pieces) for _, part in parts]
        sizes = np.array([len(outline) for outline in outlines])
        layer_robots = np.array([robot for robot, _ in parts])
        self._robots = len(tags)
        self._corners = np.vstack(outlines)
        self._layers = np.repeat(np.arange(len(parts)), sizes)
        self._corner_robots = layer_robots[self._layers]
        self._first_corners = np.searchsorted(self._corner_robots, np.arange(len(tags)))
        self._following = _next_corners(sizes)
        self._inks, self._outer = _inks(tags, colors)

    def views(self, motions: Floats, camera: CameraModel, shutter: Shutter) -> Floats:
        """Where the corners of all parts appear while the shutter is open.

        Args:
            motions: shape (R, 5), x, y, theta, v, omega of the robots at the frame's moment
                [m, m, rad, m/s, rad/s].
            camera: who looks; its tag height is that of the tags.
            shutter: when the rows are exposed.

        Returns:
            K views to be averaged, shape (K, V, 2) [px].
        """
        motion = motions[self._corner_robots]
        if shutter.instant:
            return self._seen(motion[:, :3], camera)[None]
        return shutter.views(
            lambda offsets: self._seen(moved(motion, offsets), camera), len(motion)
        )

    def _seen(self, pose: Floats, camera: CameraModel) -> Floats:
        """Where corners appear, each with a pose (V, 3) of its robot, shape (V, 2) [px]."""
        c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
        x, y = self._corners.T
        points = np.empty((len(pose), 3))
        points[:, 0] = pose[:, 0] + c * x - s * y
        points[:, 1] = pose[:, 1] + s * x + c * y
        points[:, 2] = camera.tag_height
        return camera.project(points)

    def windows(
        self, views: Floats, spread: int, grid: int = 1
    ) -> tuple[Integers, tuple[int, int]]:
        """Windows of one size, one around every tag.

        Args:
            views: shape (K, V, 2), in corner coordinates [px].
            spread: free pixels around the tag.
            grid: windows begin and end at multiples of this [px].

        Returns:
            Column and row of every window's first pixel, shape (R, 2), and height and width [px].
        """
        first, last = views.min(axis=0), views.max(axis=0)
        low = np.floor(np.minimum.reduceat(first, self._first_corners)).astype(np.intp) - spread
        high = np.ceil(np.maximum.reduceat(last, self._first_corners)).astype(np.intp) + spread
        low = low // grid * grid
        width, height = -((low - high).min(axis=0) // grid) * grid
        return low, (int(height), int(width))

    def painted(
        self, views: Floats, origins: Integers, size: tuple[int, int]
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Draw every tag into its window, the mean of all views.

        Args:
            views: shape (K, V, 2), in corner coordinates [px].
            origins: shape (R, 2), column and row of every window's first pixel.
            size: height h and width w of the windows [px].

        Returns:
            Colour times coverage, shape (R, h, w, 3), BGR of 255 under full light; and the coverage
            of the whole tag, shape (R, h, w), 0 to 1; of overlapping tags the first hides the
            later.
        """
        inks, plates = self._drawn(views[0], origins, size)
        for corners in views[1:]:
            more = self._drawn(corners, origins, size)
            inks += more[0]
            plates += more[1]
        if len(views) > 1:
            inks /= len(views)
            plates /= len(views)
        return inks, plates

    def _drawn(
        self, corners: Floats, origins: Integers, size: tuple[int, int]
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """One view (V, 2) of every tag in its window."""
        starts = corners - origins[self._corner_robots]
        shape = (len(self._outer[0]), *size)
        covered = edge_coverage(starts, starts[self._following], self._layers, shape)
        flat = covered.reshape(len(covered), -1).astype(np.float32)
        inks = (self._inks @ flat).reshape(self._robots, 3, *size)
        plates = (self._outer @ flat).reshape(self._robots, *size)
        seen = inks.transpose(0, 2, 3, 1)
        _uncover(seen, plates, origins)
        return seen, plates


def _uncover(inks: NDArray[np.float32], plates: NDArray[np.float32], origins: Integers) -> None:
    """Let earlier tags hide later ones where bodies overlap; tags that merely touch stay whole."""
    height, width = plates.shape[1:]
    apart = np.abs(origins[:, None] - origins[None])
    near = np.triu((apart[..., 0] < width) & (apart[..., 1] < height), k=1)
    for first, later in np.argwhere(near):
        dx, dy = origins[later] - origins[first]
        over = _shared(dy, height), _shared(dx, width)
        under = _shared(-dy, height), _shared(-dx, width)
        hidden, room = plates[later][under], 1.0 - plates[first][over]
        keep = np.clip(room / np.maximum(hidden, 1e-9), 0.0, 1.0)
        hidden *= keep
        inks[later][under] *= keep[..., None]


def _shared(offset: int, length: int) -> slice:
    """Cells of a window that another, further by an offset, has too."""
    return slice(max(offset, 0), length + min(offset, 0))


def _divided(polygon: Floats, pieces: int) -> Floats:
    """A polygon (V, 2) with further corners along its edges."""
    along = np.arange(pieces)[:, None] / pieces
    ahead = np.roll(polygon, -1, axis=0)
    divided: Floats = (polygon[:, None] + along * (ahead - polygon)[:, None]).reshape(-1, 2)
    return divided


def _next_corners(sizes: Integers) -> Integers:
    """Index of the corner that follows each corner on its polygon."""
    following = np.arange(1, sizes.sum() + 1)
    ends = np.cumsum(sizes)
    following[ends - 1] = ends - sizes
    return following


def _inks(
    tags: tuple[Tag, ...], colors: Mapping[str, tuple[float, float, float]]
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Matrices from coverages to inks (3 R, L) and to the coverage of whole tags (R, L)."""
    count = sum(len(tag.parts) for tag in tags)
    inks = np.zeros((len(tags), 3, count), np.float32)
    outer = np.zeros((len(tags), count), np.float32)
    layer = 0
    for robot, tag in enumerate(tags):
        bgr = np.array([colors[part.color] for part in tag.parts], float)
        for own, parent in zip(bgr, tag.parents, strict=True):
            inks[robot, :, layer] = own - bgr[parent] if parent >= 0 else own
            outer[robot, layer] = parent < 0
            layer += 1
    return inks.reshape(-1, count), outer
