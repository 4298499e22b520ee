"""One robot is driven, all are watched: every command is preceded by a look and a verdict."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from math import hypot, inf
from statistics import median

from control.command import Command, RobotId
from control.drive_fit import SeenPose
from control.history import SentCommands
from control.unicycle import Twist
from datasets.cycle import Tick
from pipeline.calibration.pattern import Pattern
from pipeline.errors import CameraError, RadioError, SafetyStop
from pipeline.guard import SafetyRules
from pipeline.live import Rig
from pipeline.lookout import Lookout
from pipeline.memory import Track
from pipeline.ports import EndOfStream
from pipeline.tracking import find_robots, look, without_repeats
from vision.frame import Frame
from vision.light import PALETTE_LIGHT, Light
from vision.scene import Scene

TICK = 0.005
"""Between two looks for a new picture [s]."""

REFRESH = 0.05  # a command is repeated so often: robots have timeouts of their own [s]
_ROOM = 0.02  # a repetition never delays a change that is due as soon as this [s]
_AGES = 300  # pictures whose ages are kept
_VALID = 0.1  # commands are not sent when older [s]


class Interrupted(Exception):
    """Somebody has pressed Ctrl-C."""


@dataclass(frozen=True, slots=True)
class Bench:
    """What a calibration works with.

    Attributes:
        rig: camera, radio and clock.
        lookout: finds the robots and follows them.
        interrupted: asked once a tick.
        say: tells people how far it has come.
    """

    rig: Rig
    lookout: Lookout
    interrupted: Callable[[], bool]
    say: Callable[[str], None]


@dataclass(frozen=True, slots=True)
class Sight:
    """What is known from looking.

    Attributes:
        t: moment of the last look [s].
        t_frame: when the last picture arrived [s].
        tracks: robots seen so far.
        light: on the robots.
        frame: the last picture, None before the first.
        scene: what the last look has shown, None without a new picture.
        ages: of the latest pictures when they were found, by their own times [s].
    """

    t: float
    t_frame: float
    tracks: Mapping[RobotId, Track] = field(default_factory=dict)
    light: Light = PALETTE_LIGHT
    frame: Frame | None = None
    scene: Scene | None = None
    ages: tuple[float, ...] = ()

    @property
    def age(self) -> float:
        """Of a picture on its arrival: it was found half a tick later in the middle [s]."""
        return median(self.ages) - 0.5 * TICK


@dataclass(frozen=True, slots=True)
class Circle:
    """Where the tag of a robot must stay.

    Attributes:
        x: of its middle [m].
        y: of its middle [m].
        radius: of the circle [m].
    """

    x: float
    y: float
    radius: float


@dataclass(frozen=True, slots=True)
class Drive:
    """What was sent to one robot, and where all were seen meanwhile.

    Attributes:
        sent: changes of the command by the time of their sending.
        seen: poses by robot, ascending in time.
    """

    sent: SentCommands
    seen: Mapping[RobotId, tuple[SeenPose, ...]]


def look_once(bench: Bench, sight: Sight) -> Sight:
    """Take the newest picture, if there is one, and find the robots in it.

    Args:
        bench: camera, clock, lookout.
        sight: of the look before.

    Returns:
        What is known now.

    Raises:
        CameraError: if the camera fails, or its pictures end.
        Interrupted: after Ctrl-C.
    """
    if bench.interrupted():
        raise Interrupted
    now = bench.rig.clock.now()
    try:
        tick = Tick(now, bench.rig.source.latest(now))
    except EndOfStream as end:
        raise CameraError(f"camera: {end}") from None
    tick = without_repeats(tick, sight.frame)
    scene, tracks = look(bench.lookout, sight.tracks, sight.light, tick, find_robots)
    if scene is None or tick.frame is None:
        return replace(sight, t=now, scene=None)
    ages = (*sight.ages[-_AGES:], now - tick.frame.t_capture)
    return Sight(now, now, tracks, scene.light, tick.frame, scene, ages)


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


def danger(rules: SafetyRules, sight: Sight, circles: Mapping[RobotId, Circle]) -> str | None:
    """Say why robots must stop.

    Args:
        rules: how long robots and pictures may be missing.
        sight: as of now.
        circles: where each robot must stay.

    Returns:
        The reason, None if there is none.
    """
    if sight.t - sight.t_frame > rules.camera_silent:
        return f"no picture for {sight.t - sight.t_frame:.2f} s"
    for robot, circle in circles.items():
        track = sight.tracks.get(robot)
        unseen = inf if track is None else sight.t - track.estimate.t
        if track is None or unseen > rules.stop_after:
            return f"robot {robot} was last seen {unseen:.2f} s ago"
        if track.ambiguous:
            return f"robot {robot} may be another one that wears the same tag"
        place = track.estimate.state
        away = hypot(place.x - circle.x, place.y - circle.y)
        if away > circle.radius:
            return (
                f"robot {robot} is {away:.3f} m from where it began, {circle.radius:.3f} m are "
                "allowed (pushed, or much faster than radio.speed_scale_per_mps says?)"
            )
    return None


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
    if not changed and (now - told.t_last < REFRESH or left < _ROOM):
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
