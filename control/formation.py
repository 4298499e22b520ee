"""Who follows whom, and in which shape: pairs, time-varying references, the graph they form."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import nan
from typing import Protocol, TypeVar

from control.command import RobotId
from control.errors import ControlError
from control.profile import Profile


@dataclass(frozen=True, slots=True)
class ShapeReference:
    """Wanted relative configuration h^d of a follower at one moment, with derivatives.

    Attributes:
        distance: l_ik^d [m].
        bearing: psi_ik^d in the convention of (7), NaN where a distance to a second leader takes
            its place (Remark 3) [rad].
        distance_rate: first derivative of the distance [m/s].
        bearing_rate: first derivative of the bearing [rad/s].
        distance_acceleration: second derivative of the distance [m/s^2].
        bearing_acceleration: second derivative of the bearing [rad/s^2].
    """

    distance: float
    bearing: float
    distance_rate: float = 0.0
    bearing_rate: float = 0.0
    distance_acceleration: float = 0.0
    bearing_acceleration: float = 0.0


@dataclass(frozen=True, slots=True)
class Shape:
    """Wanted place of a follower about its leader as a function of time.

    Attributes:
        distance: l_ik^d over time [m].
        bearing: psi_ik^d over time, convention of (7); None for a follower of two leaders [rad].
    """

    distance: Profile
    bearing: Profile | None

    def at(self, t: float) -> ShapeReference:
        """Reference with derivatives at one moment.

        Args:
            t: time on the mission's clock [s].

        Returns:
            Distance and bearing with two derivatives each; the bearing is NaN if there is none.
        """
        l, dl, ddl = self.distance.at(t)  # noqa: E741 (the paper's l)
        psi, dpsi, ddpsi = self.bearing.at(t) if self.bearing else (nan, 0.0, 0.0)
        return ShapeReference(l, psi, dl, dpsi, ddl, ddpsi)

    @property
    def changes(self) -> tuple[float, ...]:
        """Times at which the shape changes, ascending [s]."""
        turns = self.bearing.changes if self.bearing else ()
        return tuple(sorted({*self.distance.changes, *turns}))


@dataclass(frozen=True, slots=True)
class Pair:
    """One leader-follower pair.

    Attributes:
        leader: id of robot i.
        follower: id of robot k.
        shape: where k is to be about i.
    """

    leader: RobotId
    follower: RobotId
    shape: Shape


class Follows(Protocol):
    """Anything said of a follower and one of its leaders."""

    @property
    def follower(self) -> RobotId:
        """Id of robot k."""
        ...


F = TypeVar("F", bound=Follows)


def by_follower(pairs: Iterable[F]) -> Mapping[RobotId, tuple[F, ...]]:
    """Group what is said of pairs by the robot that follows.

    Args:
        pairs: leaders first.

    Returns:
        One or two by follower, in the same order.
    """
    groups: dict[RobotId, tuple[F, ...]] = {}
    for pair in pairs:
        groups[pair.follower] = (*groups.get(pair.follower, ()), pair)
    return groups


@dataclass(frozen=True, slots=True)
class Formation:
    """A graph of pairs under one leader of the formation: a tree, or with followers of two robots.

    A follower of one robot keeps a distance and a bearing, a follower of two keeps two distances
    (Remark 3).

    Attributes:
        pairs: kept leaders first: a robot follows before it leads; those of a follower of two
            side by side.

    Raises:
        ControlError: if there is no pair, a robot has more than two leaders, one twice or itself,
            a bearing too many or too few, the pairs form a cycle, or there is more than one robot
            without a leader. The message names them.
    """

    pairs: tuple[Pair, ...]

    def __post_init__(self) -> None:
        if not self.pairs:
            raise ControlError("a formation needs at least one pair")
        groups = by_follower(self.pairs)
        for robot, pairs in groups.items():
            _require_output(robot, pairs)
        object.__setattr__(self, "pairs", _leaders_first(groups))

    @property
    def root(self) -> RobotId:
        """The leader of the whole formation."""
        return self.pairs[0].leader

    @property
    def robots(self) -> tuple[RobotId, ...]:
        """All robots, leaders before their followers."""
        return (self.root, *by_follower(self.pairs))


def _require_output(robot: RobotId, pairs: Sequence[Pair]) -> None:
    """Refuse what is neither a distance and a bearing nor two distances."""
    leaders = [pair.leader for pair in pairs]
    if len(leaders) > 2 or len(set(leaders)) < len(leaders):
        names = ", ".join(map(str, leaders))
        raise ControlError(f"robot {robot} follows {names}: give it one leader, or two")
    bearings = sum(pair.shape.bearing is not None for pair in pairs)
    if bearings != 2 - len(leaders):
        wanted = "needs a bearing" if len(leaders) == 1 else "takes distances alone, no bearing"
        raise ControlError(f"robot {robot} follows {', '.join(map(str, leaders))} and {wanted}")


def _leaders_first(groups: Mapping[RobotId, Sequence[Pair]]) -> tuple[Pair, ...]:
    leaders = [pair.leader for pairs in groups.values() for pair in pairs]
    roots = list(dict.fromkeys(robot for robot in leaders if robot not in groups))
    if len(roots) > 1:
        names = ", ".join(str(robot) for robot in roots)
        raise ControlError(f"a formation has one leader without a leader, found: {names}")
    placed, waiting = set(roots), dict(groups)
    ordered: list[Pair] = []
    while waiting:
        ready = [k for k, pairs in waiting.items() if all(p.leader in placed for p in pairs)]
        if not ready:
            lost = ", ".join(map(str, waiting))
            raise ControlError(f"robots that follow each other in a circle: {lost}")
        ordered += [pair for robot in ready for pair in waiting.pop(robot)]
        placed.update(ready)
    return tuple(ordered)
