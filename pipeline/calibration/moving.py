"""Calibration by moving: who is on which radio, then how each robot drives."""

import gc
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import degrees

from control.command import RobotId
from control.drive_fit import DriveFit, fit_drive
from control.errors import ControlError
from pipeline.calibration.ground import STANDING, Ground, survey
from pipeline.calibration.pairing import Pairing, mistaken, paired, tag_of
from pipeline.calibration.patrol import Drive, drive
from pipeline.calibration.pattern import DRIVING, TURNING, Pattern
from pipeline.calibration.watch import TICK, Bench, Circle, Sight, look_once
from pipeline.errors import CameraError, ConfigError

PATIENCE = 5.0  # until all robots must have been seen [s]
SETTLE = 0.3  # of looking before every drive: old pictures are of no use [s]
LOOKS = 5  # a floor is not clear if none of so many looks shows it clear
_UNSEEN = "not seen, or it cannot be told from another; nothing was moved; see echelon locate"
ODD, ODD_TURN = 0.004, 0.05  # left unexplained: it did not drive as robots do [m, rad]


@dataclass(frozen=True, slots=True)
class Moved:
    """What moving the robots has told.

    Attributes:
        pairing: tag by radio.
        fits: how each robot drives, by its tag.
        age: of a picture on its arrival, by its own time [s].
    """

    pairing: Pairing
    fits: Mapping[RobotId, DriveFit]
    age: float


def calibrate_by_moving(bench: Bench, ground: Ground, radios: Sequence[RobotId]) -> Moved:
    """Turn every radio's robot, then let every robot drive its pattern; one moves at a time.

    Whatever happens, stop is sent to all robots, three times, before this returns.

    Args:
        bench: camera, radio, lookout.
        ground: what the robots stand on.
        radios: by the ids that the scenario gives them.

    Returns:
        What was found.

    Raises:
        ConfigError: if a robot is not seen or not clear of others, or does not drive as robots do.
        SafetyStop: if a robot is lost or leaves its circle, or the camera is silent.
        RadioError: if a link is down, or radios and tags cannot be paired.
        CameraError: if the camera fails.
        Interrupted: after Ctrl-C.
    """
    gc.freeze()  # to look for garbage among what was set up takes 0.15 s: a robot is blind so long
    try:
        sight, pairing = _pair(bench, look_for_all(bench, radios), ground, radios)
        sight, drives = _drive_all(bench, sight, ground, pairing)
    finally:
        bench.rig.sink.stop(bench.rig.clock.now())
        gc.unfreeze()
    return Moved(pairing, {tag: _fit(tag, drives[tag]) for tag in pairing.values()}, sight.age)


def look_for_all(bench: Bench, robots: Sequence[RobotId]) -> Sight:
    """Look until every robot has just been seen, and for a moment at least.

    Args:
        bench: camera and lookout.
        robots: that must be seen.

    Returns:
        What is known then.

    Raises:
        ConfigError: if one is not seen in time.
        CameraError: if the camera fails.
        Interrupted: after Ctrl-C.
    """
    now = bench.rig.clock.now()
    return _look(bench, Sight(now, now), robots)


def _look(bench: Bench, sight: Sight, robots: Sequence[RobotId]) -> Sight:
    """Go on looking."""
    clock = bench.rig.clock
    begin = clock.now()
    while clock.now() - begin < PATIENCE:
        sight = look_once(bench, sight)
        missing = _missing(bench, sight, robots)
        if sight.t - begin >= SETTLE and not missing:
            return sight
        clock.wait_until(sight.t + TICK)
    if sight.t_frame <= begin:
        raise CameraError(f"camera: no picture for {PATIENCE:g} s; nothing was moved")
    raise ConfigError(f"robot {', '.join(map(str, missing))} is {_UNSEEN}")


def _missing(bench: Bench, sight: Sight, robots: Sequence[RobotId]) -> list[RobotId]:
    """Robots that have not just been seen, or only in doubt."""
    fresh = sight.t - bench.lookout.rules.slow_after
    return [
        robot
        for robot in robots
        if (track := sight.tracks.get(robot)) is None or track.estimate.t < fresh or track.ambiguous
    ]


def _pair(
    bench: Bench, sight: Sight, ground: Ground, radios: Sequence[RobotId]
) -> tuple[Sight, Pairing]:
    """Nobody moves before everybody has room for all that is to come."""
    sight, _ = _clear(bench, sight, ground, DRIVING, radios, radios)
    pairing: Pairing = {}
    for radio in radios:
        bench.say(f"radio {radio}: its robot turns left and back")
        sight, drive_ = _one(bench, sight, ground, TURNING, radio, radios)
        pairing = paired(pairing, radio, tag_of(radio, drive_))
    for line in mistaken(pairing) or ("every radio moves its own robot's tag",):
        bench.say(line)
    return sight, pairing


def _drive_all(
    bench: Bench, sight: Sight, ground: Ground, pairing: Pairing
) -> tuple[Sight, Mapping[RobotId, Drive]]:
    """One robot after the other."""
    drives: dict[RobotId, Drive] = {}
    for count, (radio, tag) in enumerate(pairing.items(), 1):
        bench.say(
            f"robot {tag} ({count} of {len(pairing)}): drives for {DRIVING.duration:.1f} s within "
            f"{DRIVING.reach():.2f} m"
        )
        robots = tuple(pairing.values())
        sight, drives[tag] = _one(bench, sight, ground, DRIVING, radio, robots, tag)
    return sight, drives


def _one(
    bench: Bench,
    sight: Sight,
    ground: Ground,
    pattern: Pattern,
    radio: RobotId,
    robots: Sequence[RobotId],
    tag: RobotId | None = None,
) -> tuple[Sight, Drive]:
    """Look afresh, see that the floor is clear, drive; who is not `tag` must keep its place."""
    movers = robots if tag is None else (tag,)
    sight, circles = _clear(bench, sight, ground, pattern, robots, movers)
    standing = {
        robot: Circle(t.estimate.state.x, t.estimate.state.y, STANDING)
        for robot, t in sight.tracks.items()
        if robot in robots
    }
    return drive(bench, sight, radio, pattern, {**standing, **circles})


def _clear(
    bench: Bench,
    sight: Sight,
    ground: Ground,
    pattern: Pattern,
    robots: Sequence[RobotId],
    movers: Sequence[RobotId],
) -> tuple[Sight, Mapping[RobotId, Circle]]:
    """Circles of those that may move, all of them clear; noise may look like a thing, but once."""
    refusals: list[str] = []
    for _ in range(LOOKS):
        sight = _look(bench, sight, robots)
        surveyed = survey(bench, sight, ground, pattern)
        refusals = [line for robot in movers for line in surveyed[robot][1]]
        if not refusals:
            return sight, {robot: surveyed[robot][0] for robot in movers}
    raise ConfigError(f"not clear: {'; '.join(refusals)}")


def _fit(tag: RobotId, drive_: Drive) -> DriveFit:
    """The fit of a robot that drove as robots do."""
    try:
        fit = fit_drive(drive_.sent, drive_.seen[tag])
    except ControlError as error:
        raise ConfigError(f"robot {tag}: {error}") from None
    if fit.position_rms > ODD or fit.heading_rms > ODD_TURN:
        raise ConfigError(
            f"robot {tag}: {1e3 * fit.position_rms:.1f} mm and {degrees(fit.heading_rms):.1f} deg "
            "rms of its way are not explained by gains, lag and delay: did its wheels slip, was "
            "it pushed, did commands get lost, or was this machine too busy? Drive it again"
        )
    return fit
