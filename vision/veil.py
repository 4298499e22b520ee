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
from vision.gauge import Gauge

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Bytes = NDArray[np.uint8]

_MOST_PIXELS = 900  # more are thinned out
_ON, _CORE = 0.6, 0.8  # coverage of the tag, or of a part: a pixel is on it
_OWN = 0.15  # weight of a pixel that may be the tag's own, at least
_FLOOR = 0.995  # of a sample: then it tells nothing of the tag
_NOTHING = 0.02  # a weight that makes no difference
_CUT = 9.0  # squared normalised residual of a sample at which its weight is a quarter
_ROUNDING = 1.0  # and what the templates leave out: variance of a sample [grey levels^2]
_SHADE = 0.04  # by this share of its brightness a pixel may differ
_TINT, _FREE = 0.1, 40.0  # spread of the parts' colours: relative; of the floor's [grey levels]
_DARK = 8.0  # spread of black [grey levels]


class Known(NamedTuple):
    """What is known of a tag before the fit.

    Attributes:
        shape: its geometry.
        pose: shape (3,), where it is expected [m, m, rad].
        spread: shape (3,), standard deviations of that [m, m, rad].
        colors: shape (K, 3), BGR of its parts in the present light; 0 for black.
        plates: shape (P, V, 2), corners of the plates of robots beside it, convex [m].
    """

    shape: int
    pose: Floats
    spread: Floats
    colors: Floats
    plates: Floats


class _Room(NamedTuple):
    """Samples: floor points (N, 2) from where the tag is expected, values (N, 3). Of one sample:
    coverages (2, K + 1) and slopes (2, 2, K + 1) by pixel and colour template; residuals and
    slopes ahead, aside and by a turn (4, 3); a row of the design (K + 4,).
    """

    places: Floats
    values: Floats
    covers: Floats
    slopes: Floats
    seen: Floats
    design: Floats


class _Sums(NamedTuple):
    """Normal equations of K + 1 brightnesses and the pose, for each channel: matrices (3, M, M),
    lower halves, and gradients (3, M); squared residuals, the samples' weight, and squared slopes
    (5,).
    """

    normal: Floats
    pull: Floats
    squares: Floats


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
        Share of the tag's pixels that are not its own; rms misfit of the others as a displacement of
        edges [m].
    """
    rows, columns = g.level.shape
    row = int(min(max(center[1] / PITCH + 0.5, 0.0), rows - 1.0))
    column = int(min(max(center[0] / PITCH + 0.5, 0.0), columns - 1.0))
    level, separate = g.level[row, column], len(g.pixels.noise) == 3
    luma = g.pixels.cells[level, known.shape, 0]
    chroma = luma if separate else g.colors.cells[level, known.shape, 0]
    parts, size = luma.shape[2], 4 * (g.radius + 1) ** 2
    room = _Room(
        np.empty((size, 2)), np.empty((size, 3)), np.empty((2, parts + 1)),
        np.empty((2, 2, parts + 1)), np.empty((4, 3)), np.empty(parts + 4),
    )  # fmt: skip
    count = _collect(image, g, known, center, separate, room)
    typical, spread = np.empty((parts + 1, 3)), np.empty((parts + 1, 3))
    pose[:] = known.pose
    _expect(g, known, luma, count, separate, room, typical, spread)
    colors[:] = typical
    hidden, m = 1.0, parts + 4
    sums = _Sums(np.empty((3, m, m)), np.empty((3, m)), np.empty(5))
    for step in range(len(slacks)):
        slack = np.maximum(known.spread * slacks[step], np.array((margin, margin, margin / g.arm)))
        hidden = _sum_up(g, luma, chroma, known, pose, colors, slack, count, room, sums)
        prior = 1.0 if step < len(slacks) - 2 else 1e-6
        _solve(known, typical, spread, prior, sums, pose, colors, covariance)
    if not separate:
        _to_bgr(colors)
    return hidden, np.sqrt(sums.squares[:3].sum() / max(sums.squares[4], 1e-9))


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
            if not _is_free(px, py, known.plates):
                continue
            room.places[count, 0], room.places[count, 1] = px - known.pose[0], py - known.pose[1]
            b, green, r = float(image[y, x, 0]), float(image[y, x, 1]), float(image[y, x, 2])
            if separate:
                room.values[count, 0], room.values[count, 1], room.values[count, 2] = b, green, r
            else:
                _to_ycc(b, green, r, room.values[count])
            count += 1
    return count


@compiled_part
def _is_free(x: float, y: float, plates: Floats) -> bool:
    """Whether a floor point lies on none of some convex plates (P, V, 2)."""
    corners = plates.shape[1]
    for n in range(len(plates)):
        left, right = False, False
        for k in range(corners):
            x0, y0 = plates[n, k, 0], plates[n, k, 1]
            x1, y1 = plates[n, (k + 1) % corners, 0], plates[n, (k + 1) % corners, 1]
            side = (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0)
            left, right = left or side > 0.0, right or side < 0.0
        if not (left and right):
            return False
    return True


@compiled_part
def _look(
    cells: Singles, cell: float, x: float, y: float, covers: Floats, slopes: Floats
) -> None:
    """Coverages of the parts, and of the floor last, at a place of the tag, and slopes [1/m]."""
    n, parts, last = cells.shape[0], cells.shape[2], cells.shape[0] - 1.001
    x = min(max(x / cell + n // 2, 0.0), last)
    y = min(max(y / cell + n // 2, 0.0), last)
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
def _expect(
    g: Gauge, known: Known, luma: Singles, count: int, separate: bool, room: _Room,
    typical: Floats, spread: Floats,
) -> None:  # fmt: skip
    """Colours to expect of the parts and the floor, and how sure they are."""
    parts = len(typical) - 1
    covers, slopes = room.covers[0], room.slopes[0]
    logs, floor, many, around = np.empty(count), np.empty((3, count)), 0, 0
    shown, own = np.empty(3), np.empty((parts, 3))
    c, s = np.cos(known.pose[2]), np.sin(known.pose[2])
    for k in range(parts):
        b, green, r = known.colors[k, 0], known.colors[k, 1], known.colors[k, 2]
        own[k, 0], own[k, 1], own[k, 2] = b, green, r
        if not separate:
            _to_ycc(b, green, r, own[k])
    for n in range(count):
        x, y = c * room.places[n, 0] + s * room.places[n, 1], c * room.places[n, 1] - s * room.places[n, 0]
        _look(luma, g.pixels.cell, x, y, covers, slopes)
        if covers[parts] > 0.97:
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
def _sum_up(
    g: Gauge, luma: Singles, chroma: Singles, known: Known, pose: Floats, colors: Floats,
    slack: Floats, count: int, room: _Room, sums: _Sums,
) -> float:  # fmt: skip
    """Weigh the samples, and set up their normal equations; share of the tag's that are strange."""
    parts, on, out = len(colors) - 1, 0, 0
    sums.normal[:], sums.pull[:], sums.squares[:] = 0.0, 0.0, 0.0
    c, s = np.cos(pose[2]), np.sin(pose[2])
    for n in range(count):
        dx = room.places[n, 0] + known.pose[0] - pose[0]
        dy = room.places[n, 1] + known.pose[1] - pose[1]
        x, y = c * dx + s * dy, c * dy - s * dx
        _look(luma, g.pixels.cell, x, y, room.covers[0], room.slopes[0])
        if room.covers[0, parts] > _FLOOR:
            continue
        if len(g.pixels.noise) == 1:
            _look(chroma, g.colors.cell, x, y, room.covers[1], room.slopes[1])
        square = _compare(g, x, y, room.values[n], colors, slack, room)
        weight = (_CUT / (_CUT + square)) ** 2
        if room.covers[0, parts] < 1.0 - _ON:
            on += 1
            out += weight < _OWN
        if weight > _NOTHING:
            _add(g, weight, room, sums)
    return out / max(on, 1)


@compiled_part
def _compare(
    g: Gauge, x: float, y: float, value: Floats, colors: Floats, slack: Floats, room: _Room
) -> float:
    """Residuals and slopes of a sample into the room; the squared residual, normalised."""
    square, parts = 0.0, len(colors) - 1
    for channel in range(3):
        noise, _, plane = _plane(g, channel)
        off, ahead, aside, bright = value[channel], 0.0, 0.0, 0.0
        for k in range(parts + 1):
            color = colors[k, channel]
            off -= room.covers[plane, k] * color
            ahead -= room.slopes[plane, 0, k] * color
            aside -= room.slopes[plane, 1, k] * color
            bright += room.covers[plane, k] * abs(color)
        turn = x * aside - y * ahead
        room.seen[0, channel], room.seen[1, channel] = off, ahead
        room.seen[2, channel], room.seen[3, channel] = aside, turn
        allowed = (
            noise + (_SHADE * bright) ** 2 + (slack[0] * ahead) ** 2 + (slack[1] * aside) ** 2
            + (slack[2] * turn) ** 2
        )  # fmt: skip
        square += off * off / allowed
    return square


@compiled_part
def _add(g: Gauge, weight: float, room: _Room, sums: _Sums) -> None:
    """Add a sample to the normal equations."""
    kinds, design = room.covers.shape[1], room.design
    sums.squares[3] += weight
    for channel in range(3):
        noise, share, plane = _plane(g, channel)
        off = room.seen[0, channel]
        for k in range(kinds):
            design[k] = room.covers[plane, k]
        for k in range(3):
            design[kinds + k] = room.seen[1 + k, channel]
        sums.squares[channel] += weight * off * off / noise
        sums.squares[4] += weight * (design[kinds] ** 2 + design[kinds + 1] ** 2) / noise
        factor = weight * share / noise
        for j in range(kinds + 3):
            one = factor * design[j]
            sums.pull[channel, j] += one * off
            for k in range(j + 1):
                sums.normal[channel, j, k] += one * design[k]


@compiled_part
def _plane(g: Gauge, channel: int) -> tuple[float, float, int]:
    """Variance, independence and template of a channel."""
    if len(g.pixels.noise) == 3:
        return g.pixels.noise[channel] ** 2 + _ROUNDING, 1.0, 0
    if channel == 0:
        return g.pixels.noise[0] ** 2 + _ROUNDING, 1.0, 0
    return g.colors.noise[channel - 1] ** 2 + _ROUNDING, 0.25 * g.colors.independence, 1


@compiled_part
def _solve(
    known: Known, typical: Floats, spread: Floats, prior: float, sums: _Sums, pose: Floats, colors: Floats, covariance: Floats,
) -> None:  # fmt: skip
    """Solve the normal equations (3, M, M), lower halves, and take the step."""
    parts, normal, pull = len(colors) - 1, sums.normal, sums.pull
    own, step, c, s = np.zeros((3, 3)), np.zeros(3), np.cos(pose[2]), np.sin(pose[2])
    inverses, work = np.empty((3, parts + 1, parts + 1)), np.empty((parts + 1, parts + 1))
    for channel in range(3):
        scale = (20.0 + sums.squares[3]) / (20.0 + sums.squares[channel])  # residuals tell the noise
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
