"""One robot is driven while all are watched: every command is preceded by a look and a verdict."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import inf

from control.command import Command, RobotId
from control.drive_fit import SeenPose
from control.history import SentCommands
from control.unicycle import Twist
from pipeline.calibration.pattern import Pattern
from pipeline.calibration.watch import TICK, Bench, Circle, Sight, danger, look_once
from pipeline.errors import RadioError, SafetyStop
from pipeline.lookout import Lookout

REFRESH = 0.05
"""A command is repeated so often: robots have timeouts of their own [s]."""

_ROOM = 0.02  # a repetition never delays a change that is due as soon as this [s]
_VALID = 0.1  # commands are not sent when older [s]


@dataclass(frozen=True, slots=True)
class Drive:
    """What was sent to one robot, and where all were seen meanwhile.

    Attributes:
        sent: changes of the command by the time of their sending.
        seen: poses by robot, ascending in time.
    """

    sent: SentCommands
    seen: Mapping[RobotId, tuple[SeenPose, ...]]


def drive(
    bench: Bench, sight: Sight, radio: RobotId, pattern: Pattern, circles: Mapping[RobotId, Circle]
) -> tuple[Sight, Drive]:
    """Send a pattern over one radio while all robots are watched; then send stop.

    Args:
        bench: camera, radio, clock.
        sight: so far.
        radio: whose robot is to move.
        pattern: what it is told.
        circles: where each robot must stay.

    Returns:
        What is known now, and what was sent and seen.

    Raises:
        SafetyStop: if a robot is lost or leaves its circle, or the camera is silent.
        RadioError: if the link is down.
        CameraError: if the camera fails.
        Interrupted: after Ctrl-C.
    """
    clock = bench.rig.clock
    begin, told = clock.now(), Told()
    sight = replace(sight, t_frame=begin)
    seen: dict[RobotId, list[SeenPose]] = {robot: [] for robot in circles}
    while clock.now() - begin < pattern.duration:
        sight = look_once(bench, sight)
        why = danger(bench.lookout.rules, sight, circles)
        if why:
            raise SafetyStop(f"stopped while radio {radio} was driving: {why}")
        _note(seen, sight, bench.lookout)
        told = _tell(bench, radio, pattern, begin, told)
        clock.wait_until(sight.t + TICK)
    bench.rig.sink.stop(clock.now())
    sent = SentCommands(told.times, told.twists)
    return sight, Drive(sent, {robot: tuple(poses) for robot, poses in seen.items()})


@dataclass(frozen=True, slots=True)
class Told:
    """What a radio has been sent.

    Attributes:
        t_last: when it was last sent anything [s].
        times: of all changes [s].
        twists: from then on [m/s, rad/s].
    """

    t_last: float = -inf
    times: tuple[float, ...] = ()
    twists: tuple[Twist, ...] = ()


def _tell(bench: Bench, radio: RobotId, pattern: Pattern, begin: float, told: Told) -> Told:
    """Send the pattern's command if it is new or was sent long ago."""
    now = bench.rig.clock.now()
    twist, left = pattern.at(now - begin)
    changed = twist != (told.twists[-1] if told.twists else None)
    slowest = bench.rig.sink.min_period
    soon = now - told.t_last < max(REFRESH, 2.0 * slowest) or left < max(_ROOM, slowest)
    if soon and not changed:
        return told
    lost = bench.rig.sink.send((Command(radio, twist, now, now + _VALID),), now)
    if radio in lost:
        raise RadioError(f"radio {radio}: its link is down")
    if not changed:
        return replace(told, t_last=now)
    return Told(now, (*told.times, now), (*told.twists, twist))


def _note(seen: dict[RobotId, list[SeenPose]], sight: Sight, lookout: Lookout) -> None:
    """Keep the poses that a new picture shows, but for those that cannot be believed."""
    if sight.scene is None:
        return
    for d in sight.scene.detections:
        if d.robot_id in seen and sight.tracks[d.robot_id].estimate.t == sight.scene.t_capture:
            pose = SeenPose(sight.scene.t_capture, d.pose, d.covariance + lookout.pose_noise)
            seen[d.robot_id].append(pose)
