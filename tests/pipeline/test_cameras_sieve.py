"""What is news of a camera, and how it is counted: pure, whatever comes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from datasets.cycle import Tick
from pipeline.cameras.outages import Outages
from pipeline.cameras.report import CameraReport, told
from pipeline.cameras.sieve import Repeats, Sieve, Verdict
from pipeline.cameras.tally import Tally
from pipeline.tracking import without_nonsense
from vision.frame import Frame, as_frame, is_repeated

PICTURES = [np.full((4, 6, 3), level, np.uint8) for level in range(3)]
STILL, OTHER = PICTURES[:2]


def frame(image: np.ndarray, t: float, surely_new: bool = False) -> Frame:
    return as_frame(image.copy(), t, 0, surely_new=surely_new)


def verdicts(
    repeats: Repeats, *pictures: tuple[np.ndarray, float, float | None]
) -> tuple[Verdict, ...]:
    sieve = Sieve(repeats)
    return tuple(
        sieve.judge(frame(image, t, sieve.vouches(stamp)), stamp) for image, t, stamp in pictures
    )


NEW, DUPLICATE, LATE = Verdict.NEW, Verdict.DUPLICATE, Verdict.LATE


@pytest.mark.parametrize(
    ("repeats", "stamps", "expected"),
    [
        ("pixels", (None, None), DUPLICATE),
        ("pixels", (7.0, 7.1), DUPLICATE),  # a frozen camera may well go on counting
        ("stamps", (None, None), DUPLICATE),  # without stamps only pixels can tell
        ("stamps", (7.0, 7.1), NEW),
        ("stamps", (7.0, 7.0), DUPLICATE),
        ("stamps", (7.0, 6.9), DUPLICATE),
    ],
)
def test_the_same_pixels_again(
    repeats: Repeats, stamps: tuple[float | None, float | None], expected: Verdict
) -> None:
    one, two = stamps
    assert verdicts(repeats, (STILL, 0.1, one), (STILL, 0.2, two)) == (NEW, expected)


@pytest.mark.parametrize("repeats", ["pixels", "stamps"])
def test_the_same_stamp_again_is_the_same_picture_however_it_was_decoded(repeats: Repeats) -> None:
    assert verdicts(repeats, (STILL, 0.1, 7.0), (OTHER, 0.2, 7.0)) == (NEW, DUPLICATE)


def test_a_restarted_camera_may_use_its_stamps_again() -> None:
    sieve = Sieve()
    assert sieve.judge(frame(STILL, 0.1), 0.0) is NEW
    sieve.restart()
    assert sieve.judge(frame(OTHER, 0.2), 0.0) is NEW
    assert sieve.judge(frame(STILL, 0.15), 0.1) is LATE


@given(
    st.lists(st.tuples(st.integers(0, 2), st.floats(0.0, 1.0), st.none() | st.floats(0.0, 1.0))),
    st.sampled_from(["pixels", "stamps"]),
)
def test_what_is_new_is_later_than_all_before_and_looks_so_to_the_step(
    pictures: list[tuple[int, float, float | None]], repeats: Repeats
) -> None:
    sieve, kept = Sieve(repeats), list[Frame]()
    for number, t, stamp in pictures:
        one = frame(PICTURES[number], t, sieve.vouches(stamp))
        if sieve.judge(one, stamp) is NEW:
            assert not kept or one.t_capture > kept[-1].t_capture
            assert not kept or without_nonsense(Tick(t, one), kept[-1]).frame is one
            kept.append(one)
    assert bool(kept) == bool(pictures)


@pytest.mark.parametrize("size", [(4, 6), (3, 5), (240, 320)])  # of 72, 45 and 230,400 bytes
def test_one_pixel_makes_a_picture_another(size: tuple[int, int]) -> None:
    image = np.random.default_rng(1).integers(0, 255, (*size, 3), np.uint8)
    before = frame(image, 0.0)
    assert is_repeated(frame(image, 0.1), before)
    assert not is_repeated(frame(image, 0.1, surely_new=True), before)
    for row, column in ((0, 0), (size[0] - 1, size[1] - 1), (size[0] // 2, 1)):
        changed = image.copy()
        changed[row, column, 1] ^= 1
        assert not is_repeated(frame(changed, 0.1), before)


@given(st.integers(2, 60), st.floats(0.01, 0.2), st.floats(0.0, 100.0))
def test_the_rate_is_of_the_time_the_camera_was_there(n: int, period: float, away: float) -> None:
    tally, t = Tally(30.0), 0.0
    for _ in range(2):
        for k in range(n):
            tally.receive(t + k * period - 0.02, t + k * period)
        t += n * period + away
        tally.interrupt()
    report = tally.report
    assert report.frames == 2 * n
    assert report.fps == pytest.approx(1.0 / period)
    assert report.delay_p50 == pytest.approx(0.02)
    assert report.delay_p99 == pytest.approx(0.02)


def test_a_slow_rate_is_told_once_until_the_camera_was_away() -> None:
    tally, told_at = Tally(30.0), list[int]()
    for n in range(200):
        tally.receive(0.1 * n, 0.1 * n)
        told_at += [n] if tally.slow_rate() is not None else []
        if n == 100:
            tally.interrupt()
    assert told_at == [30, 131]


@pytest.mark.parametrize(("asked", "period"), [(30.0, 1 / 28.0), (None, 1.0), (30.0, 1 / 60.0)])
def test_a_rate_as_asked_is_not_told(asked: float | None, period: float) -> None:
    tally = Tally(asked)
    for n in range(500):
        tally.receive(period * n, period * n)
        assert tally.slow_rate() is None


def test_nothing_counted_nothing_told() -> None:
    assert tuple(told(Tally(30.0).report)) == ()
    all_wrong = CameraReport(9, 1, 2, 3, 4, 15.0, 30.0)
    assert [line.partition(" frames")[0] for line in told(all_wrong)] == [
        "camera: 1", "camera: 2", "camera: 3", "camera: it was lost and came back 4 times",
    ]  # fmt: skip


def test_an_outage_is_told_once_and_has_an_end() -> None:
    outages = Outages("x")
    assert not outages.away
    assert outages.lose("camera x: gone", 1.0) == "camera x: gone; it is opened again"
    assert outages.lose("camera x: gone", 1.5) is None
    assert outages.lose("camera x: refused", 2.0) is not None
    assert outages.end(3.5) == "camera x: back after 2.5 s"
    assert (len(outages.all), outages.all[0].t_lost, outages.all[0].t_back) == (1, 1.0, 3.5)
    assert outages.lose("camera x: refused", 4.0) is not None
    assert outages.away


def test_a_picture_of_the_future_is_none_to_the_loop() -> None:
    image = np.zeros((4, 6, 3), np.uint8)
    for ahead, kept in ((-0.3, True), (0.0, True), (0.005, True), (0.02, False), (5.0, False)):
        tick = Tick(10.0, as_frame(image, 10.0 + ahead, 1))
        assert (without_nonsense(tick, None).frame is not None) is kept
