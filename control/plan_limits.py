"""What a plan must keep: limits of the leader, of its followers, obstacles, the arena's border.

Every constraint is a named share that must not exceed 1: a velocity over its limit; for
distances, 1 plus what lacks to the wanted one over a length.
"""

from dataclasses import dataclass, replace
from math import isfinite

import numpy as np
from numpy.typing import NDArray

from control.flatness import Shape, follower_rows, leader_rows, shape, shape_gradient
from control.motion_model import Array
from control.plan_frame import directions_seen_from, seen_from
from control.plan_problem import Mesh, Space, read_only
from control.plan_request import FollowerPlace, PlanRequest

_LEAST = 1e-9  # of distances, which have no direction at 0 [m]


@dataclass(frozen=True, slots=True)
class Scale:
    """Sizes of a problem, to compare its constraints by.

    Attributes:
        length: of the way [m].
        pace: of the curve on the way [m/s].
        least_pace: below it the curve is not regular [m/s].
    """

    length: float
    pace: float
    least_pace: float


@dataclass(frozen=True, slots=True)
class Room:
    """Obstacles and borders in the frame of a curve, inflated by the clearance; read-only.

    Attributes:
        centers: (k, 2) of the obstacles at the start [m].
        velocities: (k, 2) of the obstacles [m/s].
        reaches: (k,) least distances from the centers [m].
        normals: (4, 2), or (0, 2) without an arena: outward [1].
        borders: as many: greatest reach along the normals [m].
    """

    centers: Array
    velocities: Array
    reaches: Array
    normals: Array
    borders: Array

    def __post_init__(self) -> None:
        read_only(self.centers, self.velocities, self.reaches, self.normals, self.borders)

    def apart(self, position: Array, t: Array) -> Array:
        """From the obstacles to the leader.

        Args:
            position: (2, n) of the leader [m].
            t: (n,) times since the start [s].

        Returns:
            (k, 2, n) differences of position [m].
        """
        moved: Array = self.centers[:, :, None] + self.velocities[:, :, None] * t
        return position - moved


@dataclass(frozen=True, slots=True)
class Constraints:
    """All shares of a request on a mesh, as functions of the variables of a space; read-only.

    Attributes:
        names: one a row, in the order of the shares.
        request: limits and places.
        around: obstacles and borders.
        scale: sizes of the problem.
        mesh: where the shares are looked at.
        constant: (4, 2, n) curve and derivatives for w = 0.
        linear: (4, 2, n, m) what the variables add.
    """

    names: tuple[str, ...]
    request: PlanRequest
    around: Room
    scale: Scale
    mesh: Mesh
    constant: Array
    linear: Array

    def __post_init__(self) -> None:
        read_only(self.constant, self.linear)

    @property
    def distances(self) -> NDArray[np.bool_]:
        """(r,) which shares are of distances; the first one is of the pace, the others limits'."""
        places = len(self.around.reaches) + len(self.around.borders)
        return np.arange(len(self.names)) >= len(self.names) - places

    def shares(self, w: Array) -> Array:
        """All shares.

        Args:
            w: (m,) variables.

        Returns:
            (r, n) shares, at most 1 where the plan keeps its limits [1].
        """
        p, *rates = self.constant + self.linear @ w
        limits, places = self._rows(p, shape(*rates))
        return np.concatenate((limits[:, 0], places[:, 0]))

    def jacobian(self, w: Array) -> Array:
        """Derivatives of all shares.

        Args:
            w: (m,) variables.

        Returns:
            (r, n, m) derivatives for the variables.
        """
        p, p1, p2, p3 = self.constant + self.linear @ w
        at, (n, m) = shape(p1, p2, p3), self.linear.shape[2:]
        limits, places = self._rows(p, at)
        shapes = shape_gradient(p1, p2, p3, at).reshape(4, 6, n).transpose(2, 0, 1)
        shapes = shapes @ self.linear[1:].reshape(6, n, m).transpose(1, 0, 2)  # (n, 4, m)
        speeds = (limits[:, 1:].transpose(2, 0, 1) @ shapes).transpose(1, 0, 2)
        return np.concatenate((speeds, np.einsum("rxn,xnm->rnm", places[:, 1:], self.linear[0])))

    def only(self, chosen: NDArray[np.bool_]) -> "Constraints":
        """The same constraints at some of the times.

        Args:
            chosen: (n,) which.

        Returns:
            Constraints on a part of the mesh.
        """
        at = self.mesh
        part = Mesh(at.t[chosen], at.law[:, chosen], at.basis[:, chosen])
        constant, linear = self.constant[:, :, chosen], self.linear[:, :, chosen]
        return replace(self, mesh=part, constant=constant, linear=linear)

    def _rows(self, p: Array, at: Shape) -> tuple[Array, Array]:
        """(r1, 5, n) limits and (r2, 3, n) distances: the share, then its derivatives."""
        limits = [row for _, row in limit_rows(at, self.mesh.law, self.request, self.scale)]
        return np.array(limits), place_rows(p, self.mesh.t, self.around, self.scale.length)


def constraints(at: Mesh, curves: Space, request: PlanRequest, scale: Scale) -> Constraints:
    """The constraints of a request on a mesh.

    Args:
        at: the mesh.
        curves: the space of curves.
        request: limits, obstacles and arena, in floor coordinates.
        scale: sizes of the problem.

    Returns:
        The constraints.
    """
    constant = curves.best @ at.basis.transpose(0, 2, 1)
    linear = at.basis[:, None] @ curves.directions
    rows = limit_rows(shape(*constant[1:]), at.law, request, scale)
    names = tuple(name for name, _ in rows) + place_names(request)
    return Constraints(names, request, room(request), scale, at, constant, linear)


def limit_rows(
    at: Shape, law: Array, request: PlanRequest, scale: Scale
) -> list[tuple[str, Array]]:
    """Shares of the limits on velocities and accelerations, with derivatives for the shape.

    Args:
        at: shape of the curve.
        law: (4, n) S and its derivatives.
        request: limits of the leader and of the followers.
        scale: gives the least pace.

    Returns:
        Names and (5, n) rows: the share and its derivatives for u, a, kappa, k; those of
        infinite limits are left out.
    """
    limits, (v, omega, v_rate, omega_rate) = request.limits, leader_rows(at, law)
    pace = np.zeros_like(v)
    pace[0] = 1.0 + (scale.least_pace - at.u) / scale.pace
    pace[1] = -1.0 / scale.pace
    return [
        ("pace", pace),
        ("speed", v / limits.v),
        *_both("turning rate", omega, limits.omega),
        *_both("acceleration", v_rate, limits.v_rate),
        *_both("angular acceleration", omega_rate, limits.omega_rate),
        *(row for place in request.places for row in _place(at, law, place)),
    ]


def _both(name: str, row: Array, limit: float) -> list[tuple[str, Array]]:
    """A limit of either sign."""
    return [(name, row / limit), (name, row / -limit)]


def _place(at: Shape, law: Array, place: FollowerPlace) -> list[tuple[str, Array]]:
    """Shares of one follower; its faster wheel runs at |v| + b/2 |omega|."""
    speed, turn = follower_rows(at, law, place)
    who, half = f"of the follower at ({place.x:g}, {place.y:g}) m", 0.5 * place.track_width
    rows: list[tuple[str, Array]] = []
    if isfinite(place.speed_limit):
        rows.append((f"speed {who}", speed / place.speed_limit))
    if isfinite(place.turn_limit):
        rows += _both(f"turning rate {who}", turn, place.turn_limit)
    if isfinite(place.wheel_speed):
        for side in (half, -half):
            rows.append((f"wheel speed {who}", (speed + side * turn) / place.wheel_speed))
    return rows


def room(request: PlanRequest) -> Room:
    """The surroundings seen from the start pose.

    Args:
        request: obstacles, arena, clearance and start.

    Returns:
        The same in the frame of the start.
    """
    pose, obstacles = request.start.pose, request.obstacles
    centers = np.array([(o.x, o.y) for o in obstacles]).reshape(-1, 2)
    velocities = np.array([(o.vx, o.vy) for o in obstacles]).reshape(-1, 2)
    reaches = np.array([o.radius + request.clearance for o in obstacles])
    sides = np.array(request.arena.sides() if request.arena else ()).reshape(-1, 3)
    return Room(
        seen_from(pose, centers.T).T,
        directions_seen_from(pose, velocities.T).T,
        reaches,
        directions_seen_from(pose, sides[:, :2].T).T,
        sides[:, 2] - sides[:, :2] @ (pose.x, pose.y) - request.clearance,
    )


def place_rows(position: Array, t: Array, around: Room, length: float) -> Array:
    """Shares of the distances to obstacles and to the arena's border.

    Args:
        position: (2, n) of the leader [m].
        t: (n,) times since the start [s].
        around: obstacles and borders.
        length: that counts as 1 [m].

    Returns:
        (k, 3, n): the share and its derivatives for x and y; obstacles first.
    """
    apart = around.apart(position, t)
    distance = np.maximum(np.hypot(apart[:, 0], apart[:, 1]), _LEAST)[:, None]
    lack = around.reaches[:, None, None] - distance
    discs = np.concatenate((1.0 + lack / length, apart / (-length * distance)), axis=1)
    out = around.normals @ position - around.borders[:, None]
    normals = np.broadcast_to(around.normals[:, :, None] / length, (len(out), 2, len(t)))
    sides = np.concatenate((1.0 + out[:, None] / length, normals), axis=1)
    return np.concatenate((discs, sides))


def place_names(request: PlanRequest) -> tuple[str, ...]:
    """Names of the rows of ``place_rows``.

    Args:
        request: as asked, in floor coordinates.

    Returns:
        One name a row.
    """
    discs = (f"distance to the obstacle at ({o.x:g}, {o.y:g}) m" for o in request.obstacles)
    sides = ("front", "left", "back", "right") if request.arena else ()
    return (*discs, *(f"distance to the {side} border of the arena" for side in sides))
