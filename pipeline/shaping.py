"""From the section [formation] to a formation: pairs as they are, or places given to robots."""

from collections.abc import Mapping, Sequence
from math import radians

from control.assignment import assigned, positions_about, rearranged
from control.cascade import ShapeChange, chain, pair_shapes, star
from control.command import RobotId
from control.formation import Formation, Pair, Shape
from control.geometry import Pose2D
from control.profile import TanhStep
from control.shapes import Places, given, named_shape
from pipeline.config import Scenario
from pipeline.errors import ConfigError
from pipeline.formation_config import FormationConfig, PairConfig, ShapeConfig


def make_formation(scenario: Scenario, config: FormationConfig) -> Formation:
    """The formation of a scenario.

    Args:
        scenario: checked scenario.
        config: its section [formation].

    Returns:
        Who follows whom, in which shape.

    Raises:
        ConfigError: if places are open and a robot has no start.
        ControlError: if pairs or places are inconsistent.
    """
    if config.pairs is not None:
        return Formation(tuple(_pair(pair) for pair in config.pairs))
    followers = config.followers
    if followers is None:
        followers = assign_followers(scenario, config, starts_of(scenario))
    return _shaped(config, followers, scenario.control.camera_offset_m)


def leaves_open(config: FormationConfig | None) -> bool:
    """Whether nobody has said which robot takes which place.

    Args:
        config: the section [formation], None if there is none.

    Returns:
        True for a shape without followers.
    """
    return config is not None and config.pairs is None and config.followers is None


def assign_followers(
    scenario: Scenario, config: FormationConfig, poses: Mapping[RobotId, Pose2D]
) -> tuple[RobotId, ...]:
    """Give places to robots: the least sum of squared ways, on which no two robots meet.

    Args:
        scenario: its robots but for the leader are the followers.
        config: a shape with a leader.
        poses: where the robots stand [m, m, rad].

    Returns:
        Followers in the order of the places.

    Raises:
        ConfigError: if nobody knows where a robot stands.
        ControlError: if places and followers differ in number.
    """
    unknown = [str(robot.id) for robot in scenario.robots if robot.id not in poses]
    if unknown:
        raise ConfigError(
            f"scenario {scenario.name}: who takes which place is open, and where robot "
            f"{', '.join(unknown)} stands is unknown: give formation.followers, or its start"
        )
    leader = _root(config)
    followers = {robot: pose for robot, pose in poses.items() if robot != leader}
    positions = positions_about(poses[leader], followers, scenario.control.camera_offset_m)
    return assigned(positions, _places(config, len(followers)))


def starts_of(scenario: Scenario) -> Mapping[RobotId, Pose2D]:
    """Where a scenario says that robots stand at first.

    Args:
        scenario: checked scenario.

    Returns:
        Poses of the robots that have a start [m, m, rad].
    """
    return {
        robot.id: Pose2D(robot.start.x_m, robot.start.y_m, radians(robot.start.theta_deg))
        for robot in scenario.robots
        if robot.start is not None
    }


def _shaped(config: FormationConfig, followers: Sequence[RobotId], d: float) -> Formation:
    """All pairs of a shape and its changes."""
    count = len(followers)
    places = [_places(shape, count) for shape in (config, *config.changes)]
    if config.followers is None:  # who goes where is open at every change
        for k in range(1, len(places)):
            places[k] = rearranged(places[k - 1], places[k])
    parents = star(places[0]) if config.follow == "leader" else chain(places[0])
    changes = [
        ShapeChange(change.at_s, then, change.duration_s)
        for change, then in zip(config.changes, places[1:], strict=True)
    ]
    shapes = pair_shapes(places[0], changes, parents, d)
    root = _root(config)
    leaders = [root if parent is None else followers[parent] for parent in parents]
    return Formation(tuple(map(Pair, leaders, followers, shapes)))


def _root(config: FormationConfig) -> RobotId:
    if config.leader is None:
        raise ConfigError("formation.leader: a shape needs its leader")
    return config.leader


def _places(config: ShapeConfig, count: int) -> Places:
    if config.places_m is not None:
        return given(config.places_m)
    spacing = config.spacing_m or 0.0
    if config.shape == "wedge":
        return named_shape("wedge")(count, spacing, radians(config.half_angle_deg))
    if config.shape == "circle":
        return named_shape("circle")(count, spacing, config.leader_at)
    return named_shape(config.shape or "")(count, spacing)


def _pair(config: PairConfig) -> Pair:
    d, bearing = config.distance_m, config.bearing_deg
    distance = (
        TanhStep.constant(d)
        if isinstance(d, float | int)
        else TanhStep(d.before_m, d.after_m, d.at_s, d.rate_per_s)
    )
    turned = None if bearing is None else TanhStep.constant(radians(bearing))
    return Pair(config.leader, config.follower, Shape(distance, turned))
