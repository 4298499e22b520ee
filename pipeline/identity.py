"""Robots that wear the same tag: where each is expected, and for whom doubts remain."""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from control.command import RobotId
from control.estimation import Estimate
from pipeline.guard import SafetyRules
from pipeline.lookout import Lookout
from pipeline.memory import Track
from vision.locate import Prediction
from vision.tags import TagSet

Tracks = Mapping[RobotId, Track]

CARRIED = 2.0
"""Speed of a robot in somebody's hand, at most [m/s]."""

START_REACH = 0.15
"""A robot stands no farther from the start that the scenario gives it [m]."""

_START_COVARIANCE = np.diag((0.03**2, 0.03**2, 0.2**2))


def expectations(
    lookout: Lookout, tracks: Tracks, expected: Mapping[RobotId, Estimate], t: float
) -> tuple[Prediction, ...]:
    """Say where robots are looked for first.

    Args:
        lookout: tags, safety rules and starts.
        tracks: of the robots seen before.
        expected: their estimates at the capture time.
        t: capture time of the frame [s].

    Returns:
        Predictions of the robots seen before, and the starts of those never seen that wear the
        same tag as another.
    """
    predictions = tuple(
        Prediction(
            robot, e.state.pose, e.covariance[:3, :3],
            _reach(lookout, t - tracks[robot].estimate.t), tracks[robot].ambiguous,
        )
        for robot, e in expected.items()
    )  # fmt: skip
    if not lookout.tags.look_alikes:
        return predictions
    starts = tuple(
        Prediction(
            robot, start, _START_COVARIANCE, START_REACH, _is_doubted(lookout, tracks, robot)
        )
        for robot, start in lookout.starts.items()
        if robot not in tracks and lookout.tags.twins_of(robot)
    )
    return predictions + starts


def with_doubts(tags: TagSet, before: Tracks, tracks: Tracks) -> Tracks:
    """Doubt those out of sight as well, when one of several is taken up again in doubt.

    Args:
        tags: of all robots.
        before: tracks before the frame.
        tracks: after it.

    Returns:
        The tracks.
    """
    if not tags.look_alikes:
        return tracks
    new = ambiguous_of(tracks) - ambiguous_of(before)
    unseen = [
        robot for robot in tracks if robot in before and _is_unseen(before[robot], tracks[robot])
    ]
    doubted = [robot for robot in unseen if new.intersection(tags.twins_of(robot))]
    return {**tracks, **{robot: replace(tracks[robot], ambiguous=True) for robot in doubted}}


def ambiguous_of(tracks: Tracks) -> frozenset[RobotId]:
    """Robots that may be another one.

    Args:
        tracks: of all robots.

    Returns:
        Their ids.
    """
    return frozenset(robot for robot, track in tracks.items() if track.ambiguous)


def doubted(rules: SafetyRules, tracks: Tracks) -> Iterator[tuple[RobotId, str]]:
    """Robots that have to stand because they may be another one.

    Args:
        rules: of safety; they may let them drive.
        tracks: of all robots.

    Yields:
        Each, and why.
    """
    if not rules.drive_ambiguous:
        for robot in ambiguous_of(tracks):
            yield robot, "it may be another robot that wears the same tag"


def doubts_told(tags: TagSet, before: Tracks, tracks: Tracks, t: float) -> tuple[str, ...]:
    """Say for whom doubts have come up.

    Args:
        tags: of all robots.
        before: tracks before the tick.
        tracks: after it.
        t: the moment [s].

    Returns:
        One note per robot.
    """
    if not tags.look_alikes:
        return ()
    new = sorted(ambiguous_of(tracks) - ambiguous_of(before), key=str)
    return tuple(f"{t:.2f} s: robot {robot} may be {_others(tags, robot)}" for robot in new)


def _others(tags: TagSet, robot: RobotId) -> str:
    names = " or ".join(str(other) for other in tags.twins_of(robot))
    return f"{names}, which wears the same tag: put each at its start and start again"


def _is_unseen(before: Track, after: Track) -> bool:
    return after.estimate is before.estimate


def _reach(lookout: Lookout, unseen: float) -> float:
    """How far a robot may have been carried; nobody does it while its prediction is trusted."""
    return 0.0 if unseen < lookout.rules.slow_after else CARRIED * unseen


def _is_doubted(lookout: Lookout, tracks: Tracks, robot: RobotId) -> bool:
    """Whether a robot never seen may be one of those that are seen, in doubt."""
    return bool(ambiguous_of(tracks).intersection(lookout.tags.twins_of(robot)))
