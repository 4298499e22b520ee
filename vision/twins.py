"""Which tags look alike: tags are drawn turned and mirrored, and compared cell by cell."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations, product
from math import pi

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.errors import VisionError
from vision.tags import Tag

_CELLS = 48  # across a tag
_TURN_DEG = 3
_TURNS = 360 // _TURN_DEG
_OWN_TURNS = slice(10, 111)  # 30 to 330 degrees: a turn that would be a wrong heading
ALIKE = 0.08  # twins differ on less than this share of the coloured cells

Rasters = NDArray[np.uint8]


@dataclass(frozen=True, slots=True)
class Likeness:
    """How much two tags look alike, or one looks like itself when turned.

    Attributes:
        one: index of a tag.
        other: index of the other, or the same.
        mirrored: whether the other was mirrored for it.
        turn_deg: by which the other was turned for it [deg].
        differs: share of the coloured area on which they still differ.
    """

    one: int
    other: int
    mirrored: bool
    turn_deg: int
    differs: float


def check_distinct(
    tags: tuple[Tag, ...],
    background: tuple[str, ...],
    mirror_twins: bool,
    look_alikes: bool = False,
) -> None:
    """Refuse tags that cannot be told apart, or whose heading cannot be told.

    Args:
        tags: to compare, every pair of them.
        background: colours that count as nothing.
        mirror_twins: do not mind tags that are mirror images of one another.
        look_alikes: do not mind tags that are the same.

    Raises:
        VisionError: naming the two tags and the turn that makes them alike.
    """
    alike = same_tags(tags)
    for found in likenesses(tags, background, mirror_twins):
        same = found.one != found.other and alike[found.one] == alike[found.other]
        if found.differs < ALIKE and not (same and look_alikes):
            raise VisionError(_complaint(found, tags, same))


def same_tags(tags: tuple[Tag, ...]) -> tuple[int, ...]:
    """Find tags that are the same: polygons and colours.

    Args:
        tags: to compare.

    Returns:
        For every tag the index of the first that is the same.
    """
    looks = [tuple((part.color, part.polygon.tobytes()) for part in tag.parts) for tag in tags]
    return tuple(looks.index(look) for look in looks)


def likenesses(
    tags: tuple[Tag, ...], background: tuple[str, ...], mirror_twins: bool
) -> Iterator[Likeness]:
    """Compare every tag with itself and with every other.

    Args:
        tags: to compare.
        background: colours that count as nothing.
        mirror_twins: do not mirror tags.

    Yields:
        Of every tag its most similar turned view; then the same of every pair, and mirrored.
    """
    reach = max((tag.outer_radius for tag in tags), default=0.0)
    colors = {part.color for tag in tags for part in tag.parts} - set(background)
    ranks = tuple((color, rank) for rank, color in enumerate(sorted(colors), start=1))
    turned = [_turned(tag, ranks, reach, False) for tag in tags]
    for n, views in enumerate(turned):
        turn, share = _most_alike(views[0], views[_OWN_TURNS])
        yield Likeness(n, n, False, (turn + _OWN_TURNS.start) * _TURN_DEG, share)
    kinds = [(False, turned)]
    if not mirror_twins:
        kinds.append((True, [_turned(tag, ranks, reach, True) for tag in tags]))
    for (i, j), (mirrored, seen) in product(combinations(range(len(tags)), 2), kinds):
        turn, share = _most_alike(turned[i][0], seen[j])
        yield Likeness(i, j, mirrored, turn * _TURN_DEG, share)


def _complaint(found: Likeness, tags: tuple[Tag, ...], same: bool) -> str:
    """Why tags are refused."""
    one, other = tags[found.one].robot_id, tags[found.other].robot_id
    if found.one == found.other:
        return (
            f"tag of robot {one} looks the same when turned by {found.turn_deg} deg "
            f"({found.differs:.0%} of it differs)"
        )
    if same:
        return (
            f"robots {one} and {other} wear the same tag: give one other colours, or say "
            "look_alikes = true if they are to be told apart by where they were"
        )
    how = "mirrored and " if found.mirrored else ""
    return (
        f"tags of robots {one} and {other} cannot be told apart: the second, "
        f"{how}turned by {found.turn_deg} deg, differs from the first on {found.differs:.0%}"
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
    turns = np.arange(_TURNS) * (2.0 * pi / _TURNS)
    c, s = np.cos(turns), np.sin(turns)
    rotations = np.column_stack((c, s, -s, c)).reshape(-1, 2, 2)  # from the right
    for part in tag.parts:
        corners = (part.polygon * mirror @ rotations / reach + 1.0) * _CELLS / 2.0 - 0.5
        color = (rank_of.get(part.color, 0),)
        for view, polygon in zip(views, np.rint(corners * 16.0).astype(np.int32), strict=True):
            cv2.fillPoly(view, [polygon], color, shift=4)
    return views.reshape(_TURNS, -1)
