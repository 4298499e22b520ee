"""What a run asks of the planner while it drives, and what it is answered."""

from dataclasses import dataclass

from control.errors import ControlError
from control.plan_request import PlanRequest
from control.planner import plan, replan
from control.spline_plan import SplinePlan


@dataclass(frozen=True, slots=True)
class Question:
    """A way that is wanted.

    Attributes:
        request: with the obstacles as they will be at its t_start.
        old: the plan to go on from at t_start; None: the leader stands at the request's start.
    """

    request: PlanRequest
    old: SplinePlan | None


@dataclass(frozen=True, slots=True)
class Answer:
    """What the planner found.

    Attributes:
        t_start: of the request, on the mission's clock [s].
        clearance: of the request [m].
        plan: the way, None if there is none.
        reason: why there is none.
    """

    t_start: float
    clearance: float
    plan: SplinePlan | None
    reason: str = ""


def answered(question: Question) -> Answer:
    """Look for the way.

    Args:
        question: what is wanted.

    Returns:
        The plan, or why there is none.
    """
    request, old = question.request, question.old
    try:
        found = plan(request) if old is None else replan(old, request.t_start, request)
    except ControlError as error:
        return Answer(request.t_start, request.clearance, None, str(error))
    return Answer(request.t_start, request.clearance, found)
