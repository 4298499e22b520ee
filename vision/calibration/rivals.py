"""How well two colours can be told apart in the light they were seen in."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from control.command import RobotId
from vision.tags import Tag, TagSet

Floats = NDArray[np.float64]

_LIGHT = 0.25  # spread of the logarithm of the light between parts of a tag
_NOISE = 4.0  # of a colour, beside what the samples show [grey levels]
CLOSE = 0.02  # of errors between two colours: more is too close


@dataclass(frozen=True, slots=True)
class Rival:
    """A pair of colours.

    Attributes:
        one: name of a colour.
        other: name of the other.
        error: Bhattacharyya's bound on the share of parts that would be taken for the other.
        confused: pairs of robots whose tags differ by these two colours only.
    """

    one: str
    other: str
    error: float
    confused: tuple[tuple[RobotId, RobotId], ...]

    @property
    def too_close(self) -> bool:
        """Whether the two cannot be relied on together."""
        return self.error > CLOSE


def compare_colors(one: Floats, other: Floats) -> float:
    """Bound the error between two colours, as normal distributions (Bhattacharyya 1943).

    Args:
        one: shape (N, 3), BGR of a colour in light 1.
        other: shape (M, 3), of the other.

    Returns:
        Upper bound of the error rate, 0 to 0.5.
    """
    (m, s), (n, t) = _normal(one), _normal(other)
    mean = 0.5 * (s + t)
    apart = float((m - n) @ np.linalg.solve(mean, m - n)) / 8.0
    logs = [np.linalg.slogdet(a)[1] for a in (mean, s, t)]
    return 0.5 * float(np.exp(-apart - 0.5 * (logs[0] - 0.5 * (logs[1] + logs[2]))))


def confused_robots(
    tags: TagSet, one: str, other: str
) -> tuple[tuple[RobotId, RobotId], ...]:
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


def _normal(colors: Floats) -> tuple[Floats, Floats]:
    """Mean (3,) and covariance (3, 3), with the spread of light and noise."""
    mean = colors.mean(axis=0)
    spread = np.cov(colors.T) if len(colors) > 3 else np.zeros((3, 3))
    return mean, spread + _LIGHT**2 * np.outer(mean, mean) + _NOISE**2 * np.eye(3)
