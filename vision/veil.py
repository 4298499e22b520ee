"""A fit of one tag to pixels of which some are not its own: iteratively reweighted.

A pixel's residual counts against what noise, shades and a pose off by a slack can do to it; the
slack shrinks from step to step (graduated non-convexity, Blake and Zisserman 1987; weights of Geman
and McClure 1985). The colours of the tag's parts are known beforehand, about as the palette has
them: that tells the tag's own pixels from others.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vision.compiled import compiled, compiled_part
from vision.elimination import invert
from vision.floor_map import PITCH, floor_at
from vision.gauge import Gauge, Plane

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Bytes = NDArray[np.uint8]
Flags = NDArray[np.bool_]

_MOST_PIXELS = 900  # more are thinned out
_ON, _CORE = 0.6, 0.8  # coverage of the tag, or of a part: a pixel is on it
_OWN = 0.5  # weight of a pixel that is taken for the tag's own
_NOISE_FLOOR = 1.0  # of a pixel's values [grey levels]
_SHADE = 0.04  # by this share of its brightness a pixel may differ
_TINT, _FREE = 0.15, 40.0  # spread of the parts' colours: relative; of the floor's [grey levels]
_DARK = 8.0  # spread of black [grey levels]


class Known(NamedTuple):
    """What is known of a tag before the fit.

    Attributes:
        shape: its geometry.
        pose: shape (3,), where it is expected [m, m, rad].
        spread: shape (3,), standard deviations of that [m, m, rad].
        colors: shape (K, 3), BGR of its parts in the present light; 0 for black.
        plates: shape (P, 3), poses of robots beside it [m, m, rad].
        half: half the side of their plates [m].
    """

    shape: int
    pose: Floats
    spread: Floats
    colors: Floats
    plates: Floats
    half: float


class _Room(NamedTuple):
    """Samples: floor points (N, 2) from where the tag is expected, values (N, 3), weights (N,),
    whether they can be the tag's or the floor's (N,); of a sample, coverages (2, K + 1) and slopes
    (2, 2, K + 1) by pixel and colour template, and the design (K + 4,).
    """

    places: Floats
    values: Floats
    weights: Floats
    free: Flags
    covers: Floats
    slopes: Floats
    design: Floats


@compiled
def fit_veiled(
    image: Bytes, g: Gauge, known: Known, center: Floats, slacks: Floats, margin: float,
    pose: Floats, covariance: Floats, colors: Floats,
) -> tuple[float, float]:  # fmt: skip
    """Fit a tag to those pixels that can be its own.

    Args:
        image: shape (H, W, 3), BGR.
        g: templates, floor map and noise.
        known: what is known of the tag.
        center: shape (2,), where it is expected in the image [px].
        slacks: shape (S,), of the pose in every step, as shares of the spread.
        margin: a pose is never known better than this [m].
        pose: shape (3,), receives the pose [m, m, rad].
        covariance: shape (3, 3), receives its covariance [m^2, m rad, rad^2].
        colors: shape (K + 1, 3), receives BGR of the parts and the floor.

    Returns:
        Share of the tag's pixels that are not its own; rms of the others' residuals, normalised.
    """
    rows, columns = g.level.shape
    row = int(min(max(center[1] / PITCH + 0.5, 0.0), rows - 1.0))
    column = int(min(max(center[0] / PITCH + 0.5, 0.0), columns - 1.0))
    level, separate = g.level[row, column], len(g.pixels.noise) == 3
    luma = g.pixels.cells[level, known.shape, 0]
    chroma = luma if separate else g.colors.cells[level, known.shape, 0]
    parts, size = luma.shape[2], 4 * (g.radius + 1) ** 2
    room = _Room(
        np.empty((size, 2)), np.empty((size, 3)), np.ones(size), np.ones(size, np.bool_),
        np.empty((2, parts + 1)), np.empty((2, 2, parts + 1)), np.empty(parts + 4),
    )  # fmt: skip
    count = _collect(image, g, known, center, separate, room)
    typical, spread = np.empty((parts + 1, 3)), np.empty((parts + 1, 3))
    pose[:] = known.pose
    _expect(g, known, luma, count, separate, room, typical, spread)
    colors[:] = typical
    hidden, misfit = 1.0, 0.0
    for step in range(len(slacks)):
        slack = np.maximum(known.spread * slacks[step], np.array((margin, margin, margin / g.arm)))
        hidden, misfit = _weigh(g, luma, chroma, known, pose, colors, slack, count, room)
        prior = 1.0 if step < len(slacks) - 2 else 1e-6
        _improve(
            g, luma, chroma, known, typical, spread, prior, count, room, pose, colors, covariance
        )
    if not separate:
        _to_bgr(colors)
    return hidden, misfit


@compiled_part
def _collect(
    image: Bytes, g: Gauge, known: Known, center: Floats, separate: bool, room: _Room
) -> int:
    """Collect the pixels around a tag; returns their number."""
    x0, x1 = max(int(center[0]) - g.radius, 0), min(int(center[0]) + g.radius + 2, image.shape[1])
    y0, y1 = max(int(center[1]) - g.radius, 0), min(int(center[1]) + g.radius + 2, image.shape[0])
    count = 0
    stride = int(np.ceil((2.0 * g.radius + 1.0) ** 2 / _MOST_PIXELS))
    for y in range(y0, y1):
        for x in range(x0, x1):
            if (x * 7 + y * 3) % stride or count >= len(room.places):
                continue
            px, py = floor_at(g.nodes, x, y)
            room.places[count, 0], room.places[count, 1] = px - known.pose[0], py - known.pose[1]
            room.free[count] = _is_free(px, py, known)
            b, green, r = float(image[y, x, 0]), float(image[y, x, 1]), float(image[y, x, 2])
            if separate:
                room.values[count, 0], room.values[count, 1], room.values[count, 2] = b, green, r
            else:
                _to_ycc(b, green, r, room.values[count])
            count += 1
    return count


@compiled_part
def _is_free(x: float, y: float, known: Known) -> bool:
    """Whether a floor point lies on none of the plates beside a tag."""
    for n in range(len(known.plates)):
        dx, dy = x - known.plates[n, 0], y - known.plates[n, 1]
        c, s = np.cos(known.plates[n, 2]), np.sin(known.plates[n, 2])
        if max(abs(c * dx + s * dy), abs(c * dy - s * dx)) < known.half:
            return False
    return True


@compiled_part
def _look(
    cells: Singles, cell: float, place: Floats, known: Known, pose: Floats, covers: Floats,
    slopes: Floats,
) -> None:  # fmt: skip
    """Coverages of the parts, and of the floor last, at a sample, with slopes [1/cell]."""
    n, parts = cells.shape[0], cells.shape[2]
    c, s = np.cos(pose[2]) / cell, np.sin(pose[2]) / cell
    dx, dy = place[0] + known.pose[0] - pose[0], place[1] + known.pose[1] - pose[1]
    last = n - 1.001
    x = min(max(c * dx + s * dy + n // 2, 0.0), last)
    y = min(max(c * dy - s * dx + n // 2, 0.0), last)
    i, j = int(x), int(y)
    u, v = x - i, y - j
    covers[parts], slopes[0, parts], slopes[1, parts] = 1.0, 0.0, 0.0
    for k in range(parts):
        one, two = cells[j, i, k], cells[j, i + 1, k]
        three, four = cells[j + 1, i, k], cells[j + 1, i + 1, k]
        step, twist = two - one, (four - three) - (two - one)
        slope = (three - one) + u * twist
        covers[k] = one + u * step + v * slope
        slopes[0, k], slopes[1, k] = step + v * twist, slope
        covers[parts] -= covers[k]
        slopes[0, parts] -= slopes[0, k]
        slopes[1, parts] -= slopes[1, k]


@compiled_part
def _expect(
    g: Gauge, known: Known, luma: Singles, count: int, separate: bool, room: _Room,
    typical: Floats, spread: Floats,
) -> None:  # fmt: skip
    """Colours to expect of the parts and the floor, and how sure they are."""
    parts = len(typical) - 1
    covers, slopes = room.covers[0], room.slopes[0]
    logs, floor, many, around = np.empty(count), np.empty((3, count)), 0, 0
    shown, own = np.empty(3), np.empty((parts, 3))
    for k in range(parts):
        b, green, r = known.colors[k, 0], known.colors[k, 1], known.colors[k, 2]
        own[k, 0], own[k, 1], own[k, 2] = b, green, r
        if not separate:
            _to_ycc(b, green, r, own[k])
    for n in range(count):
        _look(luma, g.pixels.cell, room.places[n], known, known.pose, covers, slopes)
        if covers[parts] > 0.97 and room.free[n]:
            for channel in range(3):
                floor[channel, around] = room.values[n, channel]
            around += 1
        for k in range(parts):
            if covers[k] < _CORE or own[k].max() <= 0.0:
                continue
            length, like, size = 0.0, 0.0, 0.0
            for channel in range(3):
                shown[channel] = room.values[n, channel]
                length += shown[channel] ** 2
                size += own[k, channel] ** 2
                like += shown[channel] * own[k, channel]
            if like > 0.97 * np.sqrt(length * size) and length > 400.0:
                logs[many] = np.log(like / size)
                many += 1
    light = np.exp(np.median(logs[:many])) if many >= 4 else 1.0
    light = min(max(light, 0.4), 1.6)
    for channel in range(3):
        typical[parts, channel] = np.median(floor[channel, :around]) if around else 60.0
        spread[parts, channel] = _FREE
        for k in range(parts):
            typical[k, channel] = light * own[k, channel]
            loose = _TINT * light * np.sqrt((own[k] ** 2).sum())
            if own[k].max() <= 0.0:
                typical[k, channel] = 10.0 if channel == 0 or separate else 0.0
                loose = _DARK
            spread[k, channel] = np.hypot(loose, _DARK)


@compiled_part
def _plane(g: Gauge, channel: int, separate: bool) -> tuple[float, float, float, int]:
    """Cell, noise, weight and template of a channel."""
    if separate:
        return g.pixels.cell, g.pixels.noise[channel], 1.0, 0
    if channel == 0:
        return g.pixels.cell, g.pixels.noise[0], 1.0, 0
    return g.colors.cell, g.colors.noise[channel - 1], 0.25 * g.colors.independence, 1


@compiled_part
def _weigh(
    g: Gauge, luma: Singles, chroma: Singles, known: Known, pose: Floats, colors: Floats,
    slack: Floats, count: int, room: _Room,
) -> tuple[float, float]:  # fmt: skip
    """Weigh the samples by how strange they are; share of the tag's that are, rms of the rest."""
    parts, separate = len(colors) - 1, len(g.pixels.noise) == 3
    on, out, total, number = 0, 0, 0.0, 0.0
    for n in range(count):
        _look(luma, g.pixels.cell, room.places[n], known, pose, room.covers[0], room.slopes[0])
        if not separate:
            _look(chroma, g.colors.cell, room.places[n], known, pose, room.covers[1],
                  room.slopes[1])  # fmt: skip
        x, y = room.places[n, 0] + known.pose[0] - pose[0], room.places[n, 1] + known.pose[1] - pose[1]
        c, s = np.cos(pose[2]), np.sin(pose[2])
        x, y = c * x + s * y, c * y - s * x
        square = 0.0
        for channel in range(3):
            cell, noise, _, plane = _plane(g, channel, separate)
            model, ahead, aside, bright = 0.0, 0.0, 0.0, 0.0
            for k in range(parts + 1):
                model += room.covers[plane, k] * colors[k, channel]
                ahead += room.slopes[plane, 0, k] * colors[k, channel] / cell
                aside += room.slopes[plane, 1, k] * colors[k, channel] / cell
                bright += room.covers[plane, k] * abs(colors[k, channel])
            off = room.values[n, channel] - model
            turn = x * aside - y * ahead
            allowed = (
                noise**2 + _NOISE_FLOOR + (_SHADE * bright) ** 2 + (slack[0] * ahead) ** 2
                + (slack[1] * aside) ** 2 + (slack[2] * turn) ** 2
            )  # fmt: skip
            square += off * off / allowed
        weight = (_CUT / (_CUT + square)) ** 2
        if not room.free[n]:
            weight = 0.0
        elif room.covers[0, parts] < 1.0 - _ON:
            on += 1
            out += weight < _OWN
            if weight >= _OWN:
                total, number = total + square, number + 3.0
        room.weights[n] = weight
    return out / max(on, 1), np.sqrt(total / max(number, 1.0))


_CUT = 16.0  # sum of three squared normalised residuals at which a weight is a quarter


@compiled_part
def _improve(
    g: Gauge, luma: Singles, chroma: Singles, known: Known, typical: Floats, spread: Floats,
    prior: float, count: int, room: _Room, pose: Floats, colors: Floats, covariance: Floats,
) -> None:  # fmt: skip
    """A Gauss-Newton step of pose and colours, the colours eliminated."""
    parts, separate = len(colors) - 1, len(g.pixels.noise) == 3
    m = parts + 4
    normal, pull = np.zeros((3, m, m)), np.zeros((3, m))
    c, s = np.cos(pose[2]), np.sin(pose[2])
    design, squares, weights = room.design, np.zeros(3), 0.0
    for n in range(count):
        weight = room.weights[n]
        if weight < 0.02:
            continue
        _look(luma, g.pixels.cell, room.places[n], known, pose, room.covers[0], room.slopes[0])
        if room.covers[0, parts] > 0.999:
            continue
        if not separate:
            _look(chroma, g.colors.cell, room.places[n], known, pose, room.covers[1],
                  room.slopes[1])  # fmt: skip
        x, y = room.places[n, 0] + known.pose[0] - pose[0], room.places[n, 1] + known.pose[1] - pose[1]
        x, y = c * x + s * y, c * y - s * x
        weights += weight
        for channel in range(3):
            cell, noise, share, plane = _plane(g, channel, separate)
            off, ahead, aside = room.values[n, channel], 0.0, 0.0
            for k in range(parts + 1):
                design[k] = room.covers[plane, k]
                off -= design[k] * colors[k, channel]
                ahead -= room.slopes[plane, 0, k] * colors[k, channel] / cell
                aside -= room.slopes[plane, 1, k] * colors[k, channel] / cell
            design[parts + 1], design[parts + 2] = ahead, aside
            design[parts + 3] = x * aside - y * ahead
            factor = weight * share / (noise**2 + _NOISE_FLOOR)
            squares[channel] += weight * off * off / (noise**2 + _NOISE_FLOOR)
            for j in range(m):
                pull[channel, j] += factor * design[j] * off
                for k in range(j + 1):
                    normal[channel, j, k] += factor * design[j] * design[k]
    _solve(known, typical, spread, prior, normal, pull, squares, weights, pose, colors, covariance)


@compiled_part
def _solve(
    known: Known, typical: Floats, spread: Floats, prior: float, normal: Floats, pull: Floats,
    squares: Floats, weights: float, pose: Floats, colors: Floats, covariance: Floats,
) -> None:  # fmt: skip
    """Solve the normal equations (3, M, M), lower halves, and take the step."""
    parts = len(colors) - 1
    own, step, c, s = np.zeros((3, 3)), np.zeros(3), np.cos(pose[2]), np.sin(pose[2])
    inverses, work = np.empty((3, parts + 1, parts + 1)), np.empty((parts + 1, parts + 1))
    for channel in range(3):
        scale = (20.0 + weights) / (20.0 + squares[channel])  # residuals tell the noise
        for k in range(parts + 1):
            for j in range(k + 1):
                work[k, j] = work[j, k] = scale * normal[channel, k, j]
            work[k, k] += spread[k, channel] ** -2.0
            pull[channel, k] = (
                scale * pull[channel, k]
                + (typical[k, channel] - colors[k, channel]) * spread[k, channel] ** -2.0
            )
        invert(work, inverses[channel])
        for i in range(3):
            a = parts + 1 + i
            step[i] += scale * pull[channel, a]
            for j in range(3):
                b = parts + 1 + j
                own[i, j] += scale * normal[channel, max(a, b), min(a, b)]
                for p in range(parts + 1):
                    for q in range(parts + 1):
                        own[i, j] -= (
                            scale * scale * normal[channel, a, p] * inverses[channel, p, q]
                            * normal[channel, b, q]
                        )  # fmt: skip
            for p in range(parts + 1):
                for q in range(parts + 1):
                    step[i] -= scale * normal[channel, a, p] * inverses[channel, p, q] * pull[channel, q]
        normal[channel] *= scale
    dx, dy = known.pose[0] - pose[0], known.pose[1] - pose[1]
    turn = (known.pose[2] - pose[2] + np.pi) % (2.0 * np.pi) - np.pi
    back = (c * dx + s * dy, c * dy - s * dx, turn)
    for i in range(3):
        own[i, i] += prior * known.spread[i] ** -2.0
        step[i] += prior * known.spread[i] ** -2.0 * back[i]
    invert(own, covariance)
    move = np.zeros(3)
    for i in range(3):
        for j in range(3):
            move[i] += covariance[i, j] * step[j]
    longest = max(abs(move[0]), abs(move[1])) / known.spread[0]
    move /= max(longest, 1.0)
    for channel in range(3):
        for p in range(parts + 1):
            for q in range(parts + 1):
                rest = pull[channel, q]
                for j in range(3):
                    rest -= normal[channel, parts + 1 + j, q] * move[j]
                colors[p, channel] += inverses[channel, p, q] * rest
    pose[0] += c * move[0] - s * move[1]
    pose[1] += s * move[0] + c * move[1]
    pose[2] += move[2]
    turned = np.array(((c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0)))
    covariance[:] = turned @ covariance @ turned.T


@compiled_part
def _to_ycc(blue: float, green: float, red: float, ycc: Floats) -> None:
    """Luma, blue and red chroma, BT.601."""
    ycc[0] = 0.114 * blue + 0.587 * green + 0.299 * red
    ycc[1] = 0.5 * blue - 0.331264 * green - 0.168736 * red
    ycc[2] = -0.081312 * blue - 0.418688 * green + 0.5 * red


@compiled_part
def _to_bgr(colors: Floats) -> None:
    """Turn luma and chroma (K + 1, 3) into blue, green and red."""
    for k in range(len(colors)):
        y, b, r = colors[k, 0], colors[k, 1], colors[k, 2]
        colors[k, 0], colors[k, 2] = y + 1.772 * b, y + 1.402 * r
        colors[k, 1] = y - 0.344136 * b - 0.714136 * r
