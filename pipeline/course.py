"""The leader's way: arcs and lines as the scenario gives them, or planned among obstacles."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from math import hypot, pi, radians, sqrt

from control.command import RobotId
from control.errors import ControlError
from control.formation import Formation, by_follower
from control.geometry import Pose2D
from control.obstacles import Obstacle
from control.placement import wanted_pose
from control.plan import PathSegment, Plan, PlannedPath
from control.plan_request import FollowerPlace, LeaderLimits, PlanRequest
from control.planner import plan
from control.safety import Arena
from control.unicycle import UnicycleState
from pipeline.config import Scenario
from pipeline.leader_config import LeaderConfig, SegmentConfig, StartConfig

FEEDBACK = 0.9  # of the wheels' speed that a plan may use: the rest is for the laws
ACCURACY = 0.02  # to which a formation follows its plan, alpha of (9) [m]
STEEPEST = 1.5  # of a smooth ramp, over its mean


def make_path(
    leader: LeaderConfig, errand: PlanRequest | None, worn: Iterable[Obstacle]
) -> Plan | None:
    """The leader's plan.

    Args:
        leader: start, and segments or a goal.
        errand: to the goal, None without one.
        worn: obstacles that wear a tag, as far as it is known where they stand at first.

    Returns:
        The plan on the mission's clock; None if a person drives or carries the leader.

    Raises:
        ControlError: if a goal cannot be reached; the message names the key.
    """
    if leader.start is None or leader.driven_by != "plan":
        return None
    if errand is None:
        return path_of(leader.segments or (), leader.start, leader.speed_mps, leader.ramp_s)
    try:
        return plan(replace(errand, obstacles=(*errand.obstacles, *worn)))
    except ControlError as error:
        raise ControlError(f"leader.goal: {error}") from None


def path_of(
    segments: Sequence[SegmentConfig], start: StartConfig, speed: float, ramp: float
) -> PlannedPath:
    """A path of arcs and lines.

    Args:
        segments: of the scenario.
        start: where it begins, and how fast.
        speed: along it [m/s].
        ramp: how long speeding up and slowing down take [s].

    Returns:
        The path, on a clock that is 0 at its start.

    Raises:
        ControlError: if it cannot be driven so.
    """
    pose = Pose2D(start.x_m, start.y_m, radians(start.theta_deg))
    return PlannedPath(pose, tuple(map(_segment, segments)), speed, start.v_mps, ramp)


def worn_obstacles(scenario: Scenario) -> dict[RobotId, float]:
    """Robots that the leader drives round, wherever they are seen.

    Args:
        scenario: checked scenario.

    Returns:
        The radius about the tag of each [m].
    """
    return {o.robot: o.radius_m for o in scenario.obstacles if o.robot is not None}


def wanted_places(
    formation: Formation, lead: Pose2D, t: float, before: Mapping[RobotId, Pose2D], offset: float
) -> dict[RobotId, Pose2D]:
    """Every robot where the formation wants it, followers heading as their leaders do.

    Args:
        formation: who follows whom, in which shape.
        lead: pose of the leader of all [m, m, rad].
        t: time on the mission's clock [s].
        before: places that tell which of two a follower of two leaders takes [m, m, rad].
        offset: of the followers' camera points, d [m].

    Returns:
        Poses by robot, the leader included [m, m, rad].
    """
    places = {formation.root: lead}
    for robot, pairs in by_follower(formation.pairs).items():
        leaders = [places[pair.leader] for pair in pairs]
        near = before.get(robot, leaders[0])
        references = [pair.shape.at(t) for pair in pairs]
        own = Pose2D(near.x, near.y, leaders[0].theta)
        places[robot] = wanted_pose(leaders, references, own, offset)
    return places


def make_errand(
    scenario: Scenario, leader: LeaderConfig, formation: Formation, arena: Arena, side: float
) -> PlanRequest | None:
    """To a standstill at the goal, with room for the shape at first and the shape at last.

    Args:
        scenario: its obstacles, and what robots can.
        leader: start and goal.
        formation: that goes along.
        arena: what no body may leave.
        side: of the square bodies [m].

    Returns:
        What is asked of the planner, obstacles that wear a tag aside; None without a goal.

    Raises:
        ControlError: if no plan can begin so.
    """
    c, start, goal = scenario.control, leader.start, leader.goal
    if start is None or goal is None or leader.driven_by != "plan":
        return None
    d, lead = c.camera_offset_m, Pose2D(0.0, 0.0, 0.0)
    shapes = [wanted_places(formation, lead, t, {}, d) for t in (0.0, scenario.duration_s)]
    poses = [pose for places in shapes for pose in places.values()]
    reach = max(hypot(pose.x, pose.y) for pose in poses) + side / sqrt(2.0)
    wheels = FEEDBACK * c.speed_limit_mps, scenario.radio.track_width_m
    points = {(p.x + d, p.y) if p is not lead else (0.0, 0.0) for p in poses}
    return PlanRequest(
        UnicycleState(start.x_m, start.y_m, radians(start.theta_deg), start.v_mps, 0.0),
        Pose2D(goal.x_m, goal.y_m, radians(goal.heading_deg)),
        clearance=reach + ACCURACY,
        obstacles=_fixed_obstacles(scenario),
        arena=arena,
        limits=LeaderLimits(
            v=leader.speed_mps,
            omega=min(pi, FEEDBACK * c.turn_limit_radps),
            v_rate=STEEPEST * leader.speed_mps / leader.ramp_s,
        ),
        places=tuple(FollowerPlace(x, y, *wheels) for x, y in sorted(points)),
    )


def _fixed_obstacles(scenario: Scenario) -> tuple[Obstacle, ...]:
    """Those at places that the scenario knows, at the mission's start."""
    return tuple(
        Obstacle(o.x_m, o.y_m, o.radius_m, o.vx_mps, o.vy_mps)
        for o in scenario.obstacles
        if o.x_m is not None and o.y_m is not None
    )


def _segment(config: SegmentConfig) -> PathSegment:
    if config.straight_m is not None:
        return PathSegment(config.straight_m)
    radius, turn = config.radius_m or 0.0, radians(config.turn_deg or 0.0)
    return PathSegment(radius * abs(turn), (1.0 if turn > 0 else -1.0) / radius)
