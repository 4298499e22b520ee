"""Which robot is which, when only the geometry of tags and the names of their colours are known.

The print's colours are unknown, but the same on all robots, and near the scenario's nominal ones
seen under an unknown white balance and paled by an unknown share of stray light. Alternately,
robots are assigned to sightings (every robot once a picture) and the print's colours are taken from
those assigned, from many starts; the naming with the least cost stands.
"""

from dataclasses import dataclass
from itertools import combinations

import numpy as np
import scipy
from numpy.typing import NDArray

from vision.calibration.part_costs import PartColors
from vision.calibration.print_colors import PrintModel

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

UNSEEN = 9.0  # cost per coloured part of a robot that is not found
_OVERLAP = 0.8  # plates nearer than this share of their side are two readings of one place
_ROUNDS = 8
_STARTS = 24  # of the guesses at the print's colours, the best ones that are followed


@dataclass(frozen=True, slots=True)
class Naming:
    """Robots given to sightings.

    Attributes:
        rows: shape (M,), indices of the sightings that were given a robot.
        tags: shape (M,), the robots' indices in the tag set.
        costs: shape (M,), of each.
        margins: shape (M,), how much more the next best robot, or none, would cost there.
        rivals: shape (M,), index of that robot's tag; the tag's own if it is none.
        light: shape (M,), light on each tag, relative.
        prints: shape (C, 3), the print's colours in light 1, BGR.
        seen: shape (C,), which of them a named tag shows.
        strange: cost of the print's colours against the nominal ones.
        total: cost of everything; tags that might as well be another count little.
    """

    rows: Indices
    tags: Indices
    costs: Floats
    margins: Floats
    rivals: Indices
    light: Floats
    prints: Floats
    seen: NDArray[np.bool_]
    strange: float
    total: float


def name_tags(data: PartColors, model: PrintModel) -> tuple[Naming, ...]:
    """Name sightings.

    Args:
        data: colours of all sightings.
        model: what the nominal colours may look like.

    Returns:
        The naming with the least cost; after it, by their cost, others that are also consistent:
        those the iteration came to, and the best with two colours exchanged.
    """
    first = sorted((_assigned(data, guess, model) for guess in model.guesses), key=_total)
    settled = [_settled(data, naming, model) for naming in first[:_STARTS]]
    best = min(settled, key=_total)
    exchanged = []
    for one, other in combinations(np.flatnonzero(best.seen).tolist(), 2):
        prints = best.prints.copy()
        prints[[one, other]] = prints[[other, one]]
        exchanged.append(_assigned(data, prints, model))
    return best, *sorted((n for n in (*settled, *exchanged) if n is not best), key=_total)


def renamed(data: PartColors, one: Naming, other: Naming) -> tuple[tuple[int, int], ...]:
    """Find the colours that two namings call differently.

    Args:
        data: colours of all sightings.
        one: a naming.
        other: another.

    Returns:
        Pairs of colours: what most of the parts that have the first colour in the one naming are
        called in the other; only those that differ.
    """
    _, mine, theirs = np.intersect1d(one.rows, other.rows, return_indices=True)
    first, second = one.tags[mine], other.tags[theirs]
    used = (data.used[first] > 0) & (data.used[second] > 0)
    was, is_now = data.classes[first][used], data.classes[second][used]
    counts = np.zeros((len(one.prints), len(one.prints)), np.intp)
    np.add.at(counts, (was, is_now), 1)
    most = counts.argmax(axis=1)
    return tuple((c, int(m)) for c, m in enumerate(most) if counts[c].any() and m != c)


def _total(naming: Naming) -> float:
    return naming.total


def _settled(data: PartColors, naming: Naming, model: PrintModel) -> Naming:
    """Repeat taking colours from the assignment and assigning by the colours, until it stands."""
    for _ in range(_ROUNDS):
        after = _assigned(data, _reprinted(data, naming, model), model)
        stands = np.array_equal(after.rows, naming.rows) and np.array_equal(after.tags, naming.tags)
        naming = after
        if stands:
            break
    return naming


def _reprinted(data: PartColors, naming: Naming, model: PrintModel) -> Floats:
    """Colours of the print as the assigned sightings show them; the model's where none does."""
    used = data.used[naming.tags] > 0
    classes = data.classes[naming.tags][used]
    shown = (data.colors[naming.rows] / naming.light[:, None, None])[used]
    prints = naming.prints.copy()
    for color in np.unique(classes):
        prints[color] = np.median(shown[classes == color], axis=0)
    _, imagined = model.compare(prints, naming.seen)
    return np.where(naming.seen[:, None], prints, imagined)


def _assigned(data: PartColors, prints: Floats, model: PrintModel) -> Naming:
    """Give every robot, picture by picture, the sighting that costs least, or none."""
    costs, light = data.costs(prints)
    limits = UNSEEN * data.used.sum(axis=1)
    worth = np.minimum(costs - limits, 0.0)
    rows, tags = [np.zeros(0, np.intp)], [np.zeros(0, np.intp)]
    for frame in range(int(data.frames.max(initial=-1)) + 1):
        own = _free(data, worth.min(axis=1), np.flatnonzero(data.frames == frame))
        row, tag = _matched(worth[own])
        rows.append(own[row])
        tags.append(tag)
    row, tag = np.concatenate(rows), np.concatenate(tags)
    seen = np.zeros(len(prints), bool)
    seen[data.classes[tag][data.used[tag] > 0]] = True
    strange, _ = model.compare(prints, seen)
    rest, chosen = costs[row], costs[row, tag]
    rest[np.arange(len(row)), tag] = limits[tag]  # it might be no tag at all
    margins = rest.min(axis=1, initial=np.inf) - chosen
    rivals = rest.argmin(axis=1)
    told = 1.0 - np.exp(-0.5 * np.maximum(margins, 0.0))  # tags of one colour tell nothing
    total = float((worth[row, tag] * told).sum()) + strange
    lit = np.exp(light[row, tag])
    return Naming(row, tag, chosen, margins, rivals, lit, prints, seen, strange, total)


def _free(data: PartColors, worth: Floats, own: Indices) -> Indices:
    """Of sightings that overlap, those that are worth most; only those worth anything."""
    order = own[np.argsort(worth[own], kind="stable")]
    order = order[: np.searchsorted(worth[order], 0.0)]
    away = np.hypot(*(data.poses[order, None, :2] - data.poses[order, :2]).T)
    hides, hidden = away < _OVERLAP * data.sides[order], np.zeros(len(order), bool)
    for n in range(len(order)):
        if not hidden[n]:
            hidden[n + 1 :] |= hides[n, n + 1 :]
    return order[~hidden]


def _matched(worth: Floats) -> tuple[Indices, Indices]:
    """Pairs of rows and columns with the least sum, leaving out what is worth nothing."""
    rows, columns = scipy.optimize.linear_sum_assignment(worth)
    good = worth[rows, columns] < 0.0
    return rows[good].astype(np.intp), columns[good].astype(np.intp)
