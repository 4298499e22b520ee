"""Courses for the tests of certificates: one moment of a pair, drawn at random, and a slow pair."""

from math import pi

import numpy as np
from hypothesis import strategies as st

from control.channel import ChannelGains
from control.course import Motion, PairCourse, pair_course
from control.demands import Reach
from control.follower import SlidingGains
from control.formation import ShapeReference
from control.laws import Law
from control.reaching import ReachingGains
from control.twisting import TwistingGains

GAINS = SlidingGains(distance=ChannelGains(2.0, 1.0), bearing=ChannelGains(3.0, 2.0))
LEFT = 0.75 * pi


def some(high: float) -> st.SearchStrategy[float]:
    """A number that may be 0."""
    return st.just(0.0) | st.floats(-high, high)


@st.composite
def moments(draw: st.DrawFn) -> tuple[PairCourse, Reach]:
    """One moment (twice), and errors about it that keep away from the leader."""
    distance, bearing = draw(st.floats(0.3, 1.0)), draw(st.floats(-pi, pi))
    wanted = np.array([(distance, bearing), *[(draw(some(h)), draw(some(h))) for h in (0.3, 2.0)]])
    error = np.array(
        [(draw(some(0.1)), draw(some(0.5))), (draw(some(0.2)), draw(some(0.5))), (0, 0)]
    )
    twist = np.array([draw(some(1.0)), draw(some(2.0))])
    pushed = np.array([draw(some(1.0)), draw(some(3.0))])
    reach = (
        (abs(draw(some(0.12))), abs(draw(some(1.0)))),
        (abs(draw(some(0.2))), abs(draw(some(0.5)))),
    )
    leader = Motion(_twice(twist), _twice(pushed))
    return PairCourse(np.array([0.0, 0.01]), leader, _twice(wanted), _twice(error)), reach


def still(
    bearing: float = LEFT, leader: tuple[float, ...] = (0.0,) * 4, bearing_rate: float = 0.0
) -> PairCourse:
    """One moment (twice) of a pair in its place, 0.5 m behind a leader's twist and acceleration."""
    nothing = _twice(np.zeros((3, 2)))
    wanted = _twice(np.array([(0.5, bearing), (0.0, bearing_rate), (0.0, 0.0)]))
    motion = _twice(np.array(leader))
    return PairCourse(np.array([0.0, 0.01]), Motion(motion[:2], motion[2:]), wanted, nothing)


def slow_pair(
    model_error: float, law: Law = Law.IMPLICIT_TWISTING, mu: float = 20.0, nu: float = 4.0
) -> tuple[PairCourse, SlidingGains]:
    """A pair 0.5 m apart behind a leader that gathers 0.3 m/s and 0.3 rad/s in 3 s."""
    times = np.arange(0.0, 4.0, 0.01)
    ramp, rates = np.minimum(times / 3.0, 1.0), np.where(times < 3.0, 0.1, 0.0)
    leader = Motion(np.stack((0.3 * ramp, 0.3 * ramp)), np.stack((rates, rates)))
    reaching = ReachingGains(model_error=model_error, disturbance=(0.05, 0.5))
    gains = SlidingGains(law, twisting=TwistingGains(mu, nu), reaching=reaching)
    shape = [ShapeReference(0.5, LEFT)] * len(times)
    return pair_course(times, leader, shape, ((0.1, 0.3), (0.0, 0.0)), gains), gains


def _twice(values: np.ndarray) -> np.ndarray:
    return np.stack((values, values), axis=-1)
