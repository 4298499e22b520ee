"""Why there is no plan: which constraint fails, where, by how much, and what would help."""

from collections.abc import Sequence

import numpy as np

from control.errors import ControlError
from control.plan_problem import TURNING_BACK
from control.plan_search import Attempt

_REMEDIES = {
    "distance": "give it more time, a smaller formation, or another goal",
    "wheel": "give it more time, or put the followers closer to the leader",
}


def failure(tried: Sequence[Attempt]) -> ControlError:
    """The error of a search that found nothing.

    Args:
        tried: all attempts, at least one.

    Returns:
        One that tells of the attempt that exceeds its constraints least.
    """
    attempt = min(tried, key=lambda other: other.excess)
    problem, shares = attempt.problem, attempt.shares
    row, at = (int(i) for i in np.unravel_index(int(shares.argmax()), shares.shape))
    name, share = problem.names()[row], float(shares[row, at])
    x, y = problem.derivatives(attempt.w)[0, :, at]
    durations = sorted({other.problem.law.duration for other in tried})
    span = f"{durations[0]:.3g} s"
    if len(durations) > 1:
        span += f" to {durations[-1]:.3g} s, at best in {problem.law.duration:.3g} s"
    lack = f"needs {share:.3g} times its limit"
    if name == TURNING_BACK:
        lack = "falls to nothing where the way turns back on itself"
    elif name.startswith("distance"):
        lack = f"lacks {problem.length * (share - 1.0):.2g} m"
    remedy = _REMEDIES.get(name.split()[0], "give it more time, or a goal further ahead")
    t = problem.request.t_start + problem.t[at]
    return ControlError(
        f"no plan in {span}: {name} {lack} at t = {t:.3g} s, ({x:.2f}, {y:.2f}) m; {remedy}"
    )
