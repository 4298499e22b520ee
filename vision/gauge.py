"""What the pose fit needs of an eye, as compiled functions take it."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Bytes = NDArray[np.uint8]


class Plane(NamedTuple):
    """Samples of one kind: pixels, or colours as means of 2 x 2 pixels.

    Attributes:
        plane: 0 for pixels, 1 for colours.
        cells: shape (L, S, turns, n, n, K), see `Templates`.
        usage: shape (L, S, n, n), which samples are used.
        shares: shape (L, S, 2, 3), how many of them, for a coarse and for the full look.
        strides: shape (L, S, 2, 2), and of which rows and columns.
        cell: side of a cell [m].
        noise: shape (C,), standard deviation of a sample's values [grey levels].
        independence: how many independent samples one counts for.
    """

    plane: int
    cells: Singles
    usage: Bytes
    shares: NDArray[np.uint32]
    strides: NDArray[np.intp]
    cell: float
    noise: Floats
    independence: float


class Gauge(NamedTuple):
    """Everything the fit needs.

    Attributes:
        pixels: templates of pixels: B, G and R where every pixel has its own colour, else luma.
        colors: templates of colour samples: blue and red chroma; no values if pixels have colour.
        nodes: of the floor map [m].
        level: of the floor map, indices of scales.
        scales: shape (L,) [px/m].
        coarse_pays: shape (L, S), whether a tag is better looked at coarsely first.
        offset: shape (2,), by which colours lie right of and below the brightness [px].
        mix_rows: whether rows of colours are still to be mixed.
        radius: of the window around a tag [px].
        arm: turns are compared with displacements at this distance [m].
    """

    pixels: Plane
    colors: Plane
    nodes: Floats
    level: Bytes
    scales: Floats
    coarse_pays: NDArray[np.bool_]
    offset: Floats
    mix_rows: bool
    radius: int
    arm: float
