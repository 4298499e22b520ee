"""What becomes of the laws' twists: slowed by the safety rules, kept off other bodies.

The laws learn which accelerations their robots really get, so that nothing winds up.
"""

from collections.abc import Mapping
from dataclasses import replace
from math import hypot, nan

import numpy as np

from control.command import RobotId
from control.formation import by_follower
from control.relative import Vector2
from control.sliding import overruled
from control.unicycle import Twist, UnicycleState
from datasets.cycle import SafetyEvent
from pipeline.clearing import clear_commands
from pipeline.memory import Laws, Track
from pipeline.setup import Setup
from pipeline.steering import NOTHING_TOLD, Aim, follower_sample

FOLLOWER_FREEDOM, LEADER_FREEDOM = 1.0, 0.25  # the leader gives way less: all follow it
NOBODY_DRIVES = Twist(nan, nan)
CALM = 0.5  # after which a robot that was kept off others counts as left alone [s]

Twists = Mapping[RobotId, Twist]
Tracks = Mapping[RobotId, Track]


def restrain(
    setup: Setup, laws: Laws, wanted: Twists, aim: Aim, tracks: Tracks, t: float, dt: float
) -> tuple[Laws, Twists, tuple[SafetyEvent, ...]]:
    """Twists that may be sent: within each robot's share of speed, and clear of other bodies.

    Args:
        setup: clearance, arena and models.
        laws: memories after this sample.
        wanted: what the laws want [m/s, rad/s].
        aim: with the shares and the pairs.
        tracks: rolled to the moment the commands take effect; robots nobody drives are obstacles.
        t: now [s].
        dt: for which the commands hold [s].

    Returns:
        Memories that know what was given, the twists, and who is newly kept off others; laws and
        twists are as they were if nothing is close and all may drive.
    """
    allowed = {robot: _scaled(twist, aim.shares[robot]) for robot, twist in wanted.items()}
    given = _apart(setup, allowed, aim.shares, tracks, dt)
    for robot in wanted:
        if given[robot] != wanted[robot]:
            laws = _told(setup, laws, aim, robot, given[robot], tracks, dt)
    moved = [robot for robot in given if given[robot] != allowed[robot]]
    kept = {robot: last for robot, last in laws.kept.items() if t - last < CALM}
    states = {robot: track.ahead for robot, track in tracks.items()}
    events = tuple(kept_event(setup, robot, states, t) for robot in moved if robot not in kept)
    return replace(laws, kept=kept | dict.fromkeys(moved, t)), given, events


def kept_event(
    setup: Setup, robot: RobotId, states: Mapping[RobotId, UnicycleState], t: float
) -> SafetyEvent:
    """Who is kept off whom.

    Args:
        setup: clearance.
        robot: that is kept off.
        states: of all robots when the command takes effect.
        t: now [s].

    Returns:
        The event.
    """
    own = states[robot]
    ways = {
        other: hypot(state.x - own.x, state.y - own.y)
        for other, state in states.items()
        if other != robot
    }
    nearest = min(ways, key=lambda other: ways[other], default=None)
    least = 1e3 * setup.clearance.distance if setup.clearance else 0.0
    detail = f"slowed or turned to keep {least:.0f} mm free; nearest is robot {nearest}"
    return SafetyEvent(t, "kept-apart", robot, detail)


def _scaled(twist: Twist, share: float) -> Twist:
    return twist if share == 1.0 else Twist(share * twist.v, share * twist.omega)


def _apart(
    setup: Setup, twists: Twists, shares: Mapping[RobotId, float], tracks: Tracks, dt: float
) -> Twists:
    """The filter's twists; the very same where nothing is close."""
    if setup.clearance is None:
        return twists
    table = np.array([
        (*_state(track.ahead), *_twist(twists.get(robot, NOBODY_DRIVES)),
         track.estimate.gain.v, track.estimate.gain.omega,
         _freedom(setup, robot, shares) if robot in twists else 0.0)
        for robot, track in tracks.items()
    ])  # fmt: skip
    motors = setup.follower.actuation
    given = clear_commands(table, dt, motors, setup.clearance, setup.arena)
    kept = zip(tracks, given.tolist(), strict=True)
    return {robot: Twist(*row) for robot, row in kept if robot in twists}


def _state(state: UnicycleState) -> tuple[float, ...]:
    return state.x, state.y, state.theta, state.v, state.omega


def _twist(twist: Twist) -> Vector2:
    return twist.v, twist.omega


def _freedom(setup: Setup, robot: RobotId, shares: Mapping[RobotId, float]) -> float:
    """How easily a robot gives way; 0 for one that stands or that nobody drives."""
    if not shares.get(robot):
        return 0.0
    return LEADER_FREEDOM if robot == setup.formation.root else FOLLOWER_FREEDOM


def _told(
    setup: Setup, laws: Laws, aim: Aim, robot: RobotId, given: Twist, tracks: Tracks, dt: float
) -> Laws:
    """The laws after a robot's twist was replaced."""
    track = tracks[robot]
    u = setup.follower.actuation.acceleration(track.ahead.twist, given, dt, track.estimate.gain)
    if robot == setup.formation.root:
        return replace(laws, leader=laws.leader and replace(laws.leader, acceleration=u))
    memory = laws.followers.get(robot)
    if memory is None:
        return laws
    sample = follower_sample(setup, by_follower(aim.pairs)[robot], tracks, NOTHING_TOLD)
    followers = {**laws.followers, robot: overruled(memory, sample, u, setup.gains[robot])}
    return replace(laws, followers=followers)
