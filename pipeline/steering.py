"""From predicted states to twists: the leader's law, then every follower's."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from control.command import Command, RobotId
from control.follower import FollowerMemory, FollowerSample
from control.formation import Pair, by_follower
from control.keyed import keyed_step
from control.leader import LeaderMemory, begin_leader, leader_step
from control.output import LeaderMotion, follower_output, wanted_output
from control.plan import PlannedMotion
from control.relative import Vector2, relative_state
from control.sliding import begin, follower_step
from control.unicycle import Twist
from datasets.cycle import PairState
from pipeline.memory import Laws, Track
from pipeline.setup import Setup

STANDSTILL = Twist(0.0, 0.0)
AT_REST: Vector2 = (0.0, 0.0)
NOTHING_TOLD: Mapping[RobotId, Vector2] = MappingProxyType({})


@dataclass(frozen=True, slots=True)
class Aim:
    """What is wanted at the moment the commands take effect.

    Attributes:
        planned: motion of the formation's leader; None without a plan.
        drive: velocities that a person at the keys wants of it [m/s, rad/s].
        pairs: predicted and wanted relative state of every pair, leaders first.
        shares: of its commanded speed that each robot may drive, 0 to 1.
        rates: h'(0) by follower where the start has measured them.
    """

    planned: PlannedMotion | None
    drive: Twist
    pairs: tuple[PairState, ...]
    shares: Mapping[RobotId, float]
    rates: Mapping[RobotId, Vector2]


def relate(
    setup: Setup, tracks: Mapping[RobotId, Track], t_mission: float
) -> tuple[PairState, ...]:
    """Predicted and wanted relative state of every pair whose robots are known.

    Args:
        setup: formation and camera offset.
        tracks: rolled to the moment the command takes effect.
        t_mission: that moment on the mission's clock [s].

    Returns:
        One entry per known pair, leaders first.
    """
    return tuple(
        _pair_state(setup, pair, tracks, t_mission)
        for pair in setup.formation.pairs
        if pair.leader in tracks and pair.follower in tracks
    )


def steer(
    setup: Setup, laws: Laws, aim: Aim, tracks: Mapping[RobotId, Track], dt: float
) -> tuple[Laws, Mapping[RobotId, Twist]]:
    """One sample of every law. A robot that must stand gets 0, and its law starts afresh after.

    Args:
        setup: gains and models.
        laws: memories of the laws.
        aim: what is wanted.
        tracks: rolled to the moment the commands take effect.
        dt: since the last sample [s].

    Returns:
        New memories, and the twist of every robot of the formation but a leader that is carried.
    """
    root = setup.formation.root
    leader, twist = _lead(setup, laws, aim, tracks[root], dt)
    twists = {} if twist is None else {root: twist}
    given = {root: leader.acceleration if leader else AT_REST}
    followers: dict[RobotId, FollowerMemory] = {}
    for robot, pairs in by_follower(aim.pairs).items():
        sample = follower_sample(
            setup, pairs, tracks, given if setup.leader_commands_known else NOTHING_TOLD
        )
        memory, twists[robot] = _follow(setup, laws, aim, robot, sample, dt)
        given[robot] = memory.acceleration if memory else AT_REST
        if memory is not None:
            followers[robot] = memory
    return Laws(leader, followers, laws.kept), twists


def follower_sample(
    setup: Setup,
    pairs: Sequence[PairState],
    tracks: Mapping[RobotId, Track],
    told: Mapping[RobotId, Vector2],
) -> FollowerSample:
    """What a follower's law sees.

    Args:
        setup: camera offset.
        pairs: of one follower.
        tracks: rolled to the moment the commands take effect.
        told: accelerations that leaders are commanded, where followers know them [m/s^2, rad/s^2].

    Returns:
        The sample.
    """
    track, d = tracks[pairs[0].follower], setup.follower.camera_offset
    leaders = [
        LeaderMotion(tracks[pair.leader].ahead.twist, told.get(pair.leader, AT_REST))
        for pair in pairs
    ]
    own = track.ahead.twist
    output = follower_output([pair.relative for pair in pairs], own, leaders, d)
    wanted = wanted_output([pair.reference for pair in pairs])
    return FollowerSample(output, wanted, own, track.estimate.gain)


def commands_of(
    setup: Setup, twists: Mapping[RobotId, Twist], t: float, t_effective: float
) -> tuple[Command, ...]:
    """Wrap twists as commands that expire.

    Args:
        setup: how long a command is valid.
        twists: by robot.
        t: the present moment [s].
        t_effective: when they reach the wheels [s].

    Returns:
        One command per twist.
    """
    until = t + setup.command_validity
    return tuple(Command(robot, twist, t_effective, until) for robot, twist in twists.items())


def _pair_state(
    setup: Setup, pair: Pair, tracks: Mapping[RobotId, Track], t_mission: float
) -> PairState:
    leader, follower = tracks[pair.leader].ahead.pose, tracks[pair.follower].ahead.pose
    relative = relative_state(leader, follower, setup.follower.camera_offset)
    return PairState(pair.leader, pair.follower, relative, pair.shape.at(t_mission))


def _lead(
    setup: Setup, laws: Laws, aim: Aim, track: Track, dt: float
) -> tuple[LeaderMemory | None, Twist | None]:
    """The leader's sample, from a memory that begins when there is none; no twist if carried."""
    motors, gain = setup.follower.actuation, track.estimate.gain
    if aim.planned is None and setup.keys is None:
        return None, None
    if aim.shares[setup.formation.root] == 0.0:
        return None, STANDSTILL
    if setup.keys:
        return keyed_step(track.ahead, aim.drive, dt, setup.keys, motors, gain)
    assert aim.planned
    memory = laws.leader or begin_leader(track.ahead, aim.planned, setup.leader_gains)
    return leader_step(memory, track.ahead, aim.planned, dt, setup.leader_gains, motors, gain)


def _follow(
    setup: Setup, laws: Laws, aim: Aim, robot: RobotId, sample: FollowerSample, dt: float
) -> tuple[FollowerMemory | None, Twist]:
    """A follower's sample, from a memory that begins when there is none."""
    if aim.shares[robot] == 0.0:
        return None, STANDSTILL
    gains, memory = setup.gains[robot], laws.followers.get(robot)
    if memory is None:
        memory = begin(sample.output, sample.wanted, aim.rates.get(robot, AT_REST), gains)
    return follower_step(memory, sample, dt, gains, setup.follower)
