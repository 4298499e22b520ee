"""How well two colours can be told apart in the light they were seen in.

A colour is its direction in BGR, which light does not change, and its brightness against the other
colours of a tag. Both are taken as normal on one tag after the other.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from control.command import RobotId
from vision.calibration.print_colors import unit
from vision.tags import Tag, TagSet

Floats = NDArray[np.float64]

CLOSE, TOO_CLOSE = 0.01, 0.05  # bounds of the error between two colours
_TURN, _WORTH = 0.06, 3.0  # usual spread of a direction [rad], and how many tags it counts for
_LIGHT = 0.25  # spread of the logarithm of the light between parts of a tag


@dataclass(frozen=True, slots=True)
class Spread:
    """How a colour varies from tag to tag.

    Attributes:
        direction: of the mean in BGR, shape (3,), length 1.
        turn: standard deviation of the direction along each of its two axes [rad].
        brightness: logarithm of the mean length.
    """

    direction: Floats
    turn: float
    brightness: float


@dataclass(frozen=True, slots=True)
class Rival:
    """A pair of colours.

    Attributes:
        one: name of a colour.
        other: name of the other.
        error: bound on the share of parts that would be taken for the other.
        confused: pairs of robots whose tags differ by these two colours only.
    """

    one: str
    other: str
    error: float
    confused: tuple[tuple[RobotId, RobotId], ...]

    @property
    def verdict(self) -> str:
        """In words: "far apart", "close" or "too close"."""
        if self.error > TOO_CLOSE:
            return "too close"
        return "close" if self.error > CLOSE else "far apart"


def spread_of(colors: Floats) -> Spread:
    """Measure how a colour varies.

    Args:
        colors: shape (N, 3), N >= 1, as seen on N tags, in the same light, BGR.

    Returns:
        Its spread.
    """
    mean = np.median(colors, axis=0)
    direction = unit(mean)
    turns = np.arccos(np.clip(unit(colors) @ direction, -1.0, 1.0))
    squares = float((turns**2).sum()) + _WORTH * 2.0 * _TURN**2
    turn = float(np.sqrt(squares / (2.0 * (len(colors) + _WORTH))))
    return Spread(direction, turn, float(np.log(np.linalg.norm(mean))))


def compare_colors(one: Spread, other: Spread) -> float:
    """Bound the error between two colours (Bhattacharyya 1943).

    Args:
        one: a colour.
        other: another.

    Returns:
        Upper bound of the error rate, 0 to 0.5.
    """
    apart = float(np.arccos(np.clip(one.direction @ other.direction, -1.0, 1.0)))
    both = one.turn**2 + other.turn**2
    turn = 0.25 * apart**2 / both + np.log(both / (2.0 * one.turn * other.turn))
    light = 0.125 * ((one.brightness - other.brightness) / _LIGHT) ** 2
    return 0.5 * float(np.exp(-turn - light))


def confused_robots(tags: TagSet, one: str, other: str) -> tuple[tuple[RobotId, RobotId], ...]:
    """Find robots that only these two colours tell apart.

    Args:
        tags: worn by the robots.
        one: name of a colour.
        other: name of another.

    Returns:
        Pairs of ids.
    """
    merged = [(tag.robot_id, _merged(tag, one, other)) for tag in tags.tags]
    return tuple(
        (first, second)
        for n, (first, look) in enumerate(merged)
        for second, its in merged[n + 1 :]
        if look == its
    )


def _merged(tag: Tag, one: str, other: str) -> tuple[tuple[bytes, str], ...]:
    """A tag's parts with one colour called the other."""
    return tuple((p.polygon.tobytes(), other if p.color == one else p.color) for p in tag.parts)
