"""All robots are watched: what is known from looking, and whether they must stop."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from math import hypot, inf
from statistics import median

from control.command import RobotId
from datasets.cycle import Tick
from pipeline.errors import CameraError
from pipeline.guard import SafetyRules
from pipeline.live import Rig
from pipeline.lookout import Lookout
from pipeline.memory import Track
from pipeline.ports import EndOfStream
from pipeline.tracking import find_robots, look, without_nonsense
from vision.frame import Frame
from vision.light import PALETTE_LIGHT, Light
from vision.scene import Scene

TICK = 0.005
"""Between two looks for a new picture [s]."""

_AGES = 300  # pictures whose ages are kept


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
    tick = without_nonsense(tick, sight.frame)
    scene, tracks = look(bench.lookout, sight.tracks, sight.light, tick, find_robots)
    if scene is None or tick.frame is None:
        return replace(sight, t=now, scene=None)
    ages = (*sight.ages[-_AGES:], now - tick.frame.t_capture)
    return Sight(now, now, tracks, scene.light, tick.frame, scene, ages)


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
