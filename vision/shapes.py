"""Shapes: what the search needs to know of the geometries of tags, and of their colours."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vision.palette import Palette
from vision.tags import Tag, TagSet
from vision.template import Templates, sample_points

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

_SAMPLES = 9  # points at which the classes of a part are looked up
_MAX_ANCHORS = 3  # pairs of parts tried per tag


class Looks(NamedTuple):
    """What tags look like, as compiled functions take it: T tags of S shapes with K parts.

    Attributes:
        shape_of: shape (T,), geometry of every tag.
        classes: shape (T, K), colour class of every part, 0 for background.
        typical: shape (T, K, 3), BGR of every part under full light.
        part_counts: shape (S,), how many parts a geometry has.
        centroids: shape (S, K, 2), centres of what is visible of the parts [m].
        anchors: shape (S, A, 2), pairs of coloured parts by whose blobs tags are searched for.
        samples: shape (S, M, 2), points deep inside coloured parts [m].
        sample_parts: shape (S, M), the part of every such point, -1 for none.
        corners: shape (S, V, 2), of the plate; the last may come several times [m].
    """

    shape_of: Indices
    classes: Indices
    typical: Floats
    part_counts: Indices
    centroids: Floats
    anchors: Indices
    samples: Floats
    sample_parts: Indices
    corners: Floats


@dataclass(frozen=True, slots=True)
class Shape:
    """The geometry shared by tags that differ only in colour.

    Attributes:
        tags: indices of these tags in the set.
        names: of the parts.
        areas: shape (K,), visible areas of the parts [m^2].
        colored: the parts that have a colour.
        anchors: pairs of coloured parts by whose blobs the tag is searched for.
        inner_radius: of the circle inside the plate [m].
    """

    tags: tuple[int, ...]
    names: tuple[str, ...]
    areas: Floats
    colored: tuple[int, ...]
    anchors: tuple[tuple[int, int], ...]
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


def make_shapes(tags: TagSet) -> tuple[Shape, ...]:
    """Collect the geometries of a set of tags.

    Args:
        tags: the set.

    Returns:
        The shapes.
    """
    return tuple(_make_shape(tags, group) for group in group_tags(tags.tags))


def make_looks(
    tags: TagSet, shapes: tuple[Shape, ...], templates: Templates, palette: Palette
) -> Looks:
    """Collect what tags look like.

    Args:
        tags: the set.
        shapes: its geometries.
        templates: of all shapes.
        palette: which colour is which class.

    Returns:
        The looks; shapes with fewer parts, anchors, samples or corners are filled up.
    """
    count, parts = len(tags.tags), max(len(shape.names) for shape in shapes)
    shape_of, classes = np.zeros(count, np.intp), np.zeros((count, parts), np.intp)
    centroids = np.zeros((len(shapes), parts, 2))
    for index, shape in enumerate(shapes):
        shape_of[list(shape.tags)] = index
        tag = tags.tags[shape.tags[0]]
        centroids[index, : len(tag.parts)] = [
            tag.visible_centroid(k) for k in range(len(tag.parts))
        ]
        for n in shape.tags:
            names = [part.color for part in tags.tags[n].parts]
            classes[n, : len(names)] = [
                palette.class_of(name) if name in tags.search_colors else 0 for name in names
            ]
    samples, owners = zip(
        *(_samples(shape, n, templates) for n, shape in enumerate(shapes)), strict=True
    )
    anchors = [np.array(shape.anchors, np.intp).reshape(-1, 2) for shape in shapes]
    corners = [tags.tags[shape.tags[0]].parts[0].polygon for shape in shapes]
    return Looks(
        shape_of, classes, np.ascontiguousarray(palette.typical[classes]),
        np.array([len(shape.names) for shape in shapes], np.intp), centroids,
        _padded(anchors), _padded(samples), _padded(owners, -1), _padded(corners),
    )  # fmt: skip


def _make_shape(tags: TagSet, group: tuple[int, ...]) -> Shape:
    """Collect what tags of one geometry share."""
    tag = tags.tags[group[0]]
    count = len(tag.parts)
    searched = tags.search_colors
    colored = tuple(
        k for k in range(count) if any(tags.tags[n].parts[k].color in searched for n in group)
    )
    centroids = np.array([tag.visible_centroid(k) for k in range(count)])
    areas = np.array([tag.visible_area(k) for k in range(count)])
    names, anchors = tuple(part.name for part in tag.parts), _anchors(colored, centroids, areas)
    return Shape(group, names, areas, colored, anchors, tag.inner_radius)


def _anchors(
    colored: tuple[int, ...], centroids: Floats, areas: Floats
) -> tuple[tuple[int, int], ...]:
    """The pairs of coloured parts that give the best heading: large and far apart."""
    worth = [
        (min(areas[i], areas[j]) * float(np.hypot(*(centroids[i] - centroids[j]))), (i, j))
        for i, j in combinations(colored, 2)
    ]
    return tuple(pair for _, pair in sorted(worth, key=lambda item: -item[0])[:_MAX_ANCHORS])


def _samples(shape: Shape, index: int, templates: Templates) -> tuple[Floats, Indices]:
    """Points deep inside the coloured parts of a shape, and their parts."""
    points = [sample_points(templates, index, part, _SAMPLES) for part in shape.colored]
    return np.concatenate(points), np.repeat(shape.colored, [len(p) for p in points])


def _padded(arrays: "Sequence[NDArray[Any]]", fill: int | None = None) -> "NDArray[Any]":
    """Stack arrays of different lengths; short ones are filled up, by default with their last."""
    most = max(len(array) for array in arrays)
    rows = []
    for array in arrays:
        lacking = most - len(array)
        if lacking:
            tail = array[-1:] if fill is None else np.full_like(array[:1], fill)
            array = np.concatenate((array, *[tail] * lacking))
        rows.append(array)
    return np.ascontiguousarray(np.stack(rows))
