"""Which tags look alike: tags are drawn turned and mirrored, and compared cell by cell."""

from itertools import combinations
from math import cos, pi, sin

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.errors import VisionError
from vision.tags import Tag

_CELLS = 48  # across a tag
_TURNS = 120  # every 3 degrees
_OWN_TURNS = slice(10, 111)  # 30 to 330 degrees: a turn that would be a wrong heading
_ALIKE = 0.08  # twins differ on less than this share of the coloured cells

Rasters = NDArray[np.uint8]


def check_distinct(tags: tuple[Tag, ...], background: tuple[str, ...], mirror_twins: bool) -> None:
    """Refuse tags that cannot be told apart, or whose heading cannot be told.

    Args:
        tags: to compare, every pair of them.
        background: colours that count as nothing.
        mirror_twins: do not mind tags that are mirror images of one another.

    Raises:
        VisionError: naming the two tags and the turn that makes them alike.
    """
    reach = max((tag.outer_radius for tag in tags), default=0.0)
    colors = {part.color for tag in tags for part in tag.parts} - set(background)
    ranks = tuple((color, rank) for rank, color in enumerate(sorted(colors), start=1))
    turned = [_turned(tag, ranks, reach, False) for tag in tags]
    for tag, views in zip(tags, turned, strict=True):
        turn, share = _most_alike(views[0], views[_OWN_TURNS])
        if share < _ALIKE:
            degrees = (turn + _OWN_TURNS.start) * 360 // _TURNS
            raise VisionError(
                f"tag of robot {tag.robot_id} looks the same when turned by {degrees} deg "
                f"({share:.0%} of it differs)"
            )
    for (i, one), (j, other) in combinations(enumerate(tags), 2):
        _check_pair(one, other, turned[i][0], turned[j], "")
        if not mirror_twins:
            mirrored = _turned(other, ranks, reach, True)
            _check_pair(one, other, turned[i][0], mirrored, "mirrored and ")


def _check_pair(one: Tag, other: Tag, view: Rasters, views: Rasters, how: str) -> None:
    """Refuse a pair of tags if one of the views of the second shows the first."""
    turn, share = _most_alike(view, views)
    if share < _ALIKE:
        raise VisionError(
            f"tags of robots {one.robot_id} and {other.robot_id} cannot be told apart: the second, "
            f"{how}turned by {turn * 360 // _TURNS} deg, differs from the first on {share:.0%}"
        )


def _most_alike(view: Rasters, views: Rasters) -> tuple[int, float]:
    """Index of the most similar view and the share of coloured cells that differ."""
    differing = np.count_nonzero(views != view, axis=1)
    colored = np.count_nonzero(views | view, axis=1)
    shares = differing / np.maximum(colored, 1)
    best = int(shares.argmin())
    return best, float(shares[best])


def _turned(tag: Tag, ranks: tuple[tuple[str, int], ...], reach: float, mirrored: bool) -> Rasters:
    """Draw a tag at every turn; shape (_TURNS, cells), 0 where there is nothing coloured."""
    rank_of = dict(ranks)
    views = np.zeros((_TURNS, _CELLS, _CELLS), np.uint8)
    mirror = np.array([1.0, -1.0 if mirrored else 1.0])
    for view, turn in zip(views, np.arange(_TURNS) * (2.0 * pi / _TURNS), strict=True):
        rotation = np.array([[cos(turn), -sin(turn)], [sin(turn), cos(turn)]])
        for part in tag.parts:
            corners = (part.polygon * mirror @ rotation.T / reach + 1.0) * _CELLS / 2.0 - 0.5
            color = (rank_of.get(part.color, 0),)
            cv2.fillPoly(view, [np.rint(corners * 16.0).astype(np.int32)], color, shift=4)
    return views.reshape(_TURNS, -1)
