"""How well fitted colours go with tags, and what they say of the light; compiled."""

import numpy as np
from numpy.typing import NDArray

from vision.compiled import compiled
from vision.shapes import Looks

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

_ANGLE, _NOISE = 0.12, 6.0  # spread of a colour's direction [rad], and of its values [grey levels]
_ANY = 6.0  # cost of a part that may have any colour
_FAR = 60.0  # half of the largest cost that matters
_DARK, _BRIGHT = 20.0, 250.0  # values beyond tell nothing of the light
_TYPICAL = 80.0  # neither does a channel of which a colour has less


@compiled
def score_colors(
    colors: Floats, shapes: Indices, looks: Looks, gains: Floats,
    possible: NDArray[np.bool_], spread: float, scores: Floats,
) -> None:  # fmt: skip
    """Find the probability that candidates have the colours of tags, rather than any colours.

    The cost of a part (-2 log likelihood) is told by the angle between its colour and the one
    learned, which no brightness changes, and by how its light differs from that of the other parts.
    Black that is brighter than a colour costs, too.

    Args:
        colors: shape (N, K + 1, 3), BGR.
        shapes: shape (N,), geometry of the candidates.
        looks: of the tags.
        gains: shape (3,), factors of the light on the palette's colours, BGR.
        possible: shape (N, T), which tag each candidate may be.
        spread: standard deviation of the logarithm of the light between the parts of a tag.
        scores: shape (N, T), receives the probabilities, 0 where a tag is not possible.
    """
    for n in range(len(shapes)):
        for tag in range(possible.shape[1]):
            scores[n, tag] = 0.0
            if possible[n, tag] and looks.shape_of[tag] == shapes[n]:
                cost, parts = _cost(colors[n], tag, looks, gains, spread)
                scores[n, tag] = 1.0 / (1.0 + np.exp(min(0.5 * (cost - _ANY * parts), _FAR)))


@compiled
def _cost(
    colors: Floats, tag: int, looks: Looks, gains: Floats, spread: float
) -> tuple[float, int]:
    """Cost of the colours (K + 1, 3) for a tag, and its number of coloured parts."""
    cost, light, squares, parts = 0.0, 0.0, 0.0, 0
    darkest, black = np.inf, 1.0
    for k in range(looks.part_counts[looks.shape_of[tag]]):
        length, angle, level = compare_color(colors[k], looks.typical[tag, k], gains)
        if looks.classes[tag, k] == 0:
            black = max(black, length)
            continue
        own = angle * angle / (_ANGLE**2 + (_NOISE / length) ** 2)
        cost += own if length > _NOISE else max(own, 2.0 * _ANY)  # the dark has no colour
        light, squares, parts = light + level, squares + level * level, parts + 1
        darkest = min(darkest, length)
    unlike = squares - light * light / max(parts, 1)
    brighter = max(np.log(black / darkest), 0.0)
    return cost + (unlike + brighter * brighter) / spread**2, parts


@compiled
def compare_color(color: Floats, typical: Floats, gains: Floats) -> tuple[float, float, float]:
    """Compare a colour with one that was learned.

    Args:
        color: shape (3,), BGR as seen.
        typical: shape (3,), BGR as learned.
        gains: shape (3,), factors of the light, BGR.

    Returns:
        Its length [grey levels], at least 1; the angle between the two [rad]; the logarithm of the
        light on it.
    """
    shared, seen, known = 0.0, 0.0, 0.0
    for channel in range(3):
        value = max(color[channel] / gains[channel], 0.0)
        shared += value * typical[channel]
        seen += value * value
        known += typical[channel] * typical[channel]
    seen, known = max(seen, 1.0), max(known, 1.0)
    angle = np.arccos(min(max(shared / np.sqrt(seen * known), -1.0), 1.0))
    return np.sqrt(seen), angle, 0.5 * np.log(seen / known)


@compiled
def color_ratios(colors: Floats, tags: Indices, looks: Looks, ratios: Floats) -> None:
    """Divide the colours of accepted tags by what the palette has learned.

    Args:
        colors: shape (N, K + 1, 3), BGR.
        tags: shape (N,), index of the tag of every candidate, negative for none.
        looks: of the tags.
        ratios: shape (N, K, 3), receives the ratios; NaN where there is no coloured part, or it is
            too dark or saturated.
    """
    ratios[:] = np.nan
    for n in range(len(tags)):
        for k in range(looks.classes.shape[1]):
            if tags[n] < 0 or looks.classes[tags[n], k] == 0:
                continue
            for channel in range(3):
                seen, typical = colors[n, k, channel], looks.typical[tags[n], k, channel]
                if typical > _TYPICAL and _DARK < seen < _BRIGHT:
                    ratios[n, k, channel] = seen / typical
