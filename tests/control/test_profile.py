"""Time courses: derivatives, no jumps, peaks in closed form, the shorter way round."""

from itertools import pairwise
from math import cos, isclose, pi, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from control.errors import ControlError
from control.profile import KeyFrames, Profile, Step, TanhStep

NAN = float("nan")


@st.composite
def key_frames(draw: st.DrawFn) -> KeyFrames:
    """Up to four transitions, back to back or with rests between them."""
    n = draw(st.integers(1, 4))
    durations = [draw(st.floats(0.1, 3.0)) for _ in range(n)]
    rests = [draw(st.one_of(st.just(0.0), st.floats(0.01, 3.0))) for _ in range(n)]
    begins = [draw(st.floats(-2.0, 5.0))]
    for duration, rest in zip(durations[:-1], rests[:-1], strict=True):
        begins.append(begins[-1] + duration + rest)
    values = [draw(st.floats(-4.0, 4.0)) for _ in range(n + 1)]
    return KeyFrames(tuple(begins), tuple(values), tuple(durations))


STEPS = st.builds(
    TanhStep, st.floats(-2, 2), st.floats(-2, 2), st.floats(0, 10), st.floats(0.1, 20)
)
PROFILES = st.one_of(key_frames(), STEPS)


def span(profile: Profile) -> tuple[float, float, float]:
    """Begin and end of all that happens, and the shortest time in which something does [s]."""
    if isinstance(profile, KeyFrames):
        end = profile.times[-1] + profile.durations[-1]
        return profile.times[0], end, min(profile.durations)
    assert isinstance(profile, TanhStep)
    return profile.t - 5.0 / profile.rate, profile.t + 5.0 / profile.rate, 1.0 / profile.rate


@given(PROFILES, st.floats(-0.1, 1.1))
def test_derivatives_against_finite_differences(profile: Profile, share: float) -> None:
    begin, end, time = span(profile)
    t, h = begin + share * (end - begin), 1e-4 * time
    low, middle, high = (profile.at(t + k * h) for k in (-1, 0, 1))
    size = 8.0 / time  # values differ by 8 at most
    assert abs((high[0] - low[0]) / (2 * h) - middle[1]) < 1e-6 * size
    assert abs((high[1] - low[1]) / (2 * h) - middle[2]) < 1e-2 * size / time


@given(key_frames())
def test_neither_value_nor_rate_nor_acceleration_jumps(frames: KeyFrames) -> None:
    ends = [t + duration for t, duration in zip(frames.times, frames.durations, strict=True)]
    for joint, value in (
        *zip(frames.times, frames.values[:-1], strict=True),
        *zip(ends, frames.values[1:], strict=True),
    ):
        for t in (joint - 1e-8, joint, joint + 1e-8):  # a share of 1e-7 at most
            assert np.allclose(frames.at(t), (value, 0.0, 0.0), rtol=0, atol=[1e-12, 1e-9, 5e-3])


@given(key_frames())
def test_values_are_held_between_and_outside(frames: KeyFrames) -> None:
    assert frames.at(frames.times[0] - 1.0) == (frames.values[0], 0.0, 0.0)
    assert frames.at(frames.times[-1] + frames.durations[-1] + 0.01) == (frames.values[-1], 0, 0)
    for (t, later), duration, value in zip(
        pairwise(frames.times), frames.durations[:-1], frames.values[1:-1], strict=True
    ):
        rest = later - t - duration
        if rest > 1e-6:
            assert frames.at(later - 0.5 * rest) == (value, 0.0, 0.0)


@given(key_frames(), st.integers(0, 3), st.floats(0, 1))
def test_a_transition_stays_between_its_values_and_is_odd_about_its_middle(
    frames: KeyFrames, which: int, s: float
) -> None:
    k = which % len(frames.times)
    before, after = frames.values[k : k + 2]
    t, duration = frames.times[k], frames.durations[k]
    value = frames.at(t + s * duration)[0]
    assert min(before, after) - 1e-12 <= value <= max(before, after) + 1e-12
    mirrored = frames.at(t + (1.0 - s) * duration)[0]
    assert value + mirrored == pytest.approx(before + after, abs=1e-9)


@given(PROFILES)
def test_peaks_are_reached_and_never_exceeded(profile: Profile) -> None:
    if isinstance(profile, KeyFrames):
        moves = zip(profile.times, profile.durations, strict=True)
        times = np.concatenate([np.linspace(t, t + T, 201) for t, T in moves])
    else:
        times = np.linspace(*span(profile)[:2], 401)
    course = np.abs([profile.at(t) for t in times.tolist()])
    for peak, seen in (
        (profile.peak_rate, course[:, 1]),
        (profile.peak_acceleration, course[:, 2]),
    ):
        assert 0.99 * peak <= seen.max() <= peak * (1.0 + 1e-9)


def test_peaks_of_the_paper_s_step() -> None:
    step = TanhStep(0.2, 0.15, 5.5, 10.0)
    assert step.peak_rate == pytest.approx(0.25)  # m/s, as l' at 5.5 s
    assert step.peak_acceleration == pytest.approx(1.925, abs=1e-3)  # m/s^2
    assert TanhStep.constant(0.2).peak_acceleration == KeyFrames((), (0.2,), ()).peak_rate == 0.0


@given(st.lists(st.floats(-pi, pi), min_size=2, max_size=6), st.integers(-3, 3))
def test_bearings_turn_by_the_shorter_way(bearings: list[float], turns: int) -> None:
    n = len(bearings) - 1
    wound = [bearings[0], *(bearing + 2 * pi * turns for bearing in bearings[1:])]
    frames = KeyFrames.turning(range(n), wound, [1.0] * n)
    assert frames.values[0] == bearings[0]
    for before, after in pairwise(frames.values):
        assert abs(after - before) <= pi + 1e-9
    for value, bearing in zip(frames.values, bearings, strict=True):
        assert isclose(cos(value), cos(bearing), abs_tol=1e-9)
        assert isclose(sin(value), sin(bearing), abs_tol=1e-9)


def test_from_behind_left_to_behind_right_passes_behind() -> None:
    frames = KeyFrames.turning((1.0,), (3 * pi / 4, -3 * pi / 4), (2.0,))
    assert frames.at(2.0)[0] == pytest.approx(pi)


def test_only_what_differs_is_a_change() -> None:
    frames = KeyFrames((1.0, 2.0, 4.0), (0.2, 0.3, 0.3, 0.1), (1.0, 1.0, 0.5))
    assert frames.steps == (Step(1.0, 0.2, 0.3), Step(4.0, 0.3, 0.1))
    assert frames.changes == (1.0, 4.0)
    assert TanhStep(0.2, 0.3, 5.5).steps == (Step(5.5, 0.2, 0.3),)
    assert TanhStep.constant(0.2).changes == KeyFrames((), (0.2,), ()).changes == ()


def test_decimal_times_may_follow_each_other_without_rest() -> None:
    KeyFrames((0.1, 0.3), (0.0, 1.0, 2.0), (0.2, 0.1))  # 0.1 + 0.2 > 0.3 in floats


@pytest.mark.parametrize(
    ("times", "values", "durations", "message"),
    [
        ((1.0,), (0.2,), (1.0,), "1 times need 2 values and 1 durations, got 1 and 1"),
        ((1.0,), (0.2, 0.3), (), "got 2 and 0"),
        ((), (), (), "0 times need 1 values"),
        ((1.0,), (0.2, NAN), (1.0,), "not finite: 1, 0.2, nan"),
        ((1.0,), (0.2, 0.3), (0.0,), "must last > 0 s, got 0 s"),
        ((1.0, 2.0), (0.2, 0.3, 0.4), (1.5, 1.0), "at 2 s begins before .* 1 s has ended at 2.5 s"),
        ((2.0, 1.0), (0.2, 0.3, 0.4), (0.1, 0.1), "at 1 s begins before the one at 2 s"),
        ((1.0, 1.0), (0.2, 0.3, 0.4), (1e-12, 0.1), "at 1 s begins before the one at 1 s"),
    ],
)
def test_what_is_refused(
    times: tuple[float, ...], values: tuple[float, ...], durations: tuple[float, ...], message: str
) -> None:
    with pytest.raises(ControlError, match=message):
        KeyFrames(times, values, durations)
