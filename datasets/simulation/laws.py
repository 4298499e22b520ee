"""The host's laws in one run: the leader's, then every follower's; the functions of control/."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from control.channel import ChannelMemory
from control.compilable import compilable
from control.leader import LeaderMemory, begin_leader, lead
from control.output import FollowerOutput, LeaderMotion, WantedOutput, pair_output
from control.plan import PlannedMotion
from control.relative import Vector2, relative_state
from control.sliding import FollowerMemory, FollowerSample, begin, follow
from control.unicycle import Twist, UnicycleState
from datasets.simulation.filters import Filters, gain_of
from datasets.simulation.inputs import Field, Floats, Host

_AT_REST = (0.0, 0.0)


class Laws(NamedTuple):
    """Memories of the laws.

    Attributes:
        leader: one, of the formation's leader.
        followers: by robot.
        begun: (R,) whether a robot's law runs.
    """

    leader: list[LeaderMemory]
    followers: list[FollowerMemory]
    begun: NDArray[np.bool_]


@compilable
def laws_at_rest(count: int) -> Laws:
    """Laws that have not begun.

    Args:
        count: number of robots.

    Returns:
        Their memories.
    """
    leader = [LeaderMemory(_AT_REST, _AT_REST, _AT_REST, _AT_REST, True)]
    channel = ChannelMemory(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    followers = [FollowerMemory(channel, channel, _AT_REST, True) for _ in range(count)]
    return Laws(leader, followers, np.zeros(count, np.bool_))


@compilable
def steer(
    laws: Laws, filters: Filters, host: Host, field: Field, mission: int, rates: Floats,
    commands: Floats,
) -> None:  # fmt: skip
    """One sample of every law.

    Args:
        laws: their memories.
        filters: states at the moment the commands take effect.
        host: gains and models.
        field: references and who follows whom.
        mission: tick of the mission.
        rates: (R, 2) h'(0), for laws that begin.
        commands: (R, 2) filled with v and omega.
    """
    laws.leader[0], twist = _lead(laws, filters, host, field.planned[mission])
    commands[0, 0], commands[0, 1] = twist.v, twist.omega
    for robot in range(1, len(commands)):
        own, leader = filters.ahead[robot], field.leaders[robot, 0]
        known = _given(laws, leader) if field.told[robot] else _AT_REST
        output = _output(filters, host, leader, own, known)
        w = field.wanted[mission, robot]
        wanted = WantedOutput((w[0], w[1]), (w[2], w[3]), (w[4], w[5]))
        gains = host.gains[field.gains[robot]]
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
def _output(
    filters: Filters, host: Host, leader: int, own: UnicycleState, known: Vector2
) -> FollowerOutput:
    """A follower's output, from its leader's state and what is known of its commands."""
    state, d = filters.ahead[leader], host.follower.camera_offset
    motion = LeaderMotion(state.twist, known)
    return pair_output(relative_state(state.pose, own.pose, d), own.twist, motion, d)


@compilable
def _given(laws: Laws, robot: int) -> Vector2:
    """The acceleration that a robot's last command gives."""
    return laws.leader[0].acceleration if robot == 0 else laws.followers[robot].acceleration
