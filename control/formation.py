"""Who follows whom, and in which shape: pairs, time-varying references, the tree they form."""

from dataclasses import dataclass

from control.command import RobotId
from control.errors import ControlError
from control.profile import Profile


@dataclass(frozen=True, slots=True)
class ShapeReference:
    """Wanted relative configuration h^d of a follower at one moment, with derivatives.

    Attributes:
        distance: l_ik^d [m].
        bearing: psi_ik^d in the convention of (7) [rad].
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
        bearing: psi_ik^d over time, convention of (7) [rad].
    """

    distance: Profile
    bearing: Profile

    def at(self, t: float) -> ShapeReference:
        """Reference with derivatives at one moment.

        Args:
            t: time on the mission's clock [s].

        Returns:
            Distance and bearing with two derivatives each.
        """
        l, dl, ddl = self.distance.at(t)  # noqa: E741 (the paper's l)
        psi, dpsi, ddpsi = self.bearing.at(t)
        return ShapeReference(l, psi, dl, dpsi, ddl, ddpsi)

    @property
    def changes(self) -> tuple[float, ...]:
        """Times at which the shape changes, ascending [s]."""
        return tuple(sorted({*self.distance.changes, *self.bearing.changes}))


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


@dataclass(frozen=True, slots=True)
class Formation:
    """A tree of pairs under one leader of the formation.

    Attributes:
        pairs: kept leaders first: a robot appears as follower before it appears as leader.

    Raises:
        ControlError: if there is no pair, a robot has two leaders, follows itself, the pairs form
            a cycle, or there is more than one robot without a leader. The message names them.
    """

    pairs: tuple[Pair, ...]

    def __post_init__(self) -> None:
        if not self.pairs:
            raise ControlError("a formation needs at least one pair")
        object.__setattr__(self, "pairs", _leaders_first(self.pairs))

    @property
    def root(self) -> RobotId:
        """The leader of the whole formation."""
        return self.pairs[0].leader

    @property
    def robots(self) -> tuple[RobotId, ...]:
        """All robots, leaders before their followers."""
        return (self.root, *(pair.follower for pair in self.pairs))


def _leaders_first(pairs: tuple[Pair, ...]) -> tuple[Pair, ...]:
    followers = [pair.follower for pair in pairs]
    twice = sorted({str(robot) for robot in followers if followers.count(robot) > 1})
    if twice:
        raise ControlError(f"robots with more than one leader: {', '.join(twice)}")
    roots = list(dict.fromkeys(p.leader for p in pairs if p.leader not in followers))
    if len(roots) > 1:
        names = ", ".join(str(robot) for robot in roots)
        raise ControlError(f"a formation has one leader without a leader, found: {names}")
    ordered = _reachable(pairs, roots)
    if len(ordered) < len(pairs):
        lost = ", ".join(str(p.follower) for p in pairs if p not in ordered)
        raise ControlError(f"robots that follow each other in a circle: {lost}")
    return ordered


def _reachable(pairs: tuple[Pair, ...], roots: list[RobotId]) -> tuple[Pair, ...]:
    """Pairs under the roots, layer by layer, each layer in the given order."""
    ordered: list[Pair] = []
    layer = roots
    while layer:
        below = [pair for pair in pairs if pair.leader in layer]
        ordered += below
        layer = [pair.follower for pair in below]
    return tuple(ordered)
