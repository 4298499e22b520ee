"""The host's laws in one run: the leader's, then every follower's; the functions of control/."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from control.channel import ChannelMemory
from control.compilable import compilable
from control.leader import LeaderMemory, begin_leader, lead
from control.output import (
    FollowerOutput,
    LeaderMotion,
    WantedOutput,
    pair_output,
    two_leaders_output,
)
from control.plan import PlannedMotion
from control.relative import RelativeState, Vector2, relative_state
from control.sliding import FollowerMemory, FollowerSample, SlidingGains, begin, follow
from control.unicycle import Twist, UnicycleState
from datasets.simulation.filters import Filters, gain_of
from datasets.simulation.inputs import Field, Floats, Gains, Host, Integers

_AT_REST = (0.0, 0.0)


class Laws(NamedTuple):
    """The laws of all robots.

    Attributes:
        gains: law and gains by robot.
        leader: one, of the formation's leader.
        followers: by robot.
        begun: (R,) whether a robot's law runs.
    """

    gains: list[SlidingGains]
    leader: list[LeaderMemory]
    followers: list[FollowerMemory]
    begun: NDArray[np.bool_]


@compilable
def laws_at_rest(gains: Gains, kinds: Integers) -> Laws:
    """Laws that have not begun.

    Args:
        gains: the followers' laws and gains.
        kinds: (R,) which of them is a robot's.

    Returns:
        The laws.
    """
    count = len(kinds)
    leader = [LeaderMemory(_AT_REST, _AT_REST, _AT_REST, _AT_REST, True)]
    channel = ChannelMemory(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    followers = [FollowerMemory(channel, channel, _AT_REST, True) for _ in range(count)]
    own = [gains[kind] for kind in kinds]
    return Laws(own, leader, followers, np.zeros(count, np.bool_))


@compilable
def steer(
    laws: Laws, filters: Filters, host: Host, field: Field, mission: int, rates: Floats,
    commands: Floats,
) -> None:  # fmt: skip
    """One sample of every law.

    Args:
        laws: with their memories.
        filters: states at the moment the commands take effect.
        host: models.
        field: references and who follows whom.
        mission: tick of the mission.
        rates: (R, 2) h'(0), for laws that begin.
        commands: (R, 2) filled with v and omega.
    """
    laws.leader[0], twist = _lead(laws, filters, host, field.planned[mission])
    commands[0, 0], commands[0, 1] = twist.v, twist.omega
    for robot in range(1, len(commands)):
        own, output = filters.ahead[robot], output_of(laws, filters, host, field, robot)
        w = field.wanted[mission, robot]
        wanted = WantedOutput((w[0], w[1]), (w[2], w[3]), (w[4], w[5]))
        gains = laws.gains[robot]
        memory = laws.followers[robot]
        if not laws.begun[robot]:
            memory = begin(output, wanted, (rates[robot, 0], rates[robot, 1]), gains)
        sample = FollowerSample(output, wanted, own.twist, gain_of(filters, robot))
        laws.followers[robot], twist = follow(memory, sample, host.period, gains, host.follower)
        commands[robot, 0], commands[robot, 1] = twist.v, twist.omega
    laws.begun[:] = True


@compilable
def _lead(
    laws: Laws, filters: Filters, host: Host, plan: Floats
) -> tuple[LeaderMemory, Twist]:
    """The leader's sample."""
    x, y, theta, v, omega, v_rate, omega_rate = plan
    planned = PlannedMotion(UnicycleState(x, y, theta, v, omega), v_rate, omega_rate)
    own, memory = filters.ahead[0], laws.leader[0]
    if not laws.begun[0]:
        memory = begin_leader(own, planned, host.leader)
    actuation = host.follower.actuation
    return lead(memory, own, planned, host.period, host.leader, actuation, gain_of(filters, 0))


@compilable
def output_of(
    laws: Laws, filters: Filters, host: Host, field: Field, robot: int
) -> FollowerOutput:
    """A follower's output, from what is believed and known of its one leader, or of both.

    Args:
        laws: what leaders were commanded.
        filters: states at the moment the commands take effect.
        host: camera offset.
        field: who follows whom, and what it is told.
        robot: number of the follower.

    Returns:
        The output.
    """
    own, d = filters.ahead[robot].twist, host.follower.camera_offset
    relative, motion = _leader_of(laws, filters, host, field, robot, 0)
    if field.leaders[robot, 1] < 0:
        return pair_output(relative, own, motion, d)
    other, other_motion = _leader_of(laws, filters, host, field, robot, 1)
    return two_leaders_output((relative, other), own, (motion, other_motion), d)


@compilable
def _leader_of(
    laws: Laws, filters: Filters, host: Host, field: Field, robot: int, which: int
) -> tuple[RelativeState, LeaderMotion]:
    """Relative state and motion of one of a robot's leaders."""
    leader = field.leaders[robot, which]
    own, state = filters.ahead[robot], filters.ahead[leader]
    relative = relative_state(state.pose, own.pose, host.follower.camera_offset)
    given = _AT_REST
    if field.told[robot]:
        given = _given(laws, leader)
    return relative, LeaderMotion(state.twist, given)


@compilable
def _given(laws: Laws, robot: int) -> Vector2:
    """The acceleration that a robot's last command gives."""
    return laws.leader[0].acceleration if robot == 0 else laws.followers[robot].acceleration
