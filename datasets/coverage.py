"""Exact area coverage: how much of every pixel lies inside a polygon.

Every edge is cut where it crosses a pixel border. A piece inside one pixel that descends by dy
covers dy of its row to its right, less the part of its own pixel that is left of it; summing along
the rows gives the coverage. Corner coordinates: the top-left pixel covers [0, 1] x [0, 1].
"""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.intp]


def edge_coverage(
    starts: Floats, ends: Floats, layers: Integers, shape: tuple[int, int, int]
) -> Floats:
    """Coverage of many closed polygons, one per layer; parts outside the window are cut off.

    Args:
        starts: shape (E, 2), start x, y of every edge, finite [px, corner coordinates].
        ends: shape (E, 2), end x, y of every edge, finite [px, corner coordinates].
        layers: shape (E,), the layer of every edge; the edges of a layer close one polygon.
        shape: layers, height and width of the window [px].

    Returns:
        Share of every pixel inside the polygon, shape `shape`, 0 to 1.
    """
    count, height, width = shape
    edges, points = _cut(starts, ends - starts)
    inner = np.flatnonzero(edges[1:] == edges[:-1])  # a piece joins two cuts of the same edge
    low, high = points[inner], points[inner + 1]
    x, y = 0.5 * (low + high).T
    drop = high[:, 1] - low[:, 1]
    x = np.maximum(x, 0.0)  # left of the window: covers the whole row
    inside = np.flatnonzero((x < width) & (y >= 0.0) & (y < height) & (drop != 0.0))
    x, y, drop = x[inside], y[inside], drop[inside]
    column = x.astype(np.intp)
    row = layers[edges[inner[inside]]] * height + y.astype(np.intp)
    cell = row * (width + 1) + column
    left = drop * (x - column)
    size = count * height * (width + 1)
    gained = np.bincount(
        np.concatenate((cell, cell + 1)), np.concatenate((drop - left, left)), minlength=size
    )
    rows = np.cumsum(gained.reshape(count, height, width + 1), axis=2)
    covered: Floats = np.abs(rows[:, :, :width])  # either orientation
    return covered


def polygon_coverage(polygon: Floats, shape: tuple[int, int]) -> Floats:
    """Coverage of one polygon.

    Args:
        polygon: shape (N, 2), corners x, y, finite [px, corner coordinates].
        shape: height and width of the window [px].

    Returns:
        Share of every pixel inside the polygon, shape (H, W), 0 to 1.
    """
    layers = np.zeros(len(polygon), np.intp)
    following = np.roll(polygon, -1, axis=0)
    covered: Floats = edge_coverage(polygon, following, layers, (1, *shape))[0]
    return covered


def _cut(starts: Floats, ways: Floats) -> tuple[Integers, Floats]:
    """Cut edges at the pixel borders: edge of every cut, ascending, and its point (M, 2)."""
    count = len(starts)
    every = np.arange(count)
    owners, places = [every, every], [np.zeros(count), np.ones(count)]
    for axis in (0, 1):
        owner, place = _crossings(starts[:, axis], ways[:, axis])
        owners.append(owner)
        places.append(place)
    edge, place = np.concatenate(owners), np.concatenate(places)
    order = np.argsort(2.0 * edge + place, kind="stable")
    edge, place = edge[order], place[order]
    return edge, starts[edge] + place[:, None] * ways[edge]


def _crossings(start: Floats, way: Floats) -> tuple[Integers, Floats]:
    """Where edges cross whole numbers along one axis: edge, and place along it in [0, 1]."""
    end = start + way
    first = np.ceil(np.minimum(start, end))
    counts = np.maximum(np.floor(np.maximum(start, end)) - first + 1.0, 0.0).astype(np.intp)
    counts[way == 0.0] = 0  # runs along the border: nothing to cut
    owner = np.repeat(np.arange(len(start)), counts)
    running = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
    place = (first[owner] + running - start[owner]) / way[owner]
    return owner, np.clip(place, 0.0, 1.0)
