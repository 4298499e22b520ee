"""Robots that do not do what they are told: they should be elsewhere by now, and they stand.

A flat battery, a switch, a radio that takes bytes and delivers none, a hand that holds the robot:
none of these can be heard, all can be seen. Who follows such a robot would be led astray, for
what it is told counts as what it does until the next pictures say otherwise.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from math import hypot

from control.actuation import NOMINAL_GAIN
from control.command import RobotId
from control.geometry import Pose2D, wrap_angle
from control.motion_model import roll
from control.unicycle import UnicycleState
from datasets.cycle import Tick
from pipeline.guard import SafetyRules
from pipeline.lookout import Lookout
from pipeline.memory import Obedience, Track
from vision.scene import Scene

WITHIN = 1.0  # it should have come so far in this time, or nobody could have seen it [s]
MOVED, TURNED = 0.01, 0.2  # who has come so far does not stand [m, rad]
HALF_TRACK = 0.034  # of a Miabot: so far its wheels roll for a turn of 1 rad [m]
FIRST_PAUSE = 1.0  # before it gets another chance, doubling [s]


def watch_obedience(
    lookout: Lookout,
    before: Mapping[RobotId, Obedience],
    tracks: Mapping[RobotId, Track],
    scene: Scene | None,
    tick: Tick,
) -> Mapping[RobotId, Obedience]:
    """Compare what robots were told with what is seen of them.

    Args:
        lookout: safety rules and motion model.
        before: what is remembered of robots so far.
        tracks: corrected by the scene, with the commands sent.
        scene: of the tick's frame, None without one.
        tick: the present inputs.

    Returns:
        What is remembered now.
    """
    if scene is None or lookout.rules.unmoved == 0.0:
        return before
    t, rules = scene.t_capture, lookout.rules
    seen = {
        d.robot_id: _seen(lookout, before.get(d.robot_id), tracks[d.robot_id], d.pose, t)
        for d in scene.detections
        if d.robot_id in tracks
    }
    return {**before, **{robot: _judged(rules, one, tick.t) for robot, one in seen.items()}}


def disobedient(
    rules: SafetyRules, obedience: Mapping[RobotId, Obedience], t: float
) -> Iterator[tuple[RobotId, str]]:
    """Robots that have to stand for a while because they do not obey.

    Args:
        rules: of safety.
        obedience: what is remembered of robots.
        t: now [s].

    Yields:
        Each, and why.
    """
    for robot, one in obedience.items():
        if t < one.until:
            told, again = f"told to move by {rules.unmoved:g} m it stands", one.until - t
            yield robot, f"{told} (battery, switch, radio, held?); tried again in {again:.1f} s"


def _seen(
    lookout: Lookout, one: Obedience | None, track: Track, pose: Pose2D, t: float
) -> Obedience:
    """What is known once a robot was seen at a place."""
    state = track.estimate.state
    here = UnicycleState(pose.x, pose.y, pose.theta, state.v, state.omega)
    if one is None:
        return Obedience(t, t, pose, here, pause=FIRST_PAUSE)
    if t <= one.t_seen:
        return one
    away, turn = hypot(pose.x - one.place.x, pose.y - one.place.y), pose.theta - one.place.theta
    if away >= MOVED or abs(wrap_angle(turn)) >= TURNED:
        return Obedience(t, t, pose, here, one.until, FIRST_PAUSE)
    if t - one.t > WITHIN or t < one.until:
        return Obedience(t, t, pose, here, one.until, one.pause)
    expected = roll(one.expected, one.t_seen, t, track.sent, lookout.motion, NOMINAL_GAIN)
    return replace(one, t_seen=t, expected=expected)


def _judged(rules: SafetyRules, one: Obedience, t: float) -> Obedience:
    """Whoever should be elsewhere by now has to stand for a while; then it has another chance."""
    away = hypot(one.expected.x - one.place.x, one.expected.y - one.place.y)
    turn = abs(one.expected.theta - one.place.theta)
    if t < one.until or max(away, HALF_TRACK * turn) < rules.unmoved:
        return one
    return replace(one, until=t + one.pause, pause=2.0 * one.pause)
