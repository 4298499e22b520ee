"""The follower's law: s(0) = s'(0) = 0, the sliding phase (23), saturation, refusals."""

from dataclasses import replace
from math import exp, inf, isfinite, nan, pi

import pytest
from hypothesis import given
from hypothesis import strategies as st

from control.actuation import Actuation, DriveGain
from control.channel import ChannelGains
from control.errors import ControlError
from control.follower import FollowerMemory, FollowerModel, FollowerSample, SlidingGains
from control.formation import ShapeReference
from control.geometry import Pose2D
from control.laws import Law
from control.output import FollowerOutput, LeaderMotion, WantedOutput, pair_output, wanted_output
from control.relative import RelativeState, Vector2, relative_state
from control.sliding import begin, follower_step, overruled
from control.twisting import TwistingGains, implicit_twisting
from control.unicycle import SpeedLimits, Twist, UnicycleState, advance_lagged, advance_pose

GAINS, MODEL = SlidingGains(), FollowerModel()
LIMITS = MODEL.actuation.limits
WIDE = FollowerModel(0.05, Actuation(0.05, SpeedLimits(1e4, 1e6), 1e5, 1e7))  # never saturates
RELATIVE = st.builds(RelativeState, st.floats(0.0, 3.0), st.floats(-pi, pi), st.floats(-pi, pi))
REFERENCE = st.builds(
    ShapeReference, st.floats(0.1, 1.0), st.floats(-pi, pi), st.floats(-0.5, 0.5), st.floats(-2, 2)
)
RATES = st.tuples(st.floats(-1, 1), st.floats(-5, 5))
OWN = st.builds(Twist, st.floats(-1.5, 1.5), st.floats(-15, 15))
STANDING = LeaderMotion(Twist(0.0, 0.0), (0.0, 0.0))
AT_REST = (0.0, 0.0)


def sampled(
    relative: RelativeState, own: Twist, reference: ShapeReference, leader: LeaderMotion = STANDING
) -> FollowerSample:
    """A sample of a pair with the paper's camera offset."""
    return FollowerSample(pair_output(relative, own, leader, 0.05), wanted_output([reference]), own)


def started(
    sample: FollowerSample, gains: SlidingGains = GAINS, rate: Vector2 = AT_REST
) -> FollowerMemory:
    """Memory for a first sample."""
    return begin(sample.output, sample.wanted, rate, gains)


@given(RELATIVE, REFERENCE, RATES)
def test_s_and_its_rate_start_at_zero(
    relative: RelativeState, reference: ShapeReference, rates: Vector2
) -> None:
    memory = started(sampled(relative, Twist(0.0, 0.0), reference), rate=rates)
    error_rate = reference.distance_rate - rates[0], reference.bearing_rate - rates[1]
    channels = (memory.distance, GAINS.distance), (memory.bearing, GAINS.bearing)
    for (channel, gains), rate in zip(channels, error_rate, strict=True):
        e, d, c = channel.error, channel.integral, channel.double_integral
        k, l = gains.proportional, gains.integral  # noqa: E741 (the paper's L)
        assert abs(e + k * d + l * c) < 1e-12  # (24)
        assert abs(rate + k * e + l * d) < 1e-12  # its derivative, and (16)


@given(RELATIVE, REFERENCE, OWN)
def test_first_step_has_s_zero_and_implicit_twisting_rests(
    relative: RelativeState, reference: ShapeReference, own: Twist
) -> None:
    sample = sampled(relative, own, reference)
    after, _ = follower_step(started(sample), sample, 0.005, GAINS, WIDE)
    for channel in (after.distance, after.bearing):
        assert abs(channel.sliding) < 1e-12
        assert abs(channel.applied) < 1e-6  # nothing saturates: v = 0
    assert not after.fresh


@given(RELATIVE, REFERENCE, OWN, st.floats(0.001, 0.2), st.sampled_from(list(Law)))
def test_any_finite_input_gives_finite_saturated_commands(
    relative: RelativeState, reference: ShapeReference, own: Twist, dt: float, law: Law
) -> None:
    gains, sample = SlidingGains(law), sampled(relative, own, reference)
    memory = started(sample, gains)
    for _ in range(3):
        memory, command = follower_step(memory, sample, dt, gains, MODEL)
        assert isfinite(command.v)
        assert isfinite(command.omega)
        assert abs(command.v) <= LIMITS.v
        assert abs(command.omega) <= LIMITS.omega


def follow(
    seconds: float, tick: float, leader: Twist, gain: DriveGain, law: Law = Law.IMPLICIT_TWISTING
) -> list[tuple[float, ...]]:
    """An ideal follower (no delay, no noise) behind a leader at constant speed: errors over t."""
    gains, reference = SlidingGains(law), ShapeReference(0.2, 3 * pi / 4)
    ahead = Pose2D(0.0, 0.0, 0.0)
    own = UnicycleState(-0.4, 0.05, 0.1, leader.v, 0.0)
    memory, rows, motion = None, [], LeaderMotion(leader, AT_REST)
    for i in range(round(seconds / tick)):
        relative = relative_state(ahead, own.pose, 0.05)
        sample = replace(sampled(relative, own.twist, reference, motion), gain=gain)
        memory = memory or started(sample, gains, sample.output.rate)
        memory, command = follower_step(memory, sample, tick, gains, MODEL)
        one, two = memory.distance, memory.bearing
        rows.append((i * tick, one.error, two.error, one.sliding, two.sliding))
        driven = Twist(gain.v * command.v, gain.omega * command.omega)
        own = advance_lagged(own, driven, tick, 0.05)
        ahead = advance_pose(ahead, leader, tick)
    return rows


SMOOTH = [
    Law.IMPLICIT_TWISTING,
    Law.COMPENSATED_TWISTING,
    Law.FIRST_ORDER_IMPLICIT,
    Law.FIRST_ORDER_LAYER,
    Law.SUPER_TWISTING,
]


@pytest.mark.parametrize("gain", [DriveGain(), DriveGain(1.2, 0.8)])
@pytest.mark.parametrize("law", SMOOTH)
def test_the_sliding_phase_obeys_23(gain: DriveGain, law: Law) -> None:
    rows = follow(6.0, 0.005, Twist(0.5, 0.0), gain, law)
    (_, e1, e2, *_), (_, f1, f2, *_) = rows[0], rows[1]
    rates = (f1 - e1) / 0.005, (f2 - e2) / 0.005
    for t, l_error, psi_error, s1, s2 in rows:
        # K = 2, L = 1: a double pole at -1
        assert abs(l_error - (e1 + (e1 + rates[0]) * t) * exp(-t)) < 2e-3  # 2 mm
        assert abs(psi_error - (e2 + (e2 + rates[1]) * t) * exp(-t)) < 2e-2  # 1.2 deg
        assert abs(s1) < 2e-2
        assert abs(s2) < 2e-1


@pytest.mark.parametrize("law", list(Law))
def test_every_law_follows_a_turning_leader(law: Law) -> None:
    tick = 0.002 if law in (Law.SAMPLED_TWISTING, Law.SUBOPTIMAL) else 0.005
    rows = [r for r in follow(12.0, tick, Twist(0.3, 0.5), DriveGain(), law) if r[0] > 10.0]
    assert max(abs(row[1]) for row in rows) < 3e-3  # m
    assert max(abs(row[2]) for row in rows) < 2e-2  # rad


def test_saturation_is_told_to_the_law() -> None:
    reference, relative = ShapeReference(0.2, pi), RelativeState(5.0, pi, 0.0)
    slow = FollowerModel(0.05, Actuation(0.05, SpeedLimits(0.1, 1.0)))
    sample = sampled(relative, Twist(0, 0), reference)
    memory, _ = follower_step(started(sample), sample, 0.01, GAINS, slow)
    # wanted: -L e = 4.8 m/s^2; the wheels give 0.1 m/s * (1 - exp(-.2)) / 10 ms
    assert memory.acceleration[0] == pytest.approx(0.1 * (1 - exp(-0.2)) / 0.01)
    # s'' = v + K e' + ...: v_applied = L e + h'' - G u, here G = -1
    assert memory.distance.applied == pytest.approx(-4.8 + memory.acceleration[0])


@given(RELATIVE, REFERENCE, OWN)
def test_an_overruled_law_is_as_if_its_limits_had_said_so(
    relative: RelativeState, reference: ShapeReference, own: Twist
) -> None:
    sample, slow = sampled(relative, own, reference), SpeedLimits(0.05, 0.2)
    tight = FollowerModel(0.05, Actuation(0.05, slow))
    limited, command = follower_step(started(sample), sample, 0.01, GAINS, tight)
    free, _ = follower_step(started(sample), sample, 0.01, GAINS, MODEL)
    given = MODEL.actuation.acceleration(own, command, 0.01)
    told = overruled(free, sample, given, GAINS)
    assert told.acceleration == pytest.approx(limited.acceleration)
    assert told.distance.applied == pytest.approx(limited.distance.applied, abs=1e-6)
    assert told.bearing.applied == pytest.approx(limited.bearing.applied, abs=1e-6)


def test_sampled_twisting_has_no_change_at_the_first_sample() -> None:
    gains = SlidingGains(Law.SAMPLED_TWISTING)
    sample = sampled(RelativeState(0.3, 2.0, 0.1), Twist(0.1, 0.0), ShapeReference(0.2, 2.2))
    first = started(sample, gains)
    moved = FollowerMemory(
        replace(first.distance, double_integral=1.0), replace(first.bearing, double_integral=1.0)
    )
    memory, _ = follower_step(moved, sample, 0.005, gains, WIDE)
    applied = memory.distance.applied, memory.bearing.applied
    assert applied == pytest.approx((-4.0, -4.0))  # -nu sign(s), not -mu
    memory, _ = follower_step(replace(moved, fresh=False), sample, 0.005, gains, WIDE)
    assert memory.distance.applied == pytest.approx(-20.0)  # s has grown from 0


@given(st.floats(-0.01, 0.01), st.floats(-0.01, 0.01), st.floats(-20, 20), st.floats(-20, 20))
def test_rate_of_s_needs_outputs_alone(s0: float, s1: float, v0: float, v1: float) -> None:
    # under s'' = v the rate at the end of a period is its mean change plus dt v / 2
    dt = 0.02
    sample = sampled(RelativeState(0.3, 2.0, 0.1), Twist(0.1, 0.0), ShapeReference(0.2, 2.2))
    first = started(sample)
    old = FollowerMemory(
        replace(first.distance, sliding=s0, applied=v0),
        replace(first.bearing, sliding=s1, applied=v1),
        fresh=False,
    )
    after, _ = follower_step(old, sample, dt, GAINS, WIDE)
    pairs = (old.distance, after.distance), (old.bearing, after.bearing)
    for before, channel in pairs:
        rate = (channel.sliding - before.sliding) / dt + 0.5 * dt * before.applied
        wanted = implicit_twisting(channel.sliding, rate, 0.0, dt, GAINS.twisting)
        assert channel.applied == pytest.approx(wanted, abs=1e-6)


def test_known_leader_acceleration_is_fed_forward() -> None:
    leader = LeaderMotion(Twist(0.5, 0.0), (1.0, 0.0))
    sample = sampled(RelativeState(0.2, pi, 0.0), Twist(0.5, 0.0), ShapeReference(0.2, pi), leader)
    after, _ = follower_step(started(sample), sample, 0.005, GAINS, MODEL)
    assert after.acceleration[0] == pytest.approx(1.0)  # straight behind: the same acceleration


SAMPLE = sampled(RelativeState(0.2, pi, 0.0), Twist(0.1, 0.0), ShapeReference(0.2, pi))


def with_output(**changes: object) -> FollowerSample:
    """The sample with another output."""
    output: FollowerOutput = replace(SAMPLE.output, **changes)  # type: ignore[arg-type]
    return replace(SAMPLE, output=output)


@pytest.mark.parametrize(
    ("sample", "dt", "message"),
    [
        (with_output(h=(nan, 0.0)), 0.005, "relative configuration"),
        (replace(SAMPLE, own=Twist(inf, 0.0)), 0.005, "velocities"),
        (replace(SAMPLE, own=Twist(inf, -inf)), 0.005, "velocities"),
        (with_output(rate=(nan, 0.0)), 0.005, "velocities"),
        (replace(SAMPLE, wanted=WantedOutput((0.2, nan))), 0.005, "reference"),
        (with_output(push=(nan, 0.0)), 0.005, "leader's acceleration"),
        (SAMPLE, 0.0, "dt > 0"),
        (SAMPLE, nan, "dt > 0"),
    ],
)
def test_what_is_refused_before_the_law(sample: FollowerSample, dt: float, message: str) -> None:
    with pytest.raises(ControlError, match=message):
        follower_step(started(SAMPLE), sample, dt, GAINS, MODEL)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: SlidingGains(distance=ChannelGains(0.0, 1.0)), "K and L"),
        (lambda: FollowerModel(camera_offset=0.0), "camera offset"),
        (lambda: Actuation(lag=0.0), "motor lag"),
        (lambda: TwistingGains(4.0, 20.0), "0 < nu < mu"),
    ],
)
def test_settings_are_checked(make: object, message: str) -> None:
    with pytest.raises(ControlError, match=message):
        make()  # type: ignore[operator]
