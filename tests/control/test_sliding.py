"""The follower's law: s(0) = s'(0) = 0, the sliding phase (23), saturation, refusals."""

from dataclasses import replace
from math import exp, inf, isfinite, nan, pi

import pytest
from hypothesis import given
from hypothesis import strategies as st

from control.actuation import Actuation, DriveGain
from control.errors import ControlError
from control.formation import ShapeReference
from control.geometry import Pose2D
from control.relative import RelativeRates, RelativeState, relative_rates, relative_state
from control.sliding import (
    FollowerModel,
    FollowerSample,
    SlidingGains,
    begin,
    follower_step,
)
from control.twisting import TwistingGains, implicit_twisting
from control.unicycle import SpeedLimits, Twist, UnicycleState, advance_lagged, advance_pose

GAINS, MODEL = SlidingGains(), FollowerModel()
LIMITS = MODEL.actuation.limits
RELATIVE = st.builds(RelativeState, st.floats(0.0, 3.0), st.floats(-pi, pi), st.floats(-pi, pi))
REFERENCE = st.builds(
    ShapeReference, st.floats(0.1, 1.0), st.floats(-pi, pi), st.floats(-0.5, 0.5), st.floats(-2, 2)
)
RATES = st.builds(RelativeRates, st.floats(-1, 1), st.floats(-5, 5), st.floats(-5, 5))
OWN = st.builds(Twist, st.floats(-1.5, 1.5), st.floats(-15, 15))


@given(RELATIVE, REFERENCE, RATES)
def test_s_and_its_rate_start_at_zero(
    relative: RelativeState, reference: ShapeReference, rates: RelativeRates
) -> None:
    memory = begin(relative, reference, GAINS, rates)
    error_rate = reference.distance_rate - rates.distance, reference.bearing_rate - rates.bearing
    for j in (0, 1):
        e, d, c = memory.error[j], memory.integral[j], memory.double_integral[j]
        k, l = GAINS.proportional[j], GAINS.integral[j]  # noqa: E741 (the paper's L)
        assert abs(e + k * d + l * c) < 1e-12  # (24)
        assert abs(error_rate[j] + k * e + l * d) < 1e-12  # its derivative


@given(RELATIVE, REFERENCE, OWN)
def test_first_step_has_s_zero_and_implicit_twisting_rests(
    relative: RelativeState, reference: ShapeReference, own: Twist
) -> None:
    memory = begin(relative, reference, GAINS)
    wide = FollowerModel(0.05, Actuation(0.05, SpeedLimits(1e4, 1e6), 1e5, 1e7))
    after, _ = follower_step(memory, FollowerSample(relative, own, reference), 0.005, GAINS, wide)
    assert max(map(abs, after.sliding)) < 1e-12
    assert max(map(abs, after.applied)) < 1e-6  # nothing saturates: v = 0
    assert not after.fresh


@given(RELATIVE, REFERENCE, OWN, st.floats(0.001, 0.2), st.sampled_from(["implicit", "sampled"]))
def test_any_finite_input_gives_finite_saturated_commands(
    relative: RelativeState, reference: ShapeReference, own: Twist, dt: float, law: str
) -> None:
    gains = SlidingGains(law=f"{law}-twisting")
    memory = begin(relative, reference, gains)
    for _ in range(3):
        sample = FollowerSample(relative, own, reference)
        memory, command = follower_step(memory, sample, dt, gains, MODEL)
        assert isfinite(command.v)
        assert isfinite(command.omega)
        assert abs(command.v) <= LIMITS.v
        assert abs(command.omega) <= LIMITS.omega


def follow(seconds: float, tick: float, leader: Twist, gain: DriveGain) -> list[tuple[float, ...]]:
    """An ideal follower (no delay, no noise) behind a leader at constant speed: errors over t."""
    reference = ShapeReference(0.2, 3 * pi / 4)
    ahead = Pose2D(0.0, 0.0, 0.0)
    own = UnicycleState(-0.4, 0.05, 0.1, leader.v, 0.0)
    first = relative_state(ahead, own.pose, 0.05)
    memory = begin(first, reference, GAINS, relative_rates(first, leader, own.twist, 0.05))
    rows = []
    for i in range(round(seconds / tick)):
        relative = relative_state(ahead, own.pose, 0.05)
        sample = FollowerSample(relative, own.twist, reference, gain=gain)
        memory, command = follower_step(memory, sample, tick, GAINS, MODEL)
        rows.append((i * tick, *memory.error, *memory.sliding))
        driven = Twist(gain.v * command.v, gain.omega * command.omega)
        own = advance_lagged(own, driven, tick, 0.05)
        ahead = advance_pose(ahead, leader, tick)
    return rows


@pytest.mark.parametrize("gain", [DriveGain(), DriveGain(1.2, 0.8)])
def test_the_sliding_phase_obeys_23(gain: DriveGain) -> None:
    rows = follow(6.0, 0.005, Twist(0.5, 0.0), gain)
    (_, e1, e2, *_), (_, f1, f2, *_) = rows[0], rows[1]
    rates = (f1 - e1) / 0.005, (f2 - e2) / 0.005
    for t, l_error, psi_error, s1, s2 in rows:
        # K = 2, L = 1: a double pole at -1
        assert abs(l_error - (e1 + (e1 + rates[0]) * t) * exp(-t)) < 2e-3  # 2 mm
        assert abs(psi_error - (e2 + (e2 + rates[1]) * t) * exp(-t)) < 2e-2  # 1.2 deg
        assert abs(s1) < 2e-3
        assert abs(s2) < 2e-2


def test_a_turning_leader_is_followed_without_knowing_its_velocity() -> None:
    rows = [row for row in follow(12.0, 0.005, Twist(0.3, 0.5), DriveGain()) if row[0] > 10.0]
    assert max(abs(row[1]) for row in rows) < 1e-3  # m
    assert max(abs(row[2]) for row in rows) < 1e-2  # rad


def test_saturation_does_not_wind_up() -> None:
    reference, relative = ShapeReference(0.2, pi), RelativeState(5.0, pi, 0.0)
    slow = FollowerModel(0.05, Actuation(0.05, SpeedLimits(0.1, 1.0)))
    memory = begin(relative, reference, GAINS)
    memory, _ = follower_step(
        memory, FollowerSample(relative, Twist(0, 0), reference), 0.01, GAINS, slow
    )
    # wanted: -L e = 4.8 m/s^2; the wheels give 0.1 m/s * (1 - exp(-.2)) / 10 ms
    assert memory.acceleration[0] == pytest.approx(0.1 * (1 - exp(-0.2)) / 0.01)
    # s'' = v + K e' + ...: v_applied = L e + h'' - G u, here G = -1
    assert memory.applied[0] == pytest.approx(-4.8 + memory.acceleration[0])


def test_sampled_twisting_has_no_change_at_the_first_sample() -> None:
    gains = SlidingGains(twisting=TwistingGains(20.0, 4.0), law="sampled-twisting")
    relative, reference = RelativeState(0.3, 2.0, 0.1), ShapeReference(0.2, 2.2)
    memory = replace(begin(relative, reference, gains), double_integral=(1.0, 1.0))
    wide = FollowerModel(0.05, Actuation(0.05, SpeedLimits(1e4, 1e6), 1e5, 1e7))
    sample = FollowerSample(relative, Twist(0.1, 0.0), reference)
    memory, _ = follower_step(memory, sample, 0.005, gains, wide)
    assert memory.applied == pytest.approx((-4.0, -4.0))  # -nu sign(s), not -mu


@given(st.floats(-0.01, 0.01), st.floats(-0.01, 0.01), st.floats(-20, 20), st.floats(-20, 20))
def test_rate_of_s_needs_outputs_alone(s0: float, s1: float, v0: float, v1: float) -> None:
    # under s'' = v the rate at the end of a period is its mean change plus dt v / 2
    relative, reference, dt = RelativeState(0.3, 2.0, 0.1), ShapeReference(0.2, 2.2), 0.02
    wide = FollowerModel(0.05, Actuation(0.05, SpeedLimits(1e4, 1e6), 1e5, 1e7))
    old = replace(begin(relative, reference, GAINS), sliding=(s0, s1), applied=(v0, v1))
    sample = FollowerSample(relative, Twist(0.1, 0.0), reference)
    after, _ = follower_step(replace(old, fresh=False), sample, dt, GAINS, wide)
    for j, (before, v) in enumerate(((s0, v0), (s1, v1))):
        s = after.sliding[j]
        rate = (s - before) / dt + 0.5 * dt * v
        wanted = implicit_twisting(s, rate, 0.0, dt, GAINS.twisting)
        assert after.applied[j] == pytest.approx(wanted, abs=1e-6)


def test_known_leader_acceleration_is_fed_forward() -> None:
    relative, reference = RelativeState(0.2, pi, 0.0), ShapeReference(0.2, pi)
    memory = begin(relative, reference, GAINS)
    sample = FollowerSample(relative, Twist(0.5, 0.0), reference, leader_acceleration=(1.0, 0.0))
    after, _ = follower_step(memory, sample, 0.005, GAINS, MODEL)
    assert after.acceleration[0] == pytest.approx(1.0)  # straight behind: the same acceleration


SAMPLE = FollowerSample(RelativeState(0.2, pi, 0.0), Twist(0.1, 0.0), ShapeReference(0.2, pi))


@pytest.mark.parametrize(
    ("sample", "dt", "message"),
    [
        (replace(SAMPLE, relative=RelativeState(nan, 0.0, 0.0)), 0.005, "relative state"),
        (replace(SAMPLE, own=Twist(inf, 0.0)), 0.005, "own velocities"),
        (replace(SAMPLE, own=Twist(inf, -inf)), 0.005, "own velocities"),
        (replace(SAMPLE, reference=ShapeReference(0.2, nan)), 0.005, "reference"),
        (replace(SAMPLE, leader_acceleration=(nan, 0.0)), 0.005, "leader's acceleration"),
        (SAMPLE, 0.0, "dt > 0"),
        (SAMPLE, nan, "dt > 0"),
    ],
)
def test_what_is_refused_before_the_law(sample: FollowerSample, dt: float, message: str) -> None:
    memory = begin(SAMPLE.relative, SAMPLE.reference, GAINS)
    with pytest.raises(ControlError, match=message):
        follower_step(memory, sample, dt, GAINS, MODEL)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: SlidingGains(law="magic"), "no twisting law"),
        (lambda: SlidingGains(proportional=(0.0, 1.0)), "K and L"),
        (lambda: FollowerModel(camera_offset=0.0), "camera offset"),
        (lambda: Actuation(lag=0.0), "motor lag"),
    ],
)
def test_settings_are_checked(make: object, message: str) -> None:
    with pytest.raises(ControlError, match=message):
        make()  # type: ignore[operator]
