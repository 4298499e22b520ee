"""The search for a plan of one duration: guesses, SLSQP on the nodes, a check between them."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from control.detours import detours
from control.motion_model import Array
from control.plan_limits import Constraints, Scale, constraints
from control.plan_problem import End, Space, mesh, read_only, space
from control.plan_request import PlanRequest
from control.time_law import TimeLaw

FINER = 10
"""The check looks at so many times the intervals of the nodes."""

EXACT = 1e-6
"""A share beyond 1 by less is rounding [1]."""

_RESERVE = 1e-3  # of the limits, for what happens between the nodes
_PLACE_RESERVE = 2e-4  # of the distances, over the length of the way
_NEAR = 0.3  # SLSQP minds the limits of which a guess uses so much, and those it then exceeds
_ROUNDS = 6  # of SLSQP, each with the nodes at which the one before exceeds a limit
_STEPS = 40  # of SLSQP
_PRECISION = 1e-6  # of the cost
_FIXED = 1e-9  # derivatives below are of what the ends fix
_CLOSENESS = 0.02  # with which a guess is fitted, over the length of the way
_LEAST_PACE = 0.1  # of the mean pace: below it the curve is not regular
_HOPELESS = 4.0  # a guess that costs so many times the best plan is not followed


@dataclass(frozen=True, slots=True)
class Task:
    """A request with its duration decided: the curves to choose from and what they must keep.

    Attributes:
        request: as asked.
        law: of the time.
        curves: between the two ends, seen from the start pose.
        constraints: on a mesh FINER than the nodes.
    """

    request: PlanRequest
    law: TimeLaw
    curves: Space
    constraints: Constraints

    @property
    def shares_of_way(self) -> Array:
        """(n,) S at the nodes over S at the end [1]."""
        s = self.constraints.mesh.law[0, ::FINER]
        shares: Array = s / s[-1]
        return shares

    @property
    def straightest(self) -> Array:
        """(2, n) the cheapest curve that minds nothing but the ends, at the nodes [m]."""
        return self.curves.best @ self.constraints.mesh.basis[0, ::FINER].T

    def guess(self, points: Array) -> Array:
        """Variables of a smooth curve near a way.

        Args:
            points: (2, n) positions at the nodes, seen from the start pose [m].

        Returns:
            (m,) variables.
        """
        c = self.constraints
        return self.curves.nearest(c.mesh.basis[0, ::FINER], points, _CLOSENESS * c.scale.length)


@dataclass(frozen=True, slots=True)
class Attempt:
    """What a search ended with; read-only.

    Attributes:
        task: what was searched.
        w: (m,) variables.
        shares: (r, n) on the fine mesh [1].
        excess: the greatest share less 1 [1].
    """

    task: Task
    w: Array
    shares: Array
    excess: float

    def __post_init__(self) -> None:
        read_only(self.w, self.shares)

    @property
    def keeps(self) -> bool:
        """Whether all constraints are kept, also between the nodes."""
        return self.excess <= EXACT

    @property
    def positions(self) -> Array:
        """(2, n) on the fine mesh, seen from the start pose [m]."""
        basis: Array = self.task.constraints.mesh.basis[0]
        return self.task.curves.curve(self.w) @ basis.T

    @property
    def cost(self) -> float:
        """Cost beyond that of the cheapest curve between the ends [1]."""
        return float(self.w @ self.w)


def prepare(request: PlanRequest, law: TimeLaw, ends: tuple[End, End], length: float) -> Task:
    """The task of a request with its duration decided.

    Args:
        request: as asked.
        law: of the time.
        ends: of the curve, seen from the start pose.
        length: of the way, roughly [m].

    Returns:
        The task.
    """
    resolution = request.resolution
    fine = mesh(law, resolution, FINER * (resolution.nodes - 1) + 1)
    pace = length / float(fine.law[0, -1])
    # a way of that length from rest to rest costs 720 L^2 / T^5
    curves = space(fine, ends, 720.0 * length**2 / law.duration**5)
    scale = Scale(length, pace, _LEAST_PACE * pace)
    return Task(request, law, curves, constraints(fine, curves, request, scale))


def search(task: Task, stages: Iterable[Iterable[Array]]) -> Attempt:
    """The cheapest plan near some ways, passing obstacles on either side.

    Args:
        task: what is searched.
        stages: ways as (2, n) positions at the nodes, which need not be clear; a stage is only
            looked at if the one before has no plan [m].

    Returns:
        The cheapest attempt that keeps the constraints, or else the one that exceeds them least.
    """
    attempts: list[Attempt] = []
    c = task.constraints
    for ways in stages:
        round_obstacles = (r for way in ways for r in [way])
        for guess in sorted(map(task.guess, round_obstacles), key=lambda w: float(w @ w)):
            best = min(attempts, key=_rank, default=None)
            if best and best.keeps and float(guess @ guess) > _HOPELESS * best.cost:
                break
            attempts.append(solve(task, guess))
        if any(attempt.keeps for attempt in attempts):
            break
    return min(attempts, key=_rank)


def _rank(attempt: Attempt) -> tuple[float, float]:
    """Least excess first; among those that keep everything the cheapest."""
    return max(attempt.excess, EXACT), attempt.cost


def solve(task: Task, guess: Array) -> Attempt:
    """The cheapest plan near a guess. Nodes are added where it exceeds a limit between them.

    Args:
        task: what is searched.
        guess: (m,) variables.

    Returns:
        The attempt, whether it keeps the constraints or not.
    """
    attempt = _attempt(task, guess)
    chosen = np.zeros(attempt.shares.shape, dtype=bool)
    chosen[0, ::FINER] = True  # the curve must stay regular
    chosen[task.constraints.distances, ::FINER] = True
    for _ in range(_ROUNDS):
        chosen[:, ::FINER] |= attempt.shares[:, ::FINER] > _NEAR
        chosen |= _peaks(attempt.shares)
        attempt = _attempt(task, _slsqp(task.constraints, chosen, attempt.w))
        if attempt.keeps or float(attempt.shares[chosen].max()) > 1.0:
            break
    return attempt


def _attempt(task: Task, w: Array) -> Attempt:
    shares = np.nan_to_num(task.constraints.shares(w), nan=np.inf)
    return Attempt(task, w, shares, float(shares.max()) - 1.0)


def _peaks(shares: Array) -> NDArray[np.bool_]:
    """(r, n) where a share exceeds 1 and its neighbours."""
    padded = np.pad(shares, ((0, 0), (1, 1)), constant_values=-np.inf)
    top = (shares >= padded[:, :-2]) & (shares >= padded[:, 2:])
    peaks: NDArray[np.bool_] = top & (shares > 1.0)
    return peaks


def _slsqp(fine: Constraints, chosen: NDArray[np.bool_], guess: Array) -> Array:
    """Variables of least cost within the chosen shares, or where SLSQP gave up."""
    times: NDArray[np.bool_] = np.any(chosen, axis=0)
    nodes, rows = fine.only(times), chosen[:, times]
    rows &= np.abs(nodes.jacobian(guess)).max(axis=2) > _FIXED
    reserves = np.where(fine.distances, _PLACE_RESERVE, _RESERVE)
    most = np.broadcast_to(1.0 - reserves[:, None], rows.shape)[rows]
    found = minimize(
        lambda w: (0.5 * w @ w, w),
        guess,
        jac=True,
        method="SLSQP",
        constraints={
            "type": "ineq",
            "fun": lambda w: most - nodes.shares(w)[rows],
            "jac": lambda w: -nodes.jacobian(w)[rows],
        },
        options={"maxiter": _STEPS, "ftol": _PRECISION},
    )
    return np.asarray(found.x)
