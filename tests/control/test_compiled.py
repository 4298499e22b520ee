"""One source, two ways to run: machine code gives what Python gives."""

from dataclasses import dataclass
from math import pi

import pytest
from hypothesis import given
from hypothesis import strategies as st

from control.actuation import DriveGain
from control.errors import ControlError
from control.follower import FollowerMemory, FollowerModel, FollowerSample, SlidingGains
from control.laws import Law
from control.output import LeaderMotion, WantedOutput, pair_output
from control.relative import RelativeState
from control.sliding import begin, follow
from control.unicycle import SpeedLimits, Twist
from control.value import value
from vision.compiled import compiled

MODEL, LEADER, WANTED = FollowerModel(), LeaderMotion(Twist(0.4, 0.6), (0.2, 0.1)), (0.25, 2.5)
ANGLE, SPEED = st.floats(-pi, pi), st.floats(-1.5, 1.5)


def three_steps(
    relative: RelativeState, own: Twist, gains: SlidingGains, model: FollowerModel,
    leader: LeaderMotion, wanted: WantedOutput, gain: DriveGain,
) -> tuple[FollowerMemory, Twist]:  # fmt: skip
    """A law over three samples between which nothing moves."""
    output = pair_output(relative, own, leader, model.camera_offset)
    sample = FollowerSample(output, wanted, own, gain)
    memory = begin(output, wanted, (0.0, 0.0), gains)
    command = own
    for _ in range(3):
        memory, command = follow(memory, sample, 0.01, gains, model)
    return memory, command


fast = compiled(three_steps)


@given(st.sampled_from(list(Law)), st.floats(0.1, 2.0), ANGLE, ANGLE, SPEED, SPEED)
def test_machine_code_gives_what_python_gives(
    law: Law, distance: float, bearing: float, heading: float, v: float, omega: float
) -> None:
    given_ = (
        RelativeState(distance, bearing, heading), Twist(v, omega), SlidingGains(law), MODEL,
        LEADER, WantedOutput(WANTED), DriveGain(),
    )  # fmt: skip
    (slow_memory, slow), (quick_memory, quick) = three_steps(*given_), fast(*given_)
    assert quick.v == pytest.approx(slow.v, rel=1e-9, abs=1e-9)
    assert quick.omega == pytest.approx(slow.omega, rel=1e-9, abs=1e-9)
    for name in ("error", "sliding", "applied", "own"):
        slow_one, quick_one = (getattr(m.bearing, name) for m in (slow_memory, quick_memory))
        assert quick_one == pytest.approx(slow_one, rel=1e-9, abs=1e-9)


def test_checks_hold_where_values_come_back_to_python() -> None:
    assert compiled(twice)(SpeedLimits(1.0, 2.0)) == SpeedLimits(2.0, 2.0)


def twice(limits: SpeedLimits) -> SpeedLimits:
    """Limits with twice the speed."""
    return SpeedLimits(2.0 * limits.v, limits.omega)


def test_a_field_without_machine_code_is_named() -> None:
    @value
    @dataclass(frozen=True, slots=True)
    class Odd:
        names: dict[str, int]

    with pytest.raises(ControlError, match=r"no machine code for a field of type dict"):
        compiled(_first)(Odd({}))


def _first(anything: object) -> object:
    return anything
