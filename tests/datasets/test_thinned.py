"""Long runs in bounded memory: what is kept is even in time, and the newest is near."""

import tracemalloc

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from control.unicycle import UnicycleState
from datasets.bodies import least_gap, pair_gaps
from datasets.cycle import Cycle, Moment, RobotState, Tick, Timing
from datasets.thinned import Thinned
from datasets.truth import Scores
from tests.datasets.test_scores import CAMERA, FORMATION, D, seen


@given(st.integers(0, 500), st.sampled_from((2, 10, 64)), st.integers(1, 3))
def test_rows_are_kept_evenly(count: int, most: int, columns: int) -> None:
    rows, kept = np.arange(count * columns, dtype=float).reshape(count, columns), None
    kept = Thinned(columns, most)
    for row in rows.tolist():
        kept.add(row)
    table = kept.table()
    assert len(table) < most
    stride = next(s for s in (2**k for k in range(10)) if -(-count // s) < most)
    np.testing.assert_array_equal(table, rows[::stride])


@given(
    st.lists(st.tuples(*[st.floats(-0.3, 0.3)] * 2, st.floats(-4.0, 4.0)), min_size=1, max_size=6),
    st.floats(-0.1, 0.2),
)
def test_the_least_gap_is_that_of_all_pairs(
    poses: list[tuple[float, float, float]], below: float
) -> None:
    table, sides = np.array(poses), np.full(len(poses), 0.075)
    every = pair_gaps(table, sides).min(initial=np.inf)
    assert least_gap(poses, 0.075) == every
    assert least_gap(poses, 0.075, below) == min(below, every)
    assert least_gap([*poses, (np.nan,) * 3], 0.075) == every


def test_scores_of_a_run_that_goes_on_and_on_take_no_more_memory() -> None:
    scores = Scores(FORMATION, D, CAMERA, 0.075)

    def go_on(first: int, last: int) -> int:
        for k in range(first, last):
            t = 0.01 * k
            state = UnicycleState(0.1 * np.sin(t), 0.0, 0.0, 0.1 * np.cos(t), 0.0)
            true = RobotState(1, state), RobotState(2, UnicycleState(-0.3, 0.0, 0.0, 0.0, 0.0))
            scene = seen(true, t, 0.0) if k % 3 == 0 else None
            cycle = Cycle(t, t, "running", 0.0, scene, true, (), None, ())
            scores.observe(Moment(Tick(t), cycle, true, Timing(0.0, 0.0, 0.0)))
        return tracemalloc.get_traced_memory()[0]

    tracemalloc.start()
    try:
        at_first, later = go_on(0, 1_000), go_on(1_000, 6_000)
    finally:
        tracemalloc.stop()
    a_row = 8 * (3 + 4 + 2 * 2 * 5)
    assert later - at_first < 1.2 * 5_000 * (a_row + 3 * 8 / 3) + 50_000  # numbers alone
    vision = scores.result("test", 1.0).vision
    assert vision is not None
    assert (vision.recall, vision.false_ids) == (1.0, 0)
