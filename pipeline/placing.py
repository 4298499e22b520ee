"""Who takes which place, decided by where the robots are seen before a run."""

from collections.abc import Callable, Mapping, Sequence

from control.command import RobotId
from control.geometry import Pose2D
from pipeline.config import Scenario
from pipeline.errors import ConfigError
from pipeline.live import Rig
from pipeline.looking import look
from pipeline.ports import EndOfStream
from pipeline.seeing import Seeing
from pipeline.shaping import assign_followers, leaves_open

PAUSE = 0.01  # between two looks for a new frame [s]
TELL = 2.0  # between two words about who is missing [s]


def place_followers(
    scenario: Scenario,
    seeing: Seeing,
    rig: Rig,
    say: Callable[[str], None],
    interrupted: Callable[[], bool],
) -> Scenario:
    """Look until every robot has been seen, then give the places out.

    Args:
        scenario: checked scenario.
        seeing: finds its robots.
        rig: the camera and its clock; nothing is sent to the robots.
        say: tells people what is waited for, and what was decided.
        interrupted: asked once a look.

    Returns:
        The scenario with its followers; as it was if it says them, or on an interruption.

    Raises:
        ConfigError: if the frames end before, or places and followers differ in number.
        CameraError: if the camera fails.
    """
    config = scenario.formation
    if config is None or not leaves_open(config):
        return scenario
    say(f"looking for {len(scenario.robots)} robots: the nearest places will be theirs")
    poses = _watched(scenario, seeing, rig, say, interrupted)
    if poses is None:
        return scenario
    followers = assign_followers(scenario, config, poses)
    say(f"followers in the order of their places: {_names(followers)}")
    formation = config.model_copy(update={"followers": followers})
    return scenario.model_copy(update={"formation": formation})


def _watched(
    scenario: Scenario,
    seeing: Seeing,
    rig: Rig,
    say: Callable[[str], None],
    interrupted: Callable[[], bool],
) -> Mapping[RobotId, Pose2D] | None:
    """Poses of all robots in one frame; None on an interruption. Tells who is missing, at times."""
    missing = [robot.id for robot in scenario.robots]
    told = rig.clock.now()
    while not interrupted():
        now = rig.clock.now()
        try:
            frame = rig.source.latest(now)
        except EndOfStream:
            raise ConfigError(
                f"the frames ended before every robot was seen: no robot {_names(missing)}; "
                "say formation.followers, or show all robots"
            ) from None
        if frame is not None:
            height, width = frame.image.shape[:2]
            scene = look(seeing.detector_for((width, height)), frame)
            poses = {d.robot_id: d.pose for d in scene.detections}
            missing = [robot.id for robot in scenario.robots if robot.id not in poses]
            if not missing:
                return poses
        if now - told >= TELL:
            say(f"still looking for robot {_names(missing)}; Ctrl-C ends it")
            told = now
        rig.clock.wait_until(now + PAUSE)
    return None


def _names(robots: Sequence[RobotId]) -> str:
    return ", ".join(map(str, robots))
