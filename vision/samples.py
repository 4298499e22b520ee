"""The samples around a tag that tell something of it: pixels, and means of 2 x 2 for colour."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vision.compiled import compiled_part
from vision.floor_map import Patch

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Bytes = NDArray[np.uint8]
Shares = NDArray[np.uint32]
Places = NDArray[np.int32]

_SPREAD_X, _SPREAD_Y = np.uint64(0x9E3779B1), np.uint64(0x85EBCA6B)  # of lattices without a period
_BITS = np.uint64(0xFFFFFFFF)


class Usage(NamedTuple):
    """Which samples around a tag are used.

    Attributes:
        kinds: shape (n, n), what a sample at a place of the tag's frame tells, see `Templates`.
        shares: shape (3,), of the samples of every kind this share is used, of 2^32.
        strides: of so many rows, and of so many samples of a row, one is looked at.
        cell: side of a place [m].
    """

    kinds: Bytes
    shares: Shares
    strides: tuple[int, int]
    cell: float


class Lattice(NamedTuple):
    """What a sample is.

    Attributes:
        side: it is the mean of so many times so many pixels.
        right: by which it shows what lies further left [px].
        down: by which it shows what lies further up [px].
    """

    side: int
    right: float
    down: float


class Window(NamedTuple):
    """Where samples are looked for.

    Attributes:
        x: of the middle [px].
        y: of the middle [px].
        radius: of the circle around it [px].
    """

    x: int
    y: int
    radius: int


class _Line(NamedTuple):
    """Samples of a row: floor points relative to the pose [m]; their places in the usage map."""

    x: Singles
    y: Singles
    at: Places


@compiled_part
def collect(
    size_px: tuple[int, int], patch: Patch, usage: Usage, lattice: Lattice, pose: Floats,
    window: Window, places: Singles, chosen: Places,
) -> int:  # fmt: skip
    """Choose the samples around a tag.

    Args:
        size_px: height and width of the image [px].
        patch: of the floor, around the tag.
        usage: which samples are used.
        lattice: what a sample is.
        pose: shape (3,), where the tag is looked for [m, m, rad].
        window: where samples are looked for.
        places: shape (2, N), receives the samples' floor points relative to the pose [m].
        chosen: shape (2, N), receives the samples' rows and columns in the lattice.

    Returns:
        Number of samples.
    """
    count, (row_step, step), flat = 0, usage.strides, usage.kinds.reshape(-1)
    side, radius, shares = lattice.side, window.radius + lattice.side - 1, usage.shares
    aside, below = 0.5 * (side - 1) - lattice.right, 0.5 * (side - 1) - lattice.down
    room = np.empty((2, 2 * radius + 2), np.float32)
    line = _Line(room[0], room[1], np.empty(2 * radius + 2, np.int32))
    first, last = _span(window.y, radius, side, size_px[0])
    for j in range(_next(first, row_step, 0), last, row_step):
        reach = int(np.sqrt(max(radius**2 - (side * j - window.y) ** 2, 0)))
        start, end = _span(window.x, reach, side, size_px[1])
        start = _next(start, step, j // row_step)
        looks = (end - start + step - 1) // step
        _floor_line(
            patch, side * start + aside, side * j + below, side * step, looks, pose, usage, line
        )
        for n in range(looks):
            i = start + n * step
            places[0, count], places[1, count] = line.x[n], line.y[n]
            chosen[0, count], chosen[1, count] = j, i
            use = _chance(i, j) < shares[flat[line.at[n]]]
            count += use  # no jump that would be guessed wrong
    return count


@compiled_part
def _floor_line(
    patch: Patch, x: float, y: float, step: float, looks: int, pose: Floats, usage: Usage,
    line: _Line,
) -> None:  # fmt: skip
    """Fill a line with what is behind pixels from (x, y) on, a step apart."""
    x0, x1, x2, x3 = _row(patch, 0, x, y, step, pose[0])
    y0, y1, y2, y3 = _row(patch, 1, x, y, step, pose[1])
    size = usage.kinds.shape[0]
    c, s = np.float32(np.cos(pose[2]) / usage.cell), np.float32(np.sin(pose[2]) / usage.cell)
    center, most, least = np.float32(size // 2 + 0.5), np.float32(size - 0.5), np.float32(0.0)
    for n in range(looks):
        t = np.float32(n)
        px, py = x0 + t * (x1 + t * (x2 + t * x3)), y0 + t * (y1 + t * (y2 + t * y3))
        column = min(most, max(least, c * px + s * py + center))  # nan becomes least
        row = min(most, max(least, c * py - s * px + center))
        line.x[n], line.y[n] = px, py
        line.at[n] = np.int32(row) * np.int32(size) + np.int32(column)


@compiled_part
def _row(
    patch: Patch, axis: int, x: float, y: float, step: float, origin: float
) -> tuple[np.float32, np.float32, np.float32, np.float32]:
    """Terms of a coordinate along a row of pixels, in steps from the first one."""
    a, b = (x - patch.column) / patch.pitch, (y - patch.row) / patch.pitch
    unit, terms = step / patch.pitch, patch.terms[axis]
    zero, one, two, three = _at(terms[0], b), _at(terms[1], b), _at(terms[2], b), _at(terms[3], b)
    return (
        np.float32(zero + a * (one + a * (two + a * three)) - origin),
        np.float32(unit * (one + a * (2.0 * two + 3.0 * a * three))),
        np.float32(unit**2 * (two + 3.0 * a * three)), np.float32(unit**3 * three),
    )  # fmt: skip


@compiled_part
def _at(terms: Floats, t: float) -> float:
    """A cubic's value."""
    return float(terms[0] + t * (terms[1] + t * (terms[2] + t * terms[3])))


@compiled_part
def _span(middle: int, reach: int, side: int, size: int) -> tuple[int, int]:
    """First sample and the one after the last within reach of a pixel, along one axis."""
    return max(middle - reach, 0) // side, min((middle + reach) // side + 1, size // side)


@compiled_part
def _next(start: int, stride: int, row: int) -> int:
    """First place from a start on that is looked at in a row; rows begin at different ones."""
    return start + (row * ((stride + 1) // 2) - start) % stride


@compiled_part
def _chance(x: int, y: int) -> np.uint64:
    """A number below 2^32 that depends on the pixel, evenly spread over any neighbourhood."""
    return (np.uint64(x) * _SPREAD_X + np.uint64(y) * _SPREAD_Y) & _BITS


@compiled_part
def see_bgr(image: Bytes, chosen: Places, count: int, values: Singles) -> None:
    """Read the colours of pixels.

    Args:
        image: shape (H, W, 3), BGR.
        chosen: shape (2, N), rows and columns of pixels.
        count: of the first ones.
        values: shape (3, N), receives B, G and R.
    """
    for n in range(count):
        for channel in range(3):
            values[channel, n] = image[chosen[0, n], chosen[1, n], channel]


@compiled_part
def see_luma(image: Bytes, chosen: Places, count: int, values: Singles) -> None:
    """Read the luma of pixels, BT.601.

    Args:
        image: shape (H, W, 3), BGR.
        chosen: shape (2, N), rows and columns of pixels.
        count: of the first ones.
        values: shape (1 or more, N), receives the luma.
    """
    for n in range(count):
        j, i = chosen[0, n], chosen[1, n]
        values[0, n] = 0.114 * image[j, i, 0] + 0.587 * image[j, i, 1] + 0.299 * image[j, i, 2]


@compiled_part
def see_chroma(image: Bytes, chosen: Places, count: int, mix_rows: bool, values: Singles) -> None:
    """Read the chroma of pixels, as means of 2 x 2, BT.601.

    Args:
        image: shape (H, W, 3), BGR.
        chosen: shape (2, N), rows and columns of such squares.
        count: of the first ones.
        mix_rows: mix the rows 1 : 6 : 1, as upsampling has mixed the columns.
        values: shape (2 or more, N), receives blue and red.
    """
    last = image.shape[0] // 2 - 1
    for n in range(count):
        j, i = chosen[0, n], chosen[1, n]
        blue, red = _chroma(image, j, i)
        if mix_rows:
            above, below = _chroma(image, max(j - 1, 0), i), _chroma(image, min(j + 1, last), i)
            blue = 0.75 * blue + 0.125 * (above[0] + below[0])
            red = 0.75 * red + 0.125 * (above[1] + below[1])
        values[0, n], values[1, n] = blue, red


@compiled_part
def _chroma(image: Bytes, j: int, i: int) -> tuple[float, float]:
    """Mean blue and red chroma of 2 x 2 pixels, BT.601."""
    blue, green, red = 0, 0, 0
    for row in range(2 * j, 2 * j + 2):
        for column in range(2 * i, 2 * i + 2):
            blue += image[row, column, 0]
            green += image[row, column, 1]
            red += image[row, column, 2]
    return (
        0.125 * blue - 0.082816 * green - 0.042184 * red,
        -0.020328 * blue - 0.104672 * green + 0.125 * red,
    )
