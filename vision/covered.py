"""Tags partly under a hand or a cable: what does not look like the tag is taken out of the fit.

Pixels that the tag cannot show, wherever it lies within a slack around a pose, get the model's own
value: the fit then neither sees nor misses them (pseudo-values, Huber 1981). The model's colours
are medians over the parts, so that up to half of a part may be hidden.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.compiled import compiled
from vision.eye import Eye
from vision.floor_map import PITCH, floor_at
from vision.gauge import Gauge
from vision.pose import Fit, fit_poses

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Bytes = NDArray[np.uint8]
Indices = NDArray[np.intp]
Flags = NDArray[np.bool_]

_DOUBTFUL_PX, _DOUBTFUL = 0.25, 1.8  # misfit that makes one think: pixels, times the usual one

LEAST = 0.12
"""Share of a tag's pixels that must be strange before it is taken for covered."""

MOST = 0.65
"""Share of a tag's pixels left out while it is followed, at most; coarse colours' fringes count."""

_SLACKS = (0.003, 0.002, 0.0015)  # of the pose, from one fit to the next [m]
_STEPS = 8
_CORE, _ON_TAG = 0.8, 0.6  # coverage: for a part's colour; of the tag, without its rim
_NOISES = 4.0  # a pixel may differ by so many standard deviations
_SHADE = 0.15  # and by this share of its brightness
_BIAS = (0.006, 0.2)  # what a hidden tag's pose may be off, per share hidden [m], [rad]


@dataclass(frozen=True, slots=True)
class Uncovered:
    """Tags fitted without what lies on them.

    Attributes:
        fit: of the tags.
        hidden: shape (R,), share of every tag that was left out.
    """

    fit: Fit
    hidden: Floats

    def plain(self, limit_px: float) -> Flags:
        """Find the tags that are seen well enough.

        Args:
            limit_px: misfit of a clean tag, at most [px].

        Returns:
            Which they are, shape (R,).
        """
        return (self.hidden < MOST) & (self.fit.residual_px < limit_px)


def doubtful_px(usual_px: float) -> float:
    """Misfit of a tracked tag beyond which something may lie on it.

    Args:
        usual_px: misfit of tags through this camera [px].

    Returns:
        The limit [px].
    """
    return max(_DOUBTFUL_PX, _DOUBTFUL * usual_px)


def fit_uncovered(image: Bytes, eye: Eye, shapes: Indices, start: Floats) -> Uncovered:
    """Fit tags of which a part may be covered, each from where it is expected.

    Args:
        image: shape (H, W, 3), BGR.
        eye: templates and noise.
        shapes: shape (R,), geometry of every tag.
        start: shape (R, 3), x, y, theta on the floor [m, m, rad].

    Returns:
        The tags; covariances include what is not known of the covered ones.
    """
    poses, hidden = start, np.zeros(len(start))
    for slack in _SLACKS:
        centers, cleared = eye.camera.tag_pixels(poses), image.copy()
        for n in range(len(poses)):
            hidden[n] = _clear(
                image, cleared, eye.gauge, int(shapes[n]), poses[n], centers[n], slack
            )
        fit = fit_poses(cleared, eye.gauge, shapes, poses, centers, _STEPS)
        poses = np.where(np.isfinite(fit.poses), fit.poses, start)
    off = np.column_stack((hidden * _BIAS[0], hidden * _BIAS[0], hidden * _BIAS[1]))
    left = np.maximum(1.0 - hidden, 0.1)
    covariances = fit.covariances / left[:, None, None] + np.eye(3) * off[:, None] ** 2
    return Uncovered(Fit(fit.poses, covariances, fit.residual_px, fit.colors), hidden)


@compiled
def _clear(
    image: Bytes, cleared: Bytes, g: Gauge, shape: int, pose: Floats, center: Floats, slack: float
) -> float:
    """Replace what a tag cannot show; returns the share of its samples."""
    rows, columns = g.level.shape
    row = int(min(max(center[1] / PITCH + 0.5, 0.0), rows - 1.0))
    column = int(min(max(center[0] / PITCH + 0.5, 0.0), columns - 1.0))
    cells, cell, radius = g.pixels.cells[g.level[row, column], shape, 0], g.pixels.cell, g.radius
    parts, middle, shift = cells.shape[2], cells.shape[0] // 2, slack / g.pixels.cell
    x0, x1 = max(int(center[0]) - radius, 0), min(int(center[0]) + radius + 1, image.shape[1])
    y0, y1 = max(int(center[1]) - radius, 0), min(int(center[1]) + radius + 1, image.shape[0])
    if x1 <= x0 or y1 <= y0:
        return 1.0
    count = (x1 - x0) * (y1 - y0)
    places, covers = np.empty((count, 2)), np.empty((count, parts + 1))
    c, s, n = np.cos(pose[2]) / cell, np.sin(pose[2]) / cell, 0
    for y in range(y0, y1):
        for x in range(x0, x1):
            px, py = floor_at(g.nodes, x, y)
            px, py = px - pose[0], py - pose[1]
            places[n, 0], places[n, 1] = c * px + s * py + middle, c * py - s * px + middle
            _covers(cells, places[n, 0], places[n, 1], covers[n])
            n += 1
    colors = _medians(image[y0:y1, x0:x1], covers)
    on, out = 0, 0
    model, room = np.empty(3), _NOISES * g.pixels.noise.max()
    for n in range(count):
        y, x = y0 + n // (x1 - x0), x0 + n % (x1 - x0)
        if covers[n, parts] < 1.0 - _ON_TAG:
            on += 1
            if _strangeness(cells, places[n], shift, colors, image[y, x], model) > room:
                out += 1
                for channel in range(3):
                    cleared[y, x, channel] = int(min(max(model[channel] + 0.5, 0.0), 255.0))
    return out / max(on, 1)


@compiled
def _strangeness(
    cells: Singles, place: Floats, shift: float, colors: Floats, seen: Bytes, model: Floats
) -> float:
    """How far a pixel is from all a tag shows near a place; model receives what it shows there."""
    near, away = np.empty(len(colors)), 0.0
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for side in range(5):
        dx, dy = shift * ((side == 1) - (side == 2)), shift * ((side == 3) - (side == 4))
        _covers(cells, place[0] + dx, place[1] + dy, near)
        for channel in range(3):
            value = 0.0
            for k in range(len(near)):
                value += near[k] * colors[k, channel]
            if side == 0:
                model[channel] = value
            low[channel], high[channel] = min(low[channel], value), max(high[channel], value)
    for channel in range(3):
        off = max(low[channel] - seen[channel], seen[channel] - high[channel])
        away = max(away, off - _SHADE * high[channel])
    return away


@compiled
def _covers(cells: Singles, x: float, y: float, covers: Floats) -> None:
    """Coverages of the parts, and of the floor last, at a place of the template [cells]."""
    last, parts, rest = cells.shape[0] - 1.001, cells.shape[2], 1.0
    x, y = min(max(x, 0.0), last), min(max(y, 0.0), last)
    i, j = int(x), int(y)
    u, v = x - i, y - j
    for k in range(parts):
        one = cells[j, i, k] + u * (cells[j, i + 1, k] - cells[j, i, k])
        two = cells[j + 1, i, k] + u * (cells[j + 1, i + 1, k] - cells[j + 1, i, k])
        covers[k] = one + v * (two - one)
        rest -= covers[k]
    covers[parts] = rest


@compiled
def _medians(pixels: Bytes, covers: Floats) -> Floats:
    """Colours (K + 1, 3) of the parts and of the floor: medians where little else is seen."""
    width, kinds = pixels.shape[1], covers.shape[1]
    colors = np.zeros((kinds, 3))
    for k in range(kinds):
        least = min(_CORE, 0.9 * covers[:, k].max())
        inside = np.flatnonzero(covers[:, k] >= least)
        own = np.empty(len(inside))
        for channel in range(3):
            for n in range(len(inside)):
                own[n] = pixels[inside[n] // width, inside[n] % width, channel]
            colors[k, channel] = np.median(own)
    return colors
