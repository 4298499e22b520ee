"""What nobody may wait for: compiled, or loaded from disk, before a robot is connected."""

from control.estimation import load_filter
from pipeline.clearing import rehearse_clearing
from pipeline.compiling import told_of_compiling
from pipeline.config import Scenario
from pipeline.rehearsal import rehearse
from pipeline.seeing import Seeing, make_seeing


def ready_to_look(scenario: Scenario) -> Seeing:
    """What finds the robots, so that its first look need not wait.

    Args:
        scenario: checked scenario.

    Returns:
        The seeing.

    Raises:
        ConfigError: as `make_seeing`.
    """
    seeing = make_seeing(scenario)
    with told_of_compiling("the vision", "up to half a minute"):
        rehearse(seeing.detector)
    return seeing


def ready_to_drive(scenario: Scenario) -> Seeing:
    """The same, and the filters of estimation and clearance, so that no cycle need wait.

    Args:
        scenario: checked scenario.

    Returns:
        The seeing, for `make_setup`.

    Raises:
        ConfigError: as `make_seeing`.
    """
    seeing = ready_to_look(scenario)
    load_filter()
    rehearse_clearing()
    return seeing
