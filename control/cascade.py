"""Who follows whom in a shape, where each robot is then to be about the one it follows, and when.

Parents are given by place: the index of the place whose robot is followed, None for the
formation's leader.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot
from typing import TypeAlias

from control.actuation import require_finite
from control.errors import ControlError
from control.formation import Shape
from control.profile import KeyFrames
from control.relative import Vector2
from control.shapes import APART, Places, polar_of

Parents: TypeAlias = tuple[int | None, ...]

_EQUAL = 1e-9  # distances that differ by less are equal: places come from sines [m]


def star(places: Places) -> Parents:
    """All follow the formation's leader.

    Args:
        places: (N, 2) [m, m].

    Returns:
        (N,) parents, all None.
    """
    return (None,) * len(places)


def chain(places: Places) -> Parents:
    """Cascades: each follows the nearest of the robots that are nearer to the leader than it is.

    In the arms of a line, a column, a wedge and a circle with the leader on its rim that is the
    next one towards the leader; about the leader of a circle all follow the leader. Of equally
    near ones the leader is taken, then the first.

    Args:
        places: (N, 2) [m, m].

    Returns:
        (N,) parents; they form a tree under the leader.
    """
    return tuple(_nearest_inward(places, k) for k in range(len(places)))


def _nearest_inward(places: Places, k: int) -> int | None:
    x, y = places[k]
    own = hypot(x, y)
    parent, nearest = None, own  # the leader
    for j, (u, v) in enumerate(places):
        gap = hypot(u - x, v - y)
        if hypot(u, v) < own - _EQUAL and gap < nearest - _EQUAL:
            parent, nearest = j, gap
    return parent


def pair_places(places: Places, parents: Parents, camera_offset: float) -> Places:
    """Where each robot's camera point is in the frame of the robot it follows.

    All robots are taken to head like the leader: a robot that is followed then has its axle,
    from which (6) and (7) measure, ``camera_offset`` behind its own place. In turns headings
    differ, and a chain bends where a star stays stiff.

    Args:
        places: (N, 2) in the leader's frame [m, m].
        parents: (N,) who is followed. That they form a tree is for ``Formation`` to check.
        camera_offset: d of the robots that are followed [m].

    Returns:
        (N, 2) places about the parents' axles, for ``polar_of`` [m, m].

    Raises:
        ControlError: if there are not as many parents as places, a parent has no place, or a
            place is on the axle of the robot it follows.
    """
    if len(parents) != len(places):
        raise ControlError(f"{len(places)} places need as many parents, got {len(parents)}")
    require_finite("camera offset", camera_offset)
    axles = [(x - camera_offset, y) for x, y in places]
    pairs = zip(places, parents, strict=True)
    return tuple(_about(k, place, parent, axles) for k, (place, parent) in enumerate(pairs))


def _about(k: int, place: Vector2, parent: int | None, axles: list[Vector2]) -> Vector2:
    if parent is not None and not 0 <= parent < len(axles):
        raise ControlError(f"place {k} follows place {parent}, there are 0 to {len(axles) - 1}")
    x, y = (0.0, 0.0) if parent is None else axles[parent]
    ahead, left = place[0] - x, place[1] - y
    if hypot(ahead, left) < APART:
        raise ControlError(
            f"place {k} is {1e3 * hypot(ahead, left):.2g} mm from the axle of the robot it "
            f"follows: give it at least {1e3 * APART:g} mm or another leader"
        )
    return ahead, left


@dataclass(frozen=True, slots=True)
class ShapeChange:
    """A change of the whole formation to other places.

    Attributes:
        t: when it begins [s].
        places: (N, 2) new places, in the order of the robots that had the old ones [m, m].
        duration: of the transition, > 0 [s].
    """

    t: float
    places: Places
    duration: float


def pair_shapes(
    places: Places, changes: Sequence[ShapeChange], parents: Parents, camera_offset: float
) -> tuple[Shape, ...]:
    """The wanted course h^d of every pair through a sequence of shapes.

    Distance and bearing change together, with the same share of their way at any time (polar
    interpolation): in the frame of the robot it follows, a follower drives a piece of an
    Archimedean spiral, turning the shorter way about that robot. Where the distance is the same
    before and after it is an arc, where the bearing is, a straight line. Its distance is always
    between the two, so it never crosses its own leader; followers of one leader can meet.

    Args:
        places: (N, 2) places before the first change, in the leader's frame [m, m].
        changes: ascending in time.
        parents: (N,) who is followed, throughout.
        camera_offset: d [m].

    Returns:
        (N,) shapes, in the order of the places.

    Raises:
        ControlError: if a change has another number of places than its predecessor, changes
            overlap, or ``pair_places`` refuses one of them.
    """
    frames = [places, *(change.places for change in changes)]
    polars = [[polar_of(p) for p in pair_places(f, parents, camera_offset)] for f in frames]
    times = tuple(change.t for change in changes)
    durations = tuple(change.duration for change in changes)
    shapes = []
    for course in zip(*polars, strict=True):
        distances, bearings = zip(*course, strict=True)
        distance = KeyFrames(times, distances, durations)
        shapes.append(Shape(distance, KeyFrames.turning(times, bearings, durations)))
    return tuple(shapes)
