"""What comes of a search: a plan with its margins, or which constraint fails, where, how much."""

from collections.abc import Sequence

import numpy as np

from control.errors import ControlError
from control.plan_frame import on_floor
from control.plan_search import Attempt
from control.spline_plan import Margin, SplinePlan


def finished(attempt: Attempt) -> SplinePlan:
    """The plan of an attempt, on the floor.

    Args:
        attempt: one that keeps the constraints.

    Returns:
        The plan.
    """
    task, request = attempt.task, attempt.task.request
    points = on_floor(request.start.pose, task.curves.curve(attempt.w)).T
    heading, (shares, gaps) = request.start.theta, _margins(attempt)
    return SplinePlan(points, task.law, request.resolution, heading, request.t_start, shares, gaps)


def failure(tried: Sequence[Attempt]) -> ControlError:
    """Why there is no plan.

    Args:
        tried: all attempts, at least one.

    Returns:
        An error that names the worst constraint of the attempt that exceeds its constraints
        least: where it fails, by how much, and a remedy.
    """
    attempt = min(tried, key=lambda other: other.excess)
    task, c = attempt.task, attempt.task.constraints
    row, at = np.unravel_index(int(attempt.shares.argmax()), attempt.shares.shape)
    x, y = on_floor(task.request.start.pose, attempt.positions)[:, at]
    durations = sorted(other.task.law.duration for other in tried)
    span = f"{durations[0]:.3g} s"
    if len(tried) > 1:
        span += f" to {durations[-1]:.3g} s, at best in {task.law.duration:.3g} s"
    return ControlError(
        f"no plan in {span}: {c.names[row]} {_lack(attempt, int(row), int(at))} at t = "
        f"{task.request.t_start + c.mesh.t[at]:.3g} s, ({x:.2f}, {y:.2f}) m; "
        f"{_remedy(c.names[row])}"
    )


def _lack(attempt: Attempt, row: int, at: int) -> str:
    c, share = attempt.task.constraints, float(attempt.shares[row, at])
    if row == 0:
        return "falls to nothing where the way turns back on itself"
    if c.distances[row]:
        return f"lacks {c.scale.length * (share - 1.0):.2g} m"
    return f"needs {share:.3g} times its limit"


def _remedy(name: str) -> str:
    if "border" in name:
        return "enlarge the arena, use a smaller formation, or give it more time"
    if "obstacle" in name:
        return "give it more time, a smaller formation, or another goal"
    if "follower" in name:
        return "give it more time, or put the followers closer to the leader"
    return "give it more time, or a goal further ahead"


def _margins(attempt: Attempt) -> tuple[tuple[Margin, ...], tuple[Margin, ...]]:
    """The closest approach to each limit, and to each obstacle and border."""
    c = attempt.task.constraints
    closest = attempt.shares.argmax(axis=1)
    times = attempt.task.request.t_start + c.mesh.t[closest]
    shares: dict[str, Margin] = {}
    gaps = []
    for row, name in enumerate(c.names):
        share, t = float(attempt.shares[row, closest[row]]), float(times[row])
        if c.distances[row]:
            gaps.append(Margin(name, c.scale.length * (1.0 - share), t))
        elif row > 0 and (name not in shares or share > shares[name].value):
            shares[name] = Margin(name, share, t)
    return tuple(shares.values()), tuple(gaps)
