"""The samples around a tag that tell something of it: pixels, and means of 2 x 2 for colour."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vision.compiled import compiled_part
from vision.floor_map import PITCH, floor_at

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Bytes = NDArray[np.uint8]
Shares = NDArray[np.uint32]

_SPREAD_X, _SPREAD_Y = np.uint32(0x9E3779B1), np.uint32(0x85EBCA6B)  # of lattices without a period
_BITS = np.uint32(0xFFFFFFFF)


class Usage(NamedTuple):
    """Which samples around a tag are used.

    Attributes:
        kinds: shape (n, n), what a sample at a place of the tag's frame tells, see `Templates`.
        shares: shape (3,), of the samples of every kind this share is used, of 2^32.
        row_step: every so many-th row of samples is looked at.
        cell: side of a place [m].
    """

    kinds: Bytes
    shares: Shares
    row_step: int
    cell: float


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


@compiled_part
def collect_pixels(
    image: Bytes, nodes: Floats, usage: Usage, separate: bool, pose: Floats, window: Window,
    places: Singles, values: Singles,
) -> int:  # fmt: skip
    """Collect the pixels around a tag.

    Args:
        image: shape (H, W, 3), BGR.
        nodes: of the floor map.
        usage: which samples are used.
        separate: whether to give B, G and R, or else the luma.
        pose: shape (3,), where the tag is looked for [m, m, rad].
        window: where samples are looked for.
        places: shape (2, N), receives the samples' floor points relative to the pose [m].
        values: shape (3, N), receives B, G and R, or in its first row the luma.

    Returns:
        Number of samples.
    """
    count, size = 0, float(usage.kinds.shape[0])
    kinds, shares, middle = usage.kinds, usage.shares, usage.kinds.shape[0] // 2 + 0.5
    c, s = np.cos(pose[2]) / usage.cell, np.sin(pose[2]) / usage.cell
    step = usage.row_step
    first, last = window.y - window.radius, min(window.y + window.radius + 1, image.shape[0])
    for y in range((max(first, 0) + step - 1) // step * step, last, step):
        reach = int(np.sqrt(window.radius**2 - (y - window.y) ** 2))
        start, end = max(window.x - reach, 0), min(window.x + reach + 1, image.shape[1])
        while start < end:
            stop = min(end, (start // PITCH + 1) * PITCH)  # linear up to the next node
            x0, y0 = floor_at(nodes, start, y)
            x1, y1 = floor_at(nodes, stop, y)
            x0, y0, x1, y1 = x0 - pose[0], y0 - pose[1], x1 - pose[0], y1 - pose[1]
            dx, dy = (x1 - x0) / (stop - start), (y1 - y0) / (stop - start)
            column, row = c * x0 + s * y0 + middle, c * y0 - s * x0 + middle
            across, along = c * dx + s * dy, c * dy - s * dx
            for x in range(start, stop):
                inside = 0.0 <= column < size and 0.0 <= row < size
                if inside and _chance(x, y) < shares[kinds[int(row), int(column)]]:
                    places[0, count], places[1, count] = (
                        x0 + (x - start) * dx,
                        y0 + (x - start) * dy,
                    )
                    blue, green, red = image[y, x, 0], image[y, x, 1], image[y, x, 2]
                    if separate:
                        values[0, count], values[1, count], values[2, count] = blue, green, red
                    else:
                        values[0, count] = 0.114 * blue + 0.587 * green + 0.299 * red
                    count += 1
                column += across
                row += along
            start = stop
    return count


@compiled_part
def collect_colors(
    image: Bytes, nodes: Floats, usage: Usage, offset: Floats, mix_rows: bool,
    pose: Floats, window: Window, places: Singles, values: Singles,
) -> int:  # fmt: skip
    """Collect the colours around a tag, as means of 2 x 2 pixels.

    Args:
        image: shape (H, W, 3), BGR.
        nodes: of the floor map.
        usage: which samples are used.
        offset: shape (2,), by which colours lie right of and below the brightness [px].
        mix_rows: mix the rows 1 : 6 : 1, as upsampling has mixed the columns.
        pose: shape (3,), where the tag is looked for [m, m, rad].
        window: where samples are looked for.
        places: shape (2, N), receives the samples' floor points relative to the pose [m].
        values: shape (3, N), receives in its first rows the blue and the red chroma.

    Returns:
        Number of samples.
    """
    count, size = 0, float(usage.kinds.shape[0])
    kinds, shares, middle = usage.kinds, usage.shares, usage.kinds.shape[0] // 2 + 0.5
    c, s = np.cos(pose[2]) / usage.cell, np.sin(pose[2]) / usage.cell
    last_x, last_y = image.shape[1] // 2 * 2 - 2, image.shape[0] // 2 * 2 - 2
    radius = window.radius + 1
    first, step = max(window.y - radius, 0), 2 * usage.row_step
    for y in range(first // step * step, min(window.y + radius, last_y) + 1, step):
        reach = int(np.sqrt(max(radius**2 - (y - window.y) ** 2, 0)))
        for x in range(max(window.x - reach, 0) // 2 * 2, min(window.x + reach, last_x) + 1, 2):
            dx, dy = floor_at(nodes, x + 0.5 - offset[0], y + 0.5 - offset[1])
            dx, dy = dx - pose[0], dy - pose[1]
            column, row = c * dx + s * dy + middle, c * dy - s * dx + middle
            if not (0.0 <= column < size and 0.0 <= row < size):
                continue
            if _chance(x, y) >= shares[kinds[int(row), int(column)]]:
                continue
            places[0, count], places[1, count] = dx, dy
            blue, red = _chroma_mean(image, x, y)
            if mix_rows:
                above = _chroma_mean(image, x, max(y - 2, 0))
                below = _chroma_mean(image, x, min(y + 2, last_y))
                blue = 0.75 * blue + 0.125 * (above[0] + below[0])
                red = 0.75 * red + 0.125 * (above[1] + below[1])
            values[0, count], values[1, count] = blue, red
            count += 1
    return count


@compiled_part
def _chance(x: int, y: int) -> int:
    """A number below 2^32 - 1 that depends on the pixel, evenly spread over any neighbourhood."""
    return int((np.uint32(x) * _SPREAD_X + np.uint32(y) * _SPREAD_Y) % _BITS)


@compiled_part
def _chroma_mean(image: Bytes, x: int, y: int) -> tuple[float, float]:
    """Blue and red chroma of the pixels (x, y) to (x + 1, y + 1), BT.601."""
    blue, green, red = 0, 0, 0
    for row in range(y, y + 2):
        for column in range(x, x + 2):
            blue += image[row, column, 0]
            green += image[row, column, 1]
            red += image[row, column, 2]
    return (
        0.125 * blue - 0.082816 * green - 0.042184 * red,
        -0.020328 * blue - 0.104672 * green + 0.125 * red,
    )
