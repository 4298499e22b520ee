"""How well the robots drove: pure functions over recorded arrays; names carry units of output."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from control.command import RobotId
from control.formation import Pair
from control.geometry import Pose2D, wrap_angle
from control.relative import relative_state
from control.unicycle import UnicycleState, advance_pose

Floats = NDArray[np.float64]

LAST_SHARE = 0.2  # of the run, over which the errors of the followers are taken
SETTLED_DISTANCE = 0.02  # [m]
SETTLED_BEARING = 0.1  # [rad]


@dataclass(frozen=True, slots=True)
class FollowerScore:
    """How well a follower kept its place; None where the mission never started.

    Attributes:
        follower: its id.
        leader: id of the robot it follows.
        second_leader: id of the other robot it follows, None if there is none.
        distance_rms_m: of the distance's error, last 20 % of the run; of the worse of two [m].
        distance_max_m: greatest error of the distance there [m].
        bearing_rms_rad: of the bearing's error there, None for a follower of two [rad].
        bearing_max_rad: greatest error of the bearing there [rad].
        settled_at_s: mission time from which |e_l| < 2 cm and |e_psi| < 0.1 rad until the shape's
            next change, None if never [s].
        v_max_mps: greatest speed in the mission [m/s].
        omega_max_radps: greatest angular speed in the mission [rad/s].
    """

    follower: RobotId
    leader: RobotId
    second_leader: RobotId | None
    distance_rms_m: float | None
    distance_max_m: float | None
    bearing_rms_rad: float | None
    bearing_max_rad: float | None
    settled_at_s: float | None
    v_max_mps: float | None
    omega_max_radps: float | None

    @property
    def leaders(self) -> tuple[RobotId, ...]:
        """Ids of the one or two robots that it follows."""
        return (self.leader,) if self.second_leader is None else (self.leader, self.second_leader)


@dataclass(frozen=True, slots=True)
class LeaderScore:
    """How well the formation's leader kept to its plan.

    Attributes:
        position_rms_m: distance to the planned place, over the whole mission [m].
    """

    position_rms_m: float | None


@dataclass(frozen=True, slots=True)
class Motions:
    """What robots did, tick by tick.

    Attributes:
        ids: of the R robots.
        times: shape (T,), capture clock [s].
        mission: shape (T,), mission clock, NaN before the start [s].
        states: shape (T, R, 5), x, y, theta, v, omega; NaN where unknown.
    """

    ids: tuple[RobotId, ...]
    times: Floats
    mission: Floats
    states: Floats

    def of(self, robot_id: RobotId) -> Floats:
        """States of one robot.

        Args:
            robot_id: the robot.

        Returns:
            Shape (T, 5).
        """
        states: Floats = self.states[:, self.ids.index(robot_id)]
        return states


def follower_errors(motions: Motions, pair: Pair, camera_offset: float) -> Floats:
    """Errors of a follower's relative state, e = h^d - h.

    Args:
        motions: of the robots.
        pair: leader, follower and wanted shape.
        camera_offset: of the follower's camera point, d [m].

    Returns:
        Errors of distance and bearing, shape (T, 2), NaN where unknown [m, rad].
    """
    errors = np.full((len(motions.times), 2), np.nan)
    leaders, followers = motions.of(pair.leader)[:, :3], motions.of(pair.follower)[:, :3]
    known = np.isfinite(motions.mission) & np.isfinite(leaders + followers).all(axis=1)
    for k in np.flatnonzero(known):
        leader, follower = Pose2D(*leaders[k].tolist()), Pose2D(*followers[k].tolist())
        seen = relative_state(leader, follower, camera_offset)
        wanted = pair.shape.at(float(motions.mission[k]))
        errors[k] = wanted.distance - seen.distance, wrap_angle(wanted.bearing - seen.bearing)
    return errors


def follower_score(motions: Motions, pairs: Sequence[Pair], errors: Floats) -> FollowerScore:
    """Condense a follower's run.

    Args:
        motions: of the robots.
        pairs: the follower with its leader, or with each of its two.
        errors: shape (P, T, 2), of distance and bearing, NaN where unknown [m, rad].

    Returns:
        The score.
    """
    end = motions.times[-1]
    late = motions.times >= end - LAST_SHARE * (end - motions.times[0])
    distance, bearing = np.abs(errors[:, :, 0]).max(axis=0), errors[0, :, 1]
    own = motions.of(pairs[0].follower)[motions.mission >= 0.0]
    wanted = [distance / SETTLED_DISTANCE]
    wanted += [np.abs(bearing) / SETTLED_BEARING] if len(pairs) == 1 else []
    changes = sorted(t for pair in pairs for t in pair.shape.changes)
    return FollowerScore(
        follower=pairs[0].follower,
        leader=pairs[0].leader,
        second_leader=pairs[1].leader if len(pairs) == 2 else None,
        distance_rms_m=rms(distance[late]),
        distance_max_m=greatest(distance[late]),
        bearing_rms_rad=rms(bearing[late]),
        bearing_max_rad=greatest(bearing[late]),
        settled_at_s=settled_at(motions.mission, np.stack(wanted, axis=1), changes),
        v_max_mps=greatest(own[:, 3]),
        omega_max_radps=greatest(own[:, 4]),
    )


def settled_at(mission: Floats, shares: Floats, changes: Sequence[float]) -> float | None:
    """When a follower came to its place and stayed there until the shape's next change.

    Args:
        mission: shape (T,), mission clock, NaN before the start [s].
        shares: shape (T, N), magnitudes of its errors over what counts as settled; NaN does not.
        changes: when the shape changes, mission clock [s].

    Returns:
        Mission time of the first settled tick, None if there is none [s].
    """
    until = min((t for t in changes if t > 0.0), default=np.inf)
    first = np.flatnonzero((mission >= 0.0) & (mission < until))
    near = shares[first] < 1.0
    away = np.flatnonzero(~near.all(axis=1))
    start = away[-1] + 1 if len(away) else 0
    return float(mission[first[start]]) if start < len(first) else None


def leader_score(motions: Motions, leader: RobotId, planned: Floats) -> LeaderScore:
    """Compare the leader with its plan.

    Args:
        motions: of the robots.
        leader: id of the formation's leader.
        planned: shape (T, 2), its planned places, NaN where there was no plan [m].

    Returns:
        The score.
    """
    started = motions.mission >= 0.0
    off = motions.of(leader)[started, :2] - planned[started]
    return LeaderScore(rms(np.hypot(off[:, 0], off[:, 1])))


def planned_before(planned: UnicycleState, delay: float) -> Pose2D:
    """Where a plan was a moment before, to the first order of its velocities.

    Args:
        planned: state [m, m, rad, m/s, rad/s].
        delay: how long before [s].

    Returns:
        The pose then.
    """
    return advance_pose(planned.pose, planned.twist, -delay)


def rms(values: Floats) -> float | None:
    """Root of the mean square of the known values.

    Args:
        values: shape (N,), NaN where unknown.

    Returns:
        In the unit of the values; None if none is known.
    """
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known**2))) if len(known) else None


def greatest(values: Floats) -> float | None:
    """Greatest magnitude of the known values.

    Args:
        values: shape (N,), NaN where unknown.

    Returns:
        In the unit of the values; None if none is known.
    """
    known = np.abs(values[np.isfinite(values)])
    return float(known.max()) if len(known) else None
