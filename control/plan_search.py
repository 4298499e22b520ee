"""The search for a plan in a given time: SLSQP on the nodes, a check between them."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from control.motion_model import Array
from control.plan_problem import FINER, Problem

_WANTED = 1.0 - 1e-3  # shares that SLSQP keeps at the nodes
_MOST = 1.0 - 5e-4  # shares that the check accepts, which looks at finite times as well
_EXACT = 1e-6  # what is beyond by less is rounding
_NEAR = 0.3  # SLSQP minds the limits of which a guess uses so much, and those it then exceeds
_ROUNDS = 6  # of SLSQP, each with the times at which the one before exceeds a limit
_STEPS = 40  # of SLSQP
_PRECISION = 1e-6  # of the cost
_FIXED = 1e-6  # shares that w changes by less are decided by the ends
_CLOSENESS = 0.02  # with which a guess is fitted, over the length of the way
_HOPELESS = 4.0  # a guess that costs so many times the best plan is not followed


@dataclass(frozen=True, slots=True)
class Attempt:
    """What a search ended with.

    Attributes:
        problem: what was searched.
        w: (m,) variables.
        shares: (r, n) on the fine mesh [1].
        excess: by how much a share is more than wanted and more than at both ends, at worst [1].
    """

    problem: Problem
    w: Array
    shares: Array
    excess: float

    @property
    def keeps(self) -> bool:
        """Whether all constraints are kept, also between the nodes."""
        return self.excess <= _EXACT

    @property
    def cost(self) -> float:
        """Cost beyond that of the cheapest curve between the ends [1]."""
        return float(self.w @ self.w)


def search(problem: Problem, ways: Iterable[Array]) -> Attempt:
    """The cheapest plan near some ways.

    Args:
        problem: what is searched.
        ways: at least one, (2, n) positions at the nodes [m].

    Returns:
        The cheapest attempt that keeps the constraints, or else the one that exceeds them least.
    """
    best: Attempt | None = None
    for guess in sorted((_guess(problem, way) for way in ways), key=lambda w: float(w @ w)):
        if best and best.keeps and guess @ guess > _HOPELESS * best.cost:
            break
        attempt = _solve(problem, guess)
        best = min(best or attempt, attempt, key=_rank)
    assert best
    return best


def _rank(attempt: Attempt) -> tuple[float, float]:
    """Least excess first; among those that keep everything the cheapest."""
    return max(attempt.excess, _EXACT), attempt.cost


def _guess(problem: Problem, way: Array) -> Array:
    """Variables of the curve that weighs its distance from a way against its cost."""
    weight = 1.0 / (_CLOSENESS * problem.length * way.shape[1] ** 0.5)
    off = weight * (way - problem.constant[0, :, ::FINER]).ravel()
    reach = weight * problem.linear[0, :, ::FINER].reshape(len(off), -1)
    return np.asarray(np.linalg.solve(reach.T @ reach + np.eye(reach.shape[1]), reach.T @ off))


def _solve(problem: Problem, guess: Array) -> Attempt:
    """The cheapest plan near a guess. Times are added where it exceeds a limit between nodes."""
    attempt = _attempt(problem, guess)
    chosen = np.zeros(attempt.shares.shape, dtype=bool)
    for _ in range(_ROUNDS):
        chosen[:, ::FINER] |= attempt.shares[:, ::FINER] > _NEAR
        chosen |= _peaks(attempt.shares)
        attempt = _attempt(problem, _slsqp(problem, chosen, attempt.w))
        if attempt.keeps or float(attempt.shares[chosen].max()) > _MOST + _EXACT:
            break
    return attempt


def _attempt(problem: Problem, w: Array) -> Attempt:
    shares = np.nan_to_num(problem.shares(w), nan=np.inf)
    most = np.maximum(shares[:, [0, -1]].max(axis=1, keepdims=True), _MOST)
    return Attempt(problem, w, shares, float((shares - most).max()))


def _peaks(shares: Array) -> NDArray[np.bool_]:
    """(r, n) where a share exceeds the most and its neighbours."""
    padded = np.pad(shares, ((0, 0), (1, 1)), constant_values=-np.inf)
    top = (shares >= padded[:, :-2]) & (shares >= padded[:, 2:])
    peaks: NDArray[np.bool_] = top & (shares > _MOST)
    return peaks


def _slsqp(problem: Problem, chosen: NDArray[np.bool_], guess: Array) -> Array:
    """Variables of least cost within the chosen shares, or where SLSQP gave up."""
    times = np.asarray(chosen.any(axis=0))
    at_times, rows = problem.at(times), chosen[:, times]
    rows &= np.abs(at_times.jacobian(guess)).max(axis=2) > _FIXED
    found = scipy.optimize.minimize(
        lambda w: (0.5 * w @ w, w),
        guess,
        jac=True,
        method="SLSQP",
        constraints={
            "type": "ineq",
            "fun": lambda w: _WANTED - at_times.shares(w)[rows],
            "jac": lambda w: -at_times.jacobian(w)[rows],
        },
        options={"maxiter": _STEPS, "ftol": _PRECISION},
    )
    return np.asarray(found.x)
