"""Who is who where colours do not tell: by where robots are expected, and what remains in doubt.

Robots that wear the same tag are told apart by continuity. One that was lost is known by
elimination; of two lost at once each may be the other, unless neither can have come so far.
"""

from dataclasses import dataclass, replace

import numpy as np
import scipy
from numpy.typing import NDArray

from control.command import RobotId
from control.geometry import Pose2D
from vision.assignment import NOBODY
from vision.scene import Detection
from vision.tags import TagSet

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
Flags = NDArray[np.bool_]

_FINEST = 0.005  # spread of the best prediction [m]
_UNKNOWN = 10.0  # spread of a robot that is expected nowhere [m]
_FITTING = 0.5  # of a candidate's best score, for the tag that pairing gives it
_SLACK = 0.05  # error of a prediction, at most [m]


@dataclass(frozen=True, slots=True)
class Prediction:
    """Where a robot is expected in the frame.

    Attributes:
        robot_id: the robot.
        pose: on the floor [m, m, rad].
        covariance: of the pose, shape (3, 3) [m^2, m rad, rad^2].
        reach: how far it may have been carried from there, 0 if it was seen lately [m].
        ambiguous: whether it may be another robot that wears the same tag.
    """

    robot_id: RobotId
    pose: Pose2D
    covariance: Floats
    reach: float = 0.0
    ambiguous: bool = False


@dataclass(frozen=True, slots=True)
class Expectation:
    """Predictions in the order of the tag set.

    Attributes:
        places: shape (T, 2), NaN where a robot is not expected anywhere [m].
        spreads: shape (T,), of the places; `_UNKNOWN` where there is none [m].
        reach: shape (T,), see `Prediction`; infinite where there is none [m].
        ambiguous: shape (T,), see `Prediction`.
    """

    places: Floats
    spreads: Floats
    reach: Floats
    ambiguous: Flags


def expect(tags: TagSet, predictions: tuple[Prediction, ...]) -> Expectation:
    """Put predictions in the order of the tags.

    Args:
        tags: of the robots.
        predictions: those not in the tag set, or not finite, are ignored.

    Returns:
        The expectation.
    """
    index = {robot_id: n for n, robot_id in enumerate(tags.ids)}
    count = len(tags.tags)
    places, spreads = np.full((count, 2), np.nan), np.full(count, _UNKNOWN)
    reach, ambiguous = np.full(count, np.inf), np.zeros(count, np.bool_)
    for p in predictions:
        place = np.array((p.pose.x, p.pose.y))
        if p.robot_id in index and np.isfinite(place).all():
            n = index[p.robot_id]
            places[n], reach[n], ambiguous[n] = place, p.reach, p.ambiguous
            variance = 0.5 * float(p.covariance[0, 0] + p.covariance[1, 1])
            spreads[n] = min(np.sqrt(_FINEST**2 + variance + p.reach**2), _UNKNOWN)
    return Expectation(places, spreads, reach, ambiguous)


def tell_apart(
    tags: Indices, scores: Floats, claims: Flags, places: Floats, alike: Indices, known: Expectation
) -> None:
    """Give candidates with the same colours to robots by where these are expected.

    Robots expected nowhere get what is left from left to right, in the order of the tags.

    Args:
        tags: shape (N,), index of the tag of every candidate, negative for none; is changed.
        scores: shape (N, T), see `Verdict`.
        claims: shape (N,), candidates that are somebody, or would be if nobody were before them.
        places: shape (N, 2), of the candidates [m].
        alike: shape (T,), see `TagSet`.
        known: where the robots are expected.
    """
    claimed = alike[scores.argmax(axis=1)]
    given = np.flatnonzero(tags >= 0)  # not all fit: pairing leaves nobody out
    given = given[scores[given, tags[given]] > _FITTING * scores[given].max(axis=1)]
    claimed[given] = alike[tags[given]]
    for first in np.unique(claimed[claims]):
        rivals = np.flatnonzero(claims & (claimed == first))
        members = np.flatnonzero((alike == first) & (scores[rivals] > 0.0).any(axis=0))
        expected = bool(np.isfinite(known.places[members, 0]).any())
        if len(rivals) > 1 or len(members) > 1:
            if len(members) == 1 and not expected:
                continue  # the better one has it
            strangeness = _strangeness(places[rivals], members, known)
            chosen, columns = scipy.optimize.linear_sum_assignment(strangeness)
            tags[rivals] = NOBODY
            tags[rivals[chosen]] = members[columns]


def _strangeness(places: Floats, members: Indices, known: Expectation) -> Floats:
    """Of every place (R, 2) for every robot, -2 log likelihood, shape (R, members)."""
    away = np.hypot(*(places[:, None] - known.places[members]).transpose(2, 0, 1))
    spreads = known.spreads[members]
    lost = np.isnan(away[0])
    cost: Floats = (away / spreads) ** 2 + 4.0 * np.log(spreads)
    rank = places[:, 0].argsort(kind="stable").argsort(kind="stable").astype(np.float64)
    order = np.cumsum(lost) - 1.0
    by_order = 1e-6 * (rank[:, None] - order) ** 2 + 4.0 * np.log(_UNKNOWN)
    return np.where(lost, by_order, cost)


def with_doubts(
    found: tuple[Detection, ...], tags: TagSet, known: Expectation
) -> tuple[Detection, ...]:
    """Mark the robots that may be another one that wears the same tag.

    Args:
        found: robots of a frame.
        tags: of all robots.
        known: where they were expected.

    Returns:
        The same, some of them marked ambiguous.
    """
    index = {robot_id: n for n, robot_id in enumerate(tags.ids)}
    places = np.full(known.places.shape, np.nan)
    for d in found:
        places[index[d.robot_id]] = d.pose.x, d.pose.y
    alike = np.array(tags.alike)
    own = np.hypot(*(places - known.places).T) <= known.reach + _SLACK  # not where it is unseen
    lost = (known.reach > 0.0) | ~own
    marked = []
    for d in found:
        n = index[d.robot_id]
        others = np.flatnonzero(alike == alike[n])
        others = others[others != n]
        marked.append(replace(d, ambiguous=_is_doubtful(n, others, places[n], own, lost, known)))
    return tuple(marked)


def _is_doubtful(
    n: int, others: Indices, place: Floats, own: Flags, lost: Flags, known: Expectation
) -> bool:
    """Whether robot n, found at a place, may be one of others that look like it."""
    rivals = others[lost[others]]
    if known.ambiguous[n] or not lost[n] or len(others) == 0:
        return bool(known.ambiguous[n])
    if len(rivals) == 0:  # by elimination, if the others are sure
        return bool(np.isinf(known.reach[n]) and known.ambiguous[others].any())
    away = np.hypot(*(place - known.places[rivals]).T)
    return not own[n] or not (away > known.reach[rivals] + _SLACK).all()
