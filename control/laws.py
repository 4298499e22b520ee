"""The followers' laws by name, what each needs to know, and the leader's laws."""

from enum import IntEnum

from control.compilable import compilable
from control.errors import ControlError


class Named(IntEnum):
    """Laws that scenarios call by their names."""

    @property
    def title(self) -> str:
        """The law's name in scenarios, e.g. "implicit-twisting"."""
        return self.name.lower().replace("_", "-")


class Law(Named):
    """A follower's law. The second-order ones need the relative configuration alone (Assumption 4);
    the first-order ones also the velocities of the leader (Assumption 2)."""

    IMPLICIT_TWISTING = 0
    COMPENSATED_TWISTING = 1
    SAMPLED_TWISTING = 2
    SUBOPTIMAL = 3
    FIRST_ORDER_SIGN = 4
    FIRST_ORDER_LAYER = 5
    FIRST_ORDER_IMPLICIT = 6
    SUPER_TWISTING = 7


class LeaderLaw(Named):
    """The law of the formation's leader: the paper's, and two of its literature."""

    SLIDING = 0
    SATURATED = 1
    LINEARISING = 2


LAW_NAMES: tuple[str, ...] = tuple(law.title for law in Law)
"""Names of the followers' laws, the default first."""

LEADER_LAW_NAMES: tuple[str, ...] = tuple(law.title for law in LeaderLaw)
"""Names of the leader's laws, the default first."""


@compilable
def is_first_order(law: Law) -> bool:
    """Whether a law makes a sliding mode of first order, equation (16), and needs velocities.

    Args:
        law: a follower's law.

    Returns:
        False for the laws on (24), which need the relative configuration alone.
    """
    return law >= Law.FIRST_ORDER_SIGN


@compilable
def remembers(law: Law) -> bool:
    """Whether a law's own memory takes it for granted that its v was applied.

    Args:
        law: a follower's law.

    Returns:
        True for those that switch by the course of s, or integrate its sign.
    """
    return law == Law.SAMPLED_TWISTING or law == Law.SUBOPTIMAL or law == Law.SUPER_TWISTING


def law_named(name: str) -> Law:
    """Find a law by its name.

    Args:
        name: one of LAW_NAMES.

    Returns:
        The law.

    Raises:
        ControlError: if there is no law of that name.
    """
    return Law(_index(name, LAW_NAMES))


def leader_law_named(name: str) -> LeaderLaw:
    """Find a law of the leader by its name.

    Args:
        name: one of LEADER_LAW_NAMES.

    Returns:
        The law.

    Raises:
        ControlError: if there is no law of that name.
    """
    return LeaderLaw(_index(name, LEADER_LAW_NAMES))


def _index(name: str, names: tuple[str, ...]) -> int:
    if name not in names:
        raise ControlError(f"no law {name!r}; there are: {', '.join(names)}")
    return names.index(name)
