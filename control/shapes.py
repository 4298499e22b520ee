"""Named shapes of a formation: the places of its followers about the leader.

A place is where a follower's camera point is to be, (x, y) in the leader's frame: x forward, y
left, the middle of the leader's axle at the origin. The follower's own axle is d behind its
camera point. Followers alternate left and right, nearest to the leader first; places are counted
from 0.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import combinations
from math import atan2, cos, hypot, inf, pi, sin
from types import MappingProxyType
from typing import Literal, TypeAlias

from control.actuation import require_finite
from control.errors import ControlError
from control.geometry import wrap_angle
from control.relative import Vector2

Places: TypeAlias = tuple[Vector2, ...]

APART = 1e-3
"""Two points nearer than this are the same place [m]."""


def line(count: int, spacing: float) -> Places:
    """Abreast: side by side with the leader.

    Args:
        count: followers, at least 1.
        spacing: between neighbours [m].

    Returns:
        Their places, on the line of the leader's axle [m, m].

    Raises:
        ControlError: if the count or the spacing is too small.
    """
    _require_shape(count, spacing)
    return given([(0.0, side * rank * spacing) for rank, side in _sides(count)])


def column(count: int, spacing: float) -> Places:
    """One behind the other, the leader in front.

    Args:
        count: followers, at least 1.
        spacing: between neighbours [m].

    Returns:
        Their places, front to back [m, m].

    Raises:
        ControlError: if the count or the spacing is too small.
    """
    _require_shape(count, spacing)
    return given([(-(k + 1) * spacing, 0.0) for k in range(count)])


def wedge(count: int, spacing: float, half_angle: float = pi / 4.0) -> Places:
    """Two arms in a V whose tip is the leader.

    Args:
        count: followers, at least 1.
        spacing: between neighbours of one arm; the first two of the arms are nearer to each other
            where the arms are less than 60 degrees apart [m].
        half_angle: between an arm and straight behind, in (0, pi): pi/2 is a line, beyond it the
            V opens forward [rad].

    Returns:
        Their places [m, m].

    Raises:
        ControlError: if the count, the spacing or the angle is out of range.
    """
    _require_shape(count, spacing)
    if not 0.0 < half_angle < pi:
        raise ControlError(f"the half-angle of a wedge is in (0, pi) rad, got {half_angle:g} rad")
    back, left = spacing * cos(half_angle), spacing * sin(half_angle)
    return given([(-rank * back, side * rank * left) for rank, side in _sides(count)])


def circle(count: int, spacing: float, leader: Literal["rim", "centre"] = "centre") -> Places:
    """Evenly around a circle, about the leader or with it.

    About the leader the first follower is straight behind, the others left and right of it to
    the front, at least a spacing away from the leader: so fewer than six are farther than a
    spacing from one another. On the rim the leader is the foremost.

    Args:
        count: followers, at least 1.
        spacing: the least distance between two robots, along the chord [m].
        leader: where the leader is.

    Returns:
        Their places [m, m].

    Raises:
        ControlError: if the count or the spacing is too small, or the leader is elsewhere.
    """
    _require_shape(count, spacing)
    if leader == "rim":
        radius, step = _rim(count + 1, spacing)
        turns = [(rank * step, side) for rank, side in _sides(count)]
        return given([(radius * (cos(a) - 1.0), side * radius * sin(a)) for a, side in turns])
    if leader != "centre":
        raise ControlError(
            f'the leader of a circle is on its "rim" or at its "centre", got {leader!r}'
        )
    radius, step = _rim(max(count, 2), spacing)  # one follower is on no chord
    radius = max(radius, spacing)
    turns = [(0.0, 1.0), *((rank * step, side) for rank, side in _sides(count - 1))]
    return given([(-radius * cos(a), side * radius * sin(a)) for a, side in turns])


def given(places: Sequence[Vector2]) -> Places:
    """Any list of places, checked.

    Args:
        places: (N, 2), at least one [m, m].

    Returns:
        The same places.

    Raises:
        ControlError: if there is none, a number is not finite, or two places, or one and the
            leader's, are nearer than ``APART``.
    """
    if not places:
        raise ControlError("a shape needs at least one place, got none")
    require_finite("places", *(coordinate for place in places for coordinate in place))
    named = [("the leader", (0.0, 0.0)), *((f"place {k}", p) for k, p in enumerate(places))]
    for (one, (x, y)), (other, (u, v)) in combinations(named, 2):
        if hypot(u - x, v - y) < APART:
            raise ControlError(
                f"{other} at ({u:g}, {v:g}) m coincides with {one} at ({x:g}, {y:g}) m: "
                f"give them at least {APART:g} m"
            )
    return tuple((float(x), float(y)) for x, y in places)


_SHAPES: Mapping[str, Callable[..., Places]] = MappingProxyType(
    {"line": line, "column": column, "wedge": wedge, "circle": circle}
)

SHAPES: tuple[str, ...] = tuple(_SHAPES)


def named_shape(name: str) -> Callable[..., Places]:
    """Find a shape by its name.

    Args:
        name: one of SHAPES.

    Returns:
        The function that gives its places from a count, a spacing and the shape's own options.

    Raises:
        ControlError: if there is no shape of that name.
    """
    if name not in _SHAPES:
        raise ControlError(
            f"no shape {name!r}; there are: {', '.join(SHAPES)}, or a list of places"
        )
    return _SHAPES[name]


def polar_of(place: Vector2) -> Vector2:
    """A place as the relative configuration h of (6) and (7).

    Args:
        place: in the frame of the robot that is followed [m, m].

    Returns:
        Distance and bearing in (-pi, pi]: 0 straight ahead, pi/2 left, pi behind [m, rad].
    """
    x, y = place
    return hypot(x, y), wrap_angle(atan2(y, x))


def place_of(configuration: Vector2) -> Vector2:
    """The place of a relative configuration: the inverse of ``polar_of``.

    Args:
        configuration: distance and bearing, the bearing not necessarily wrapped [m, rad].

    Returns:
        The place in the frame of the robot that is followed [m, m].
    """
    l, psi = configuration  # noqa: E741 (the paper's l)
    return l * cos(psi), l * sin(psi)


def _require_shape(count: int, spacing: float) -> None:
    if count < 1:
        raise ControlError(f"a shape needs at least 1 follower, got {count}")
    if not APART <= spacing < inf:
        raise ControlError(f"the spacing of a shape is at least {APART:g} m, got {spacing:g} m")


def _sides(count: int) -> Iterator[tuple[int, float]]:
    """Rank and side (1 left, -1 right) of each follower: left, right, left, ..."""
    return ((k // 2 + 1, -1.0 if k % 2 else 1.0) for k in range(count))


def _rim(count: int, spacing: float) -> tuple[float, float]:
    """Radius of a circle on which so many robots are a spacing apart [m], and their step [rad]."""
    step = 2.0 * pi / count
    return spacing / (2.0 * sin(0.5 * step)), step
