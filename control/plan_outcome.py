"""What comes of a search: a plan with its margins, or which constraint fails, where, how much."""

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


def failure(attempt: Attempt) -> ControlError:
    """Why there is no plan.

    Args:
        attempt: the one that exceeds the constraints least.

    Returns:
        An error that names the worst constraint, where it fails, by how much, and a remedy.
    """
    task, c = attempt.task, attempt.task.constraints
    row, at = np.unravel_index(int(attempt.shares.argmax()), attempt.shares.shape)
    name, share = c.names[row], float(attempt.shares[row, at])
    x, y = on_floor(task.request.start.pose, attempt.positions)[:, at]
    much = f"needs {share:.3g} times its limit"
    if name == "pace":
        much = "falls to nothing: the way turns back on itself"
    if c.distances[row]:
        much = f"lacks {c.scale.length * (share - 1.0):.2g} m"
    return ControlError(
        f"no plan in {task.law.duration:.3g} s: {name} {much} at t = "
        f"{task.request.t_start + c.mesh.t[at]:.3g} s, ({x:.2f}, {y:.2f}) m; {_remedy(name)}"
    )


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
