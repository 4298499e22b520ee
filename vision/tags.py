"""Tags as data: coloured polygons in the robot's frame, and sets of tags that can be told apart."""

from dataclasses import dataclass, field, replace
from itertools import combinations

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from control.command import RobotId
from vision.errors import VisionError

Floats = NDArray[np.float64]

_CELLS = 512  # cells across the box in which two parts may overlap
_SLIVER = 0.02  # share of a part's area below which an overlap is a common edge


@dataclass(frozen=True, slots=True)
class Part:
    """One polygon of a tag. Parts are disjoint or nested; a later part covers an earlier one.

    Attributes:
        name: e.g. "plate", "front", "rear".
        polygon: shape (N, 2), N >= 3, in the robot's frame, x forward, y left [m], read-only.
        color: name of a palette colour.
    """

    name: str
    polygon: Floats
    color: str

    @property
    def area(self) -> float:
        """Area inside the polygon [m^2]."""
        return abs(float(_cross(self.polygon).sum())) / 2.0

    @property
    def centroid(self) -> Floats:
        """Centre of the polygon's area, shape (2,) [m]."""
        cross = _cross(self.polygon)
        pairs = self.polygon + np.roll(self.polygon, -1, axis=0)
        center: Floats = cross @ pairs / (3.0 * cross.sum())
        return center


@dataclass(frozen=True, slots=True)
class Tag:
    """The tag one robot wears; what is visible of a part is its own area minus its children's.

    Attributes:
        robot_id: whose it is.
        parts: bottom to top; the first is the outer plate.
        parents: for every part the index of the smallest part around it, -1 for none; found here.

    Raises:
        VisionError: if there are no parts, or two overlap without being nested.
    """

    robot_id: RobotId
    parts: tuple[Part, ...]
    parents: tuple[int, ...] = field(init=False)

    def __post_init__(self) -> None:
        if not self.parts:
            raise VisionError(f"tag of robot {self.robot_id} has no parts")
        for below, above in combinations(self.parts, 2):
            _check_overlap(self.robot_id, below, above)
        parents = tuple(_parent(self.parts, index) for index in range(len(self.parts)))
        object.__setattr__(self, "parents", parents)

    @property
    def side(self) -> float:
        """Longest extent of the plate along the robot's x or y [m]."""
        return float(np.ptp(self.parts[0].polygon, axis=0).max())

    @property
    def outer_radius(self) -> float:
        """Distance of the farthest corner of any part from the robot's centre [m]."""
        return max(float(np.hypot(*part.polygon.T).max()) for part in self.parts)

    @property
    def inner_radius(self) -> float:
        """Distance of the plate's nearest edge from the robot's centre [m]."""
        a, b = self.parts[0].polygon, np.roll(self.parts[0].polygon, -1, axis=0)
        edge = b - a
        along = np.clip(-(a * edge).sum(axis=1) / (edge * edge).sum(axis=1), 0.0, 1.0)
        return float(np.hypot(*(a + along[:, None] * edge).T).min())

    def children(self, index: int) -> tuple[int, ...]:
        """Parts that lie directly on a part; it is visible where they are not.

        Args:
            index: of the part below.

        Returns:
            Indices of the parts whose parent it is.
        """
        return tuple(child for child, parent in enumerate(self.parents) if parent == index)

    def visible_area(self, index: int) -> float:
        """Area of a part that no other part covers.

        Args:
            index: of the part.

        Returns:
            The area [m^2].
        """
        return self.parts[index].area - sum(self.parts[i].area for i in self.children(index))

    def visible_centroid(self, index: int) -> Floats:
        """Centre of the area of a part that no other part covers.

        Args:
            index: of the part.

        Returns:
            The centre in the robot's frame, shape (2,) [m].
        """
        part = self.parts[index]
        covers = [self.parts[i] for i in self.children(index)]
        moment = part.area * part.centroid - sum(c.area * c.centroid for c in covers)
        center: Floats = moment / self.visible_area(index)
        return center


@dataclass(frozen=True, slots=True)
class TagSet:
    """The tags worn by the robots of one field; checked when it is made.

    Attributes:
        tags: one per robot.
        background: colours that are not searched for: the plate's and the floor's.
        mirror_twins: accept tags that are mirror images of one another; safe as long as nobody
            mirrors the picture.
        look_alikes: accept robots that wear the same tag; they are told apart by where they were.
        alike: for every tag the index of the first that is the same; found here.

    Raises:
        VisionError: if an id comes twice, a tag has no coloured part or looks the same when turned,
            or two tags cannot be told apart (also turned or mirrored); the message names them.
    """

    tags: tuple[Tag, ...]
    background: tuple[str, ...] = ("black",)
    mirror_twins: bool = False
    look_alikes: bool = False
    alike: tuple[int, ...] = field(init=False)

    def __post_init__(self) -> None:
        from vision.twins import check_distinct, same_tags  # twins.py builds on Tag

        for robot_id in self.ids:
            if self.ids.count(robot_id) > 1:
                raise VisionError(f"robot {robot_id} has {self.ids.count(robot_id)} tags")
        for tag in self.tags:
            if all(part.color in self.background for part in tag.parts):
                raise VisionError(
                    f"tag of robot {tag.robot_id}: needs a part of another colour than "
                    + ", ".join(self.background)
                )
        check_distinct(self.tags, self.background, self.mirror_twins, self.look_alikes)
        object.__setattr__(self, "alike", same_tags(self.tags))

    @property
    def ids(self) -> tuple[RobotId, ...]:
        """Ids of the robots, in the order of their tags."""
        return tuple(tag.robot_id for tag in self.tags)

    def twins_of(self, robot_id: RobotId) -> tuple[RobotId, ...]:
        """Robots that wear the same tag as one of them.

        Args:
            robot_id: of a robot of the set.

        Returns:
            The others' ids.
        """
        first = self.alike[self.ids.index(robot_id)]
        pairs = zip(self.ids, self.alike, strict=True)
        return tuple(other for other, group in pairs if group == first and other != robot_id)

    @property
    def colors(self) -> tuple[str, ...]:
        """Names of all colours used, in the order of appearance."""
        return tuple(dict.fromkeys(part.color for tag in self.tags for part in tag.parts))

    @property
    def search_colors(self) -> tuple[str, ...]:
        """Names of the colours that are searched for: all but the background."""
        return tuple(color for color in self.colors if color not in self.background)

    @property
    def outer_radius(self) -> float:
        """Largest outer radius of a tag [m]."""
        return max((tag.outer_radius for tag in self.tags), default=0.0)


@dataclass(frozen=True, slots=True)
class Layout:
    """A tag before it is given to a robot; a colour that begins with "$" is the robot's own.

    Attributes:
        name: of the layout.
        parts: bottom to top; the first is the outer plate.
        mirror_twins: see `TagSet`.
    """

    name: str
    parts: tuple[Part, ...]
    mirror_twins: bool = False

    def worn_by(self, robot_id: RobotId, colors: tuple[tuple[str, str], ...]) -> Tag:
        """Give the layout to a robot.

        Args:
            robot_id: who wears it.
            colors: pairs of a placeholder, e.g. "$rear", and the name of a palette colour.

        Returns:
            The robot's tag.

        Raises:
            VisionError: if a placeholder has no colour, or a colour no placeholder.
        """
        wanted = {part.color for part in self.parts if part.color.startswith("$")}
        given = dict(colors)
        if wanted != given.keys():
            raise VisionError(
                f"layout {self.name}, robot {robot_id}: needs colours for {sorted(wanted)}, "
                f"got {sorted(given)}"
            )
        parts = (replace(part, color=given.get(part.color, part.color)) for part in self.parts)
        return Tag(robot_id, tuple(parts))


def polygon_array(points: ArrayLike) -> Floats:
    """Make a polygon from data.

    Args:
        points: shape (N, 2), N >= 3 [m].

    Returns:
        A read-only copy, shape (N, 2) [m].

    Raises:
        VisionError: if the shape is another, a number is not finite or the area is zero.
    """
    polygon = np.array(points, dtype=np.float64)
    if polygon.ndim != 2 or polygon.shape[1] != 2 or len(polygon) < 3:
        raise VisionError(f"a polygon needs at least 3 points x, y, got shape {polygon.shape}")
    if not np.isfinite(polygon).all() or abs(_cross(polygon).sum()) < 1e-12:
        raise VisionError(f"polygon {polygon.tolist()} has no area")
    polygon.flags.writeable = False
    return polygon


def _cross(polygon: Floats) -> Floats:
    """Twice the signed areas of the triangles between the origin and the polygon's edges."""
    x, y = polygon.T
    cross: Floats = x * np.roll(y, -1) - np.roll(x, -1) * y
    return cross


def _check_overlap(robot_id: RobotId, below: Part, above: Part) -> None:
    """Refuse parts that overlap partly, or of which one hides the other."""
    shared = _shared_area(below, above) / above.area
    if _SLIVER < shared < 1.0 - _SLIVER:
        raise VisionError(
            f"tag of robot {robot_id}: {shared:.0%} of part {above.name} covers part {below.name}; "
            "parts must be disjoint, or the later one inside the earlier one"
        )
    if shared > 0.5 and above.area > (1.0 - _SLIVER) * below.area:
        raise VisionError(f"tag of robot {robot_id}: part {above.name} hides part {below.name}")


def _parent(parts: tuple[Part, ...], index: int) -> int:
    """Index of the smallest earlier part that contains a part, -1 for none."""
    above = parts[index]
    around = [i for i in range(index) if _shared_area(parts[i], above) > 0.5 * above.area]
    return min(around, key=lambda i: parts[i].area, default=-1)


def _shared_area(one: Part, other: Part) -> float:
    """Area common to two parts, by counting cells of a fine raster [m^2]."""
    low = np.maximum(one.polygon.min(axis=0), other.polygon.min(axis=0))
    high = np.minimum(one.polygon.max(axis=0), other.polygon.max(axis=0))
    if (high - low).min() <= 0.0:
        return 0.0
    scale = _CELLS / float((high - low).max())
    columns, rows = np.ceil((high - low) * scale).astype(int)
    common = np.ones((rows, columns), np.uint8)
    for part in (one, other):
        mask = np.zeros_like(common)
        corners = np.rint(((part.polygon - low) * scale - 0.5) * 16.0).astype(np.int32)
        cv2.fillPoly(mask, [corners], (1,), shift=4)
        common &= mask
    return float(np.count_nonzero(common)) / scale**2
