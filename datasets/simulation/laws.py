"""The host's laws in one run: the leader's, then every follower's; the functions of control/."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from control.channel import ChannelMemory
from control.compilable import compilable
from control.follower import FollowerMemory, FollowerSample, SlidingGains
from control.leader import LeaderMemory, begin_leader, lead
from control.output import (
    LeaderMotion,
    WantedOutput,
    pair_output,
    two_leaders_output,
)
from control.plan import PlannedMotion
from control.relative import RelativeState, relative_state
from control.sliding import begin, follow
from control.unicycle import UnicycleState
from control.value import value
from datasets.simulation.filters import gain_of, state_of
from datasets.simulation.inputs import Field, Floats, Gains, Host


@value
@dataclass(frozen=True, slots=True)
class Role:
    """What a robot is told to do.

    Attributes:
        one: whom it follows, -1 for nobody.
        two: whom else, -1 for nobody.
        told: whether it is told what acceleration its leaders are commanded.
        gains: its law and gains.
    """

    one: int
    two: int
    told: bool
    gains: SlidingGains


class Laws(NamedTuple):
    """The laws of all robots.

    Attributes:
        roles: by robot.
        leader: one memory, of the formation's leader.
        followers: memories by robot.
        given: (R, 2) accelerations that the last commands give [m/s^2, rad/s^2].
    """

    roles: list[Role]
    leader: list[LeaderMemory]
    followers: list[FollowerMemory]
    given: Floats


@compilable
def laws_at_rest(gains: Gains, field: Field) -> Laws:
    """Laws that have not begun.

    Args:
        gains: the followers' laws and gains.
        field: who follows whom, with which of them.

    Returns:
        The laws.
    """
    rest, roles = (0.0, 0.0), []
    for robot, kind in enumerate(field.gains):
        one, two = field.leaders[robot]
        roles.append(Role(one, two, field.told[robot], gains[kind]))
    leader = [LeaderMemory(rest, rest, rest, rest, True)]
    channel = ChannelMemory(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    followers = [FollowerMemory(channel, channel, rest, True) for _ in roles]
    return Laws(roles, leader, followers, np.zeros((len(roles), 2)))


@compilable
def lead_on(
    laws: Laws, ahead: Floats, means: Floats, host: Host, planned: Floats, begins: bool,
    commands: Floats,
) -> None:  # fmt: skip
    """One sample of the leader's law.

    Args:
        laws: with their memories.
        ahead: (R, 5) states at the moment the commands take effect.
        means: (R, 7) as in `Filters`.
        host: models.
        planned: (7,) as in `Field`, of the present tick.
        begins: whether the laws begin.
        commands: (R, 2) filled with v and omega.
    """
    x, y, theta, v, omega, v_rate, omega_rate = planned
    plan = PlannedMotion(UnicycleState(x, y, theta, v, omega), v_rate, omega_rate)
    state, gain, motors = state_of(ahead, 0), gain_of(means, 0), host.follower.actuation
    memory = begin_leader(state, plan, host.leader) if begins else laws.leader[0]
    memory, twist = lead(memory, state, plan, host.period, host.leader, motors, gain)
    laws.leader[0] = memory
    laws.given[0, 0], laws.given[0, 1] = memory.acceleration
    commands[0, 0], commands[0, 1] = twist.v, twist.omega


@compilable
def follow_on(
    laws: Laws, ahead: Floats, means: Floats, host: Host, wanted: Floats, rates: Floats,
    begins: bool, commands: Floats,
) -> None:  # fmt: skip
    """One sample of every follower's law.

    Args:
        laws: with their memories.
        ahead: (R, 5) states at the moment the commands take effect.
        means: (R, 7) as in `Filters`.
        host: models.
        wanted: (R, 6) as in `Field`, of the present tick.
        rates: (R, 2) h'(0), for laws that begin.
        begins: whether the laws begin.
        commands: (R, 2) filled with v and omega.
    """
    roles, memories, given, model = laws.roles, laws.followers, laws.given, host.follower
    for robot in range(1, len(commands)):
        role, memory = roles[robot], memories[robot]
        sample = sample_of(ahead, means, given, wanted, robot, role, role.told, model.camera_offset)
        if begins:
            rate = rates[robot, 0], rates[robot, 1]
            memory = begin(sample.output, sample.wanted, rate, role.gains)
        memory, twist = follow(memory, sample, host.period, role.gains, model)
        memories[robot] = memory
        given[robot, 0], given[robot, 1] = memory.acceleration
        commands[robot, 0], commands[robot, 1] = twist.v, twist.omega


@compilable
def sample_of(
    ahead: Floats, means: Floats, given: Floats, wanted: Floats, robot: int, role: Role,
    told: bool, d: float,
) -> FollowerSample:  # fmt: skip
    """What a follower's law sees.

    Args:
        ahead: (R, 5) states at the moment the commands take effect.
        means: (R, 7) as in `Filters`.
        given: (R, 2) accelerations that all robots are commanded.
        wanted: (R, 6) as in `Field`, of the present tick.
        robot: number of the follower.
        role: says whom it follows.
        told: whether it knows what its leaders are commanded.
        d: camera offset [m].

    Returns:
        The sample.
    """
    own = state_of(ahead, robot)
    relative, motion = _seen(ahead, given, own, role.one, told, d)
    if role.two < 0:
        output = pair_output(relative, own.twist, motion, d)
    else:
        other, other_motion = _seen(ahead, given, own, role.two, told, d)
        output = two_leaders_output((relative, other), own.twist, (motion, other_motion), d)
    h, rate = (wanted[robot, 0], wanted[robot, 1]), (wanted[robot, 2], wanted[robot, 3])
    aim = WantedOutput(h, rate, (wanted[robot, 4], wanted[robot, 5]))
    return FollowerSample(output, aim, own.twist, gain_of(means, robot))


@compilable
def _seen(
    ahead: Floats, given: Floats, own: UnicycleState, leader: int, told: bool, d: float
) -> tuple[RelativeState, LeaderMotion]:
    """What is believed and known of a leader."""
    state, known = state_of(ahead, leader), (given[leader, 0], given[leader, 1])
    relative = relative_state(state.pose, own.pose, d)
    return relative, LeaderMotion(state.twist, known if told else (0.0, 0.0))
