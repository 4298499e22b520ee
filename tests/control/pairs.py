"""Pairs for the tests of certificates: random motions, and one whose certificate holds."""

from math import pi

from hypothesis import strategies as st

from control.disturbance import AS_PUBLISHED, DEFAULT_DESIGN, FIRST_ORDER, Compensation
from control.gains import error_dynamics, nominal_extremes
from control.sliding import SlidingGains
from control.uncertainty import FollowerBounds, LeaderBounds, Motion, ReferenceBounds

GAINS = SlidingGains()  # the paper's: K = 2 1/s, L = 1 1/s^2, mu = 20, nu = 4
DYNAMICS = error_dynamics(GAINS)
KNOWN_LEADER = Compensation(own_velocities=True, leader_acceleration=True)
COMPENSATIONS = [AS_PUBLISHED, DEFAULT_DESIGN, KNOWN_LEADER, FIRST_ORDER]
LEFT = 0.75 * pi
SLOW = LeaderBounds(0.3, 0.3, 0.1, 0.3)


def some(high: float) -> st.SearchStrategy[float]:
    """A bound that may be 0."""
    return st.just(0.0) | st.floats(0.0, high)


@st.composite
def motions(draw: st.DrawFn) -> Motion:
    """Motions with errors of either sign, narrow and wide ranges of phi."""
    low, psi, phi = draw(st.floats(0.15, 1.0)), draw(st.floats(-pi, pi)), draw(st.floats(-3, 3))
    error = draw(st.floats(-0.3, 0.7)) * low, draw(st.floats(-1.0, 1.0))
    reference = ReferenceBounds(
        (low, low + draw(some(0.2))),
        (psi, psi + draw(some(0.5))),
        *(draw(some(high)) for high in (0.3, 0.5, 2.0, 2.0)),
    )
    follower = FollowerBounds(
        draw(st.floats(0.03, 0.2)), *(draw(some(high)) for high in (0.25, 0.25, 0.3, 1.0))
    )
    leader = LeaderBounds(*(draw(some(high)) for high in (1.0, 2.0, 1.0, 3.0)))
    heading = (phi, phi + draw(st.floats(0.1, 2.0))) if draw(st.booleans()) else (-pi, pi)
    return Motion(leader, reference, follower, nominal_extremes(GAINS, error), heading)


def wide(leader: LeaderBounds, error: tuple[float, float] = (0.1, 0.3)) -> Motion:
    """A pair 60 cm apart whose model is right within 5 %."""
    reference, follower = (
        ReferenceBounds((0.6, 0.6), (LEFT, LEFT)),
        FollowerBounds(0.05, 0.05, 0.05),
    )
    return Motion(leader, reference, follower, nominal_extremes(GAINS, error))
