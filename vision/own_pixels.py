"""The pixels around a tag that may be covered, and the colours to expect of its parts."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vision.compiled import compiled_part
from vision.floor_map import floor_at
from vision.gauge import Gauge

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Bytes = NDArray[np.uint8]

_MOST_PIXELS = 900  # more are thinned out
_CORE, _AROUND = 0.8, 0.97  # coverage: of a part, of the floor: then a pixel tells its colour
_LIKE, _LIT = 0.97, 20.0  # cosine to a part's colour, and length: then it tells the light on it
_LIGHT, _FEW = (0.4, 1.6), 4  # on the tag, and pixels that tell it, at least
_TINT, _FREE = 0.1, 40.0  # spread of the parts' colours: relative; of the floor's [grey levels]
_BLACK, _DARK = 10.0, 8.0  # brightness of black, and its spread [grey levels]
_FLOOR = 60.0  # brightness of a floor that is not seen


class Known(NamedTuple):
    """What is known of a tag before the fit.

    Attributes:
        shape: its geometry.
        pose: shape (3,), where it is expected [m, m, rad].
        spread: shape (3,), standard deviations of that [m, m, rad].
        colors: shape (K, 3), BGR of its parts in the present light; 0 for black.
    """

    shape: int
    pose: Floats
    spread: Floats
    colors: Floats


class Pixels(NamedTuple):
    """Samples around a tag, and work space.

    Attributes:
        places: shape (N, 2), floor points relative to where the tag is expected [m].
        values: shape (N, 3), BGR, or luma, blue and red chroma.
        covers: shape (2, K + 1), of one sample: coverages of the parts, and the floor last, by the
            templates of pixels and of colours.
        slopes: shape (2, 2, K + 1), their slopes by x and y [1/m].
    """

    places: Floats
    values: Floats
    covers: Floats
    slopes: Floats


@compiled_part
def collect_around(image: Bytes, g: Gauge, known: Known, center: Floats, pixels: Pixels) -> int:
    """Collect the pixels around a tag, of large tags every so many.

    Args:
        image: shape (H, W, 3), BGR.
        g: floor map and noise.
        known: of the tag.
        center: shape (2,), where it is expected in the image [px].
        pixels: receives places and values.

    Returns:
        Their number.
    """
    x0, x1 = max(int(center[0]) - g.radius, 0), min(int(center[0]) + g.radius + 2, image.shape[1])
    y0, y1 = max(int(center[1]) - g.radius, 0), min(int(center[1]) + g.radius + 2, image.shape[0])
    stride, count = int(np.ceil((2.0 * g.radius + 1.0) ** 2 / _MOST_PIXELS)), 0
    for y in range(y0, y1):
        for x in range(x0, x1):
            if (x * 7 + y * 3) % stride:
                continue
            px, py = floor_at(g.nodes, x, y)
            pixels.places[count, 0] = px - known.pose[0]
            pixels.places[count, 1] = py - known.pose[1]
            for channel in range(3):
                pixels.values[count, channel] = image[y, x, channel]
            if len(g.pixels.noise) == 1:
                _to_ycc(pixels.values[count])
            count += 1
    return count


@compiled_part
def look_at(
    cells: Singles, cell: float, x: float, y: float, covers: Floats, slopes: Floats
) -> None:
    """Look a place of a tag up in a template.

    Args:
        cells: shape (n, n, K), of the template.
        cell: side of a cell [m].
        x: forward [m].
        y: left [m].
        covers: shape (K + 1,), receives the coverages of the parts, and of the floor last.
        slopes: shape (2, K + 1), receives their slopes by x and y [1/m].
    """
    n, parts, last = cells.shape[0], cells.shape[2], cells.shape[0] - 1.001
    x = min(last, max(0.0, x / cell + n // 2))  # nan becomes 0
    y = min(last, max(0.0, y / cell + n // 2))
    i, j = int(x), int(y)
    u, v = x - i, y - j
    covers[parts], slopes[0, parts], slopes[1, parts] = 1.0, 0.0, 0.0
    for k in range(parts):
        one, two = cells[j, i, k], cells[j, i + 1, k]
        three, four = cells[j + 1, i, k], cells[j + 1, i + 1, k]
        step, twist = two - one, (four - three) - (two - one)
        slope = (three - one) + u * twist
        covers[k] = one + u * step + v * slope
        slopes[0, k], slopes[1, k] = (step + v * twist) / cell, slope / cell
        covers[parts] -= covers[k]
        slopes[0, parts] -= slopes[0, k]
        slopes[1, parts] -= slopes[1, k]


@compiled_part
def expect_colors(
    g: Gauge, known: Known, cells: Singles, count: int, pixels: Pixels, typical: Floats,
    spread: Floats,
) -> None:  # fmt: skip
    """Find the colours to expect of the parts and the floor, and how sure they are.

    Args:
        g: noise.
        known: of the tag.
        cells: shape (n, n, K), template of pixels.
        count: number of pixels.
        pixels: around the tag.
        typical: shape (K + 1, 3), receives the colours, the floor's last.
        spread: shape (K + 1, 3), receives their standard deviations.
    """
    parts, separate = len(typical) - 1, len(g.pixels.noise) == 3
    own = known.colors.copy()
    if not separate:
        for k in range(parts):
            _to_ycc(own[k])
    light = _light_and_floor(g, known, cells, count, pixels, own, typical[parts])
    for k in range(parts):
        length = np.sqrt((own[k] ** 2).sum())
        for channel in range(3):
            typical[k, channel] = light * own[k, channel]
            spread[k, channel] = np.hypot(_TINT * light * length, _DARK)
            if length == 0.0 and (separate or channel == 0):
                typical[k, channel] = _BLACK
    spread[parts] = _FREE


@compiled_part
def _light_and_floor(
    g: Gauge, known: Known, cells: Singles, count: int, pixels: Pixels, own: Floats, floor: Floats
) -> float:
    """Light on the parts (K, 3) by the pixels that look like them; and the floor's colour (3,)."""
    parts, covers = len(own), pixels.covers[0]
    logs, around, many, free = np.empty(count * parts), np.empty((3, count)), 0, 0
    c, s = np.cos(known.pose[2]), np.sin(known.pose[2])
    for n in range(count):
        dx, dy, value = pixels.places[n, 0], pixels.places[n, 1], pixels.values[n]
        look_at(cells, g.pixels.cell, c * dx + s * dy, c * dy - s * dx, covers, pixels.slopes[0])
        if covers[parts] > _AROUND:
            around[:, free] = value
            free += 1
        for k in range(parts):
            size, length = (own[k] ** 2).sum(), (value**2).sum()
            like = (own[k] * value).sum()
            lit = covers[k] >= _CORE and size > 0.0 and length > _LIT**2
            if lit and like > _LIKE * np.sqrt(length * size):
                logs[many] = np.log(like / size)
                many += 1
    for channel in range(3):
        floor[channel] = np.median(around[channel, :free]) if free else _FLOOR
    light = np.exp(np.median(logs[:many])) if many >= _FEW else 1.0
    return float(min(max(light, _LIGHT[0]), _LIGHT[1]))


@compiled_part
def _to_ycc(color: Floats) -> None:
    """Turn blue, green and red into luma, blue and red chroma, BT.601."""
    blue, green, red = color[0], color[1], color[2]
    color[0] = 0.114 * blue + 0.587 * green + 0.299 * red
    color[1] = 0.5 * blue - 0.331264 * green - 0.168736 * red
    color[2] = -0.081312 * blue - 0.418688 * green + 0.5 * red
