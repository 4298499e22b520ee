"""The host's laws in one run: the leader's, then every follower's; the functions of control/."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from control.channel import ChannelMemory
from control.compilable import compilable
from control.follower import FollowerMemory, FollowerSample, SlidingGains
from control.leader import LeaderMemory, begin_leader, lead
from control.output import (
    FollowerOutput,
    LeaderMotion,
    WantedOutput,
    pair_output,
    two_leaders_output,
)
from control.plan import PlannedMotion
from control.relative import Vector2, relative_state
from control.sliding import begin, follow
from control.unicycle import UnicycleState
from datasets.simulation.filters import Filters
from datasets.simulation.inputs import Field, Floats, Gains, Host, Integers


class Laws(NamedTuple):
    """The laws of all robots.

    Attributes:
        gains: law and gains by robot.
        leader: one memory, of the formation's leader.
        followers: memories by robot.
        given: accelerations that the last commands give, by robot [m/s^2, rad/s^2].
        begun: (1,) whether the laws run.
    """

    gains: list[SlidingGains]
    leader: list[LeaderMemory]
    followers: list[FollowerMemory]
    given: list[Vector2]
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
    rest, own = (0.0, 0.0), [gains[kind] for kind in kinds]
    leader = [LeaderMemory(rest, rest, rest, rest, True)]
    channel = ChannelMemory(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    followers = [FollowerMemory(channel, channel, rest, True) for _ in kinds]
    return Laws(own, leader, followers, [rest for _ in kinds], np.zeros(1, np.bool_))


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
    ahead, gains, begun, dt = filters.ahead, filters.gains, laws.begun[0], host.period
    x, y, theta, v, omega, v_rate, omega_rate = field.planned[mission]
    plan = PlannedMotion(UnicycleState(x, y, theta, v, omega), v_rate, omega_rate)
    first = laws.leader[0] if begun else begin_leader(ahead[0], plan, host.leader)
    actuation = host.follower.actuation
    laws.leader[0], twist = lead(first, ahead[0], plan, dt, host.leader, actuation, gains[0])
    laws.given[0] = laws.leader[0].acceleration
    commands[0, 0], commands[0, 1] = twist.v, twist.omega
    for robot in range(1, len(commands)):
        kind, memory = laws.gains[robot], laws.followers[robot]
        sample = sample_of(laws, filters, host, field, mission, robot, field.told[robot])
        if not begun:
            rate = rates[robot, 0], rates[robot, 1]
            memory = begin(sample.output, sample.wanted, rate, kind)
        memory, twist = follow(memory, sample, dt, kind, host.follower)
        laws.followers[robot], laws.given[robot] = memory, memory.acceleration
        commands[robot, 0], commands[robot, 1] = twist.v, twist.omega
    laws.begun[0] = True


@compilable
def sample_of(
    laws: Laws, filters: Filters, host: Host, field: Field, mission: int, robot: int, told: bool
) -> FollowerSample:
    """What a follower's law sees.

    Args:
        laws: with the accelerations that all robots are commanded.
        filters: states at the moment the commands take effect.
        host: camera offset.
        field: references and who follows whom.
        mission: tick of the mission.
        robot: number of the follower.
        told: whether it knows what its leaders are commanded.

    Returns:
        The sample.
    """
    ahead, w = filters.ahead, field.wanted[mission, robot]
    one, two = field.leaders[robot, 0], field.leaders[robot, 1]
    output = _output(ahead, laws.given, robot, one, two, told, host.follower.camera_offset)
    wanted = WantedOutput((w[0], w[1]), (w[2], w[3]), (w[4], w[5]))
    return FollowerSample(output, wanted, ahead[robot].twist, filters.gains[robot])


@compilable
def _output(
    ahead: list[UnicycleState], given: list[Vector2], robot: int, one: int, two: int, told: bool,
    d: float,
) -> FollowerOutput:  # fmt: skip
    """From what is believed and known of its leaders; `two` is -1 without a second one."""
    own, state, rest = ahead[robot], ahead[one], (0.0, 0.0)
    relative = relative_state(state.pose, own.pose, d)
    motion = LeaderMotion(state.twist, given[one] if told else rest)
    if two < 0:
        return pair_output(relative, own.twist, motion, d)
    state = ahead[two]
    other = relative_state(state.pose, own.pose, d)
    other_motion = LeaderMotion(state.twist, given[two] if told else rest)
    return two_leaders_output((relative, other), own.twist, (motion, other_motion), d)
