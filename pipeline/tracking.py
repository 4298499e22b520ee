"""From a frame to corrected tracks, and from tracks to the moment a command takes effect."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from math import hypot

import numpy as np
from numpy.typing import NDArray

from control.command import Command, RobotId
from control.estimation import (
    Estimate,
    MotionModel,
    correct,
    initial_estimate,
    innovation,
    predict,
    roll,
)
from control.geometry import Pose2D, wrap_angle
from control.history import SentCommands
from datasets.cycle import Tick
from pipeline.identity import CARRIED, expectations, with_doubts
from pipeline.lookout import Lookout
from pipeline.memory import Sighting, Track
from vision.detector import Detector
from vision.frame import Frame, is_repeated
from vision.light import Light
from vision.locate import Prediction
from vision.scene import Detection, Scene

Locate = Callable[[Detector, Frame, tuple[Prediction, ...], Light], Scene]
Tracks = Mapping[RobotId, Track]

GATE = 40.0
"""Squared Mahalanobis distance beyond which a pose is not believed at once; chance: 1e-8."""

EARLY = 0.01
"""By so much a picture may be dated ahead of the tick: clocks are read one after the other [s]."""

NEAR, NEAR_TURN = 0.03, 0.5
"""A pose as near as this is believed whatever the filter expects: robots get pushed [m, rad]."""


def find_robots(
    detector: Detector, frame: Frame, predictions: tuple[Prediction, ...], light: Light
) -> Scene:
    """Ask the detector.

    Args:
        detector: finds the robots.
        frame: what the camera saw.
        predictions: where robots are expected.
        light: on the robots.

    Returns:
        What was found.
    """
    return detector.locate(frame, predictions, light)


def without_nonsense(tick: Tick, before: Frame | None) -> Tick:
    """Take a picture for none if it tells nothing about now.

    That is the last one again, bit for bit, for then the camera hangs; or one of the future, for
    then its clock is wrong, and who believed it would drive blind until that time has come.

    Args:
        tick: with or without a frame.
        before: the last frame that was looked at, None before the first.

    Returns:
        The tick, without such a frame.
    """
    frame = tick.frame
    if frame is None:
        return tick
    if frame.t_capture > tick.t + EARLY or (before is not None and is_repeated(frame, before)):
        return replace(tick, frame=None)
    return tick


def look(
    lookout: Lookout, tracks: Tracks, light: Light, tick: Tick, locate: Locate
) -> tuple[Scene | None, Tracks]:
    """Find the robots in the tick's frame and correct their tracks at its capture time.

    Args:
        lookout: detector and motion models.
        tracks: of the robots seen before.
        light: as the last scene told it.
        tick: with or without a frame; a frame older than the tracks is looked at but not used.
        locate: the vision.

    Returns:
        What was seen, None without a frame; the tracks, corrected where a robot was seen.
    """
    if tick.frame is None:
        return None, tracks
    t = tick.frame.t_capture
    expected = {
        robot: predict(track.estimate, t, track.sent, _model(lookout, track.sent))
        for robot, track in tracks.items()
        if track.estimate.t <= t
    }
    predictions = expectations(lookout, tracks, expected, t)
    detector = lookout.seeing.detector_for(tick.frame.size_px)
    scene = locate(detector, tick.frame, predictions, light)
    seen = {d.robot_id: d for d in scene.detections}
    corrected = {
        robot: _corrected(lookout, tracks.get(robot), expected.get(robot), detection, t)
        for robot, detection in seen.items()
        if robot in expected or robot not in tracks
    }
    return scene, with_doubts(lookout.tags, tracks, {**tracks, **corrected})


def ahead_of(lookout: Lookout, tracks: Tracks, t_effective: float) -> dict[RobotId, Track]:
    """Roll every track through the commands sent, to the moment the next command takes effect.

    Args:
        lookout: motion models.
        tracks: of all robots seen so far.
        t_effective: that moment [s].

    Returns:
        The tracks with their states at t_effective.
    """
    return {robot: _rolled(lookout, track, t_effective) for robot, track in tracks.items()}


def remember(tracks: Tracks, commands: tuple[Command, ...]) -> dict[RobotId, Track]:
    """Note what is being sent: predictions run through it from now on.

    Args:
        tracks: of all robots.
        commands: of this cycle.

    Returns:
        The tracks with longer histories.
    """
    noted = dict(tracks)
    for command in commands:
        track = noted[command.robot_id]
        sent = track.sent.append(command.t_effective, command.twist)
        noted[command.robot_id] = replace(track, sent=sent)
    return noted


def _model(lookout: Lookout, sent: SentCommands) -> MotionModel:
    """A robot moves by its commands, or, before the first, as it likes."""
    return lookout.motion if sent.times else lookout.free_motion


def _rolled(lookout: Lookout, track: Track, t: float) -> Track:
    if t <= track.t_ahead:
        return track
    model, gain = _model(lookout, track.sent), track.estimate.gain
    state = roll(track.ahead, track.t_ahead, t, track.sent, model, gain)
    return replace(track, ahead=state, t_ahead=t)


def _corrected(
    lookout: Lookout, track: Track | None, expected: Estimate | None, seen: Detection, t: float
) -> Track:
    """The track after a sighting: started, corrected, or kept if the pose cannot be believed."""
    if track is None or expected is None:
        estimate = initial_estimate(seen.pose, seen.covariance, t, lookout.free_motion)
        return Track(estimate, estimate.state, t, ambiguous=seen.ambiguous)
    covariance = seen.covariance + lookout.pose_noise
    if _is_believable(expected, seen.pose, covariance):
        estimate = correct(expected, seen.pose, covariance)
    elif _is_long_lost(lookout, track, t) or _is_again(track.elsewhere, seen.pose, t):
        estimate = initial_estimate(seen.pose, seen.covariance, t, lookout.free_motion)
    else:
        return replace(track, elsewhere=Sighting(t, seen.pose))
    return Track(estimate, estimate.state, t, track.sent, seen.ambiguous)


def _is_long_lost(lookout: Lookout, track: Track, t: float) -> bool:
    return t - track.estimate.t > lookout.rules.stop_after


def _is_again(before: Sighting | None, pose: Pose2D, t: float) -> bool:
    """Whether a robot is seen a second time where it was not expected: it was carried there."""
    if before is None:
        return False
    away, turn = hypot(pose.x - before.pose.x, pose.y - before.pose.y), pose.theta
    near = away <= NEAR + CARRIED * (t - before.t)
    return near and abs(wrap_angle(turn - before.pose.theta)) <= NEAR_TURN


def _is_believable(expected: Estimate, pose: Pose2D, covariance: NDArray[np.float64]) -> bool:
    """Whether a pose can be the robot's: near the expected one, or no surprise to the filter."""
    state = expected.state
    away, turn = hypot(pose.x - state.x, pose.y - state.y), wrap_angle(pose.theta - state.theta)
    if away <= NEAR and abs(turn) <= NEAR_TURN:
        return True
    return innovation(expected, pose, covariance).squared_distance <= GATE
