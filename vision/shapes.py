"""Shapes: what the search needs to know of tags that differ only in colour."""

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from vision.palette import Palette
from vision.tags import Tag, TagSet
from vision.template import Template, sample_points

Floats = NDArray[np.float64]
_Pairs = tuple[tuple[int, int], ...]

_SAMPLES = 9  # points at which the classes of a part are looked up
_MAX_ANCHORS = 2  # pairs of parts tried per tag
_AXIS = np.array([[0.0, 0.0], [1e-3, 0.0], [-1e-3, 0.0]])  # gives a tag's place and heading [m]


@dataclass(frozen=True, slots=True)
class Shape:
    """The geometry shared by tags that differ only in colour.

    Attributes:
        tags: indices of these tags in the set.
        names: of the parts.
        part_classes: shape (tags, K), class of every part, 0 for background.
        centroids: shape (K, 2), centres of what is visible of the parts [m].
        areas: shape (K,), visible areas [m^2].
        anchors: pairs of coloured parts by whose blobs the tag is searched for.
        samples: shape (S, 2), points deep inside coloured parts [m].
        sample_parts: shape (S,), the part of every such point.
        outline: shape (3 + C, 2), the centre, a point 1 mm ahead of it, one 1 mm behind it, and the
            corners of the plate [m].
        colored: shape (P,), the parts that have a colour.
        reference: shape (tags, P, 3), the colours of these parts divided by their squared length:
            times a colour seen, it gives the light.
        inner_radius: of the circle inside the plate [m].
    """

    tags: NDArray[np.intp]
    names: tuple[str, ...]
    part_classes: NDArray[np.intp]
    centroids: Floats
    areas: Floats
    anchors: tuple[tuple[int, int], ...]
    samples: Floats
    sample_parts: NDArray[np.intp]
    outline: Floats
    colored: NDArray[np.intp]
    reference: Floats
    inner_radius: float


def group_tags(tags: tuple[Tag, ...]) -> tuple[tuple[int, ...], ...]:
    """Put tags with the same polygons together.

    Args:
        tags: of a set.

    Returns:
        Groups of indices of tags; every tag is in one group.
    """
    groups: dict[tuple[bytes, ...], list[int]] = {}
    for index, tag in enumerate(tags):
        groups.setdefault(tuple(p.polygon.tobytes() for p in tag.parts), []).append(index)
    return tuple(tuple(group) for group in groups.values())


def make_shape(tags: TagSet, group: tuple[int, ...], template: Template, palette: Palette) -> Shape:
    """Collect what the search needs to know of a geometry.

    Args:
        tags: the whole set.
        group: indices of the tags that have the geometry.
        template: of the geometry.
        palette: which colour is which class.

    Returns:
        The shape.
    """
    tag = tags.tags[group[0]]
    count = len(tag.parts)
    known = {color: palette.class_of(color) for color in tags.search_colors}
    part_classes = np.array(
        [[known.get(part.color, 0) for part in tags.tags[i].parts] for i in group], np.intp
    )
    colored = np.flatnonzero(part_classes.any(axis=0))
    points = [sample_points(template, int(part), _SAMPLES) for part in colored]
    typical = palette.typical[part_classes[:, colored]]
    centroids = np.array([tag.visible_centroid(i) for i in range(count)])
    areas = np.array([tag.visible_area(i) for i in range(count)])
    return Shape(
        np.array(group, np.intp),
        tuple(part.name for part in tag.parts),
        part_classes,
        centroids,
        areas,
        _anchors(colored, centroids, areas),
        np.concatenate(points),
        np.repeat(colored, [len(p) for p in points]),
        np.vstack((_AXIS, tag.parts[0].polygon)),
        colored,
        typical / np.maximum((typical * typical).sum(axis=2, keepdims=True), 1.0),
        tag.inner_radius,
    )


def _anchors(colored: NDArray[np.intp], centroids: Floats, areas: Floats) -> _Pairs:
    """The pairs of coloured parts that give the best heading: large and far apart."""
    pairs = combinations(colored.tolist(), 2)
    worth = [
        (min(areas[i], areas[j]) * float(np.hypot(*(centroids[i] - centroids[j]))), (i, j))
        for i, j in pairs
    ]
    return tuple(pair for _, pair in sorted(worth, key=lambda item: -item[0])[:_MAX_ANCHORS])
