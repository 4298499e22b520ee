"""From a setup to a planner."""

from pipeline.planners.aside import Aside
from pipeline.planners.at_once import AtOnce
from pipeline.ports import Planner
from pipeline.setup import Setup


def open_planner(setup: Setup, fast: bool) -> Planner:
    """Make a planner that suits a run.

    Args:
        setup: says whether anything may come into the leader's way.
        fast: whether time stands still while it looks for a way.

    Returns:
        The planner.

    Raises:
        ConfigError: if its process cannot be started.
    """
    return Aside() if setup.worn and not fast else AtOnce()
