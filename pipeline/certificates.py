"""Certificates of a scenario's followers: its plan, starts and gains, put into `control.gains`."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import radians

import numpy as np
from numpy.typing import NDArray

from control.command import RobotId
from control.course import Motion, PairCourse, ideal_follower, jumps, pair_course, planned_motion
from control.errors import ControlError
from control.formation import Pair, by_follower
from control.gains import Certificate, certify
from control.geometry import Pose2D, wrap_angle
from control.relative import RelativeState, Vector2, relative_rates, relative_state
from control.unicycle import Twist, UnicycleState, advance_pose
from pipeline.config import Scenario
from pipeline.setup import Setup

STEP, LONGEST = 0.01, 60.0  # between samples of a mission, and how much of it is looked at [s]
NO_PLAN = "no certificate: a person moves the leader, so nobody knows its way beforehand"


@dataclass(frozen=True, slots=True)
class Certified:
    """A pair with its certificate.

    Attributes:
        pair: who follows whom.
        course: what the pair goes through.
        certificate: None where there is none.
        trouble: why there is none.
    """

    pair: Pair
    course: PairCourse | None = None
    certificate: Certificate | None = None
    trouble: str = ""


@dataclass(frozen=True, slots=True)
class Certificates:
    """All pairs of a formation.

    Attributes:
        pairs: one for every follower, leaders first.
        jumps: (3, J) of the plan's velocities: when, v, omega [s, m/s, rad/s].
    """

    pairs: tuple[Certified, ...]
    jumps: NDArray[np.float64]


def make_certificates(setup: Setup, starts: Mapping[RobotId, UnicycleState]) -> Certificates:
    """Certificates of all followers on the leader's plan.

    Args:
        setup: formation, plan and gains.
        starts: states when the mission starts; a pair of which one is not known starts in its
            shape.

    Returns:
        The certificates; a follower is taken to slide ideally where others follow it.
    """
    if setup.path is None:
        followed = by_follower(setup.formation.pairs).values()
        none = tuple(Certified(pairs[0], trouble=NO_PLAN) for pairs in followed)
        return Certificates(none, np.empty((3, 0)))
    times = np.arange(0.0, min(setup.duration, LONGEST) + 1.5 * STEP, STEP)
    planned = planned_motion(setup.path.at(t) for t in times.tolist())
    motions: dict[RobotId, Motion] = {setup.formation.root: planned}
    made = []
    for robot, pairs in by_follower(setup.formation.pairs).items():
        if len(pairs) > 1 or pairs[0].leader not in motions:
            why = "it follows two robots" if len(pairs) > 1 else "there is none for its leader"
            made.append(Certified(pairs[0], trouble=f"no certificate: {why}"))
            continue
        certified, motion = _certified(setup, pairs[0], times, motions[pairs[0].leader], starts)
        made.append(certified)
        if motion is not None:
            motions[robot] = motion
    return Certificates(tuple(made), jumps(planned, times))


def start_states(scenario: Scenario, setup: Setup) -> dict[RobotId, UnicycleState]:
    """Where robots will be, and how they will move, when the mission starts.

    Args:
        scenario: says where they stand at first.
        setup: made from it.

    Returns:
        States of the robots whose start is given; they drive on while they are watched.
    """
    states = {}
    for robot in scenario.robots:
        if robot.start is not None:
            s, twist = robot.start, Twist(robot.start.v_mps, robot.start.omega_radps)
            pose = Pose2D(s.x_m, s.y_m, radians(s.theta_deg))
            pose = advance_pose(pose, twist, setup.watch_time)
            states[robot.id] = UnicycleState(pose.x, pose.y, pose.theta, twist.v, twist.omega)
    return states


def _certified(
    setup: Setup,
    pair: Pair,
    times: NDArray[np.float64],
    leader: Motion,
    states: Mapping[RobotId, UnicycleState],
) -> tuple[Certified, Motion | None]:
    """A pair's certificate, and how its follower moves."""
    gains, d = setup.gains[pair.follower], setup.follower.camera_offset
    wanted = [pair.shape.at(t) for t in times.tolist()]
    heading, start = 0.0, ((0.0, 0.0), (0.0, 0.0))
    if pair.leader in states and pair.follower in states:
        heading, start = _start(pair, states[pair.leader], states[pair.follower], d)
    course = pair_course(times, leader, wanted, start, gains)
    try:
        ideal = ideal_follower(course, heading, d)
        certificate = certify(course, ideal, gains, d, setup.leader_commands_known)
    except ControlError as error:
        return Certified(pair, course, trouble=str(error)), None
    return Certified(pair, course, certificate), ideal.motion


def _start(
    pair: Pair, leader: UnicycleState, follower: UnicycleState, camera_offset: float
) -> tuple[float, tuple[Vector2, Vector2]]:
    """theta_ik, and e and e' of (11), when the mission starts."""
    wanted = pair.shape.at(0.0)
    relative: RelativeState = relative_state(leader.pose, follower.pose, camera_offset)
    rates = relative_rates(relative, leader.twist, follower.twist, camera_offset)
    turn = wrap_angle(wanted.bearing - relative.bearing)
    return relative.heading, (
        (wanted.distance - relative.distance, turn),
        (wanted.distance_rate - rates.distance, wanted.bearing_rate - rates.bearing),
    )
