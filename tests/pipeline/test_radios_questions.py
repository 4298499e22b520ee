"""Round trips: what was asked is answered or given up, and nothing else counts."""

from hypothesis import given
from hypothesis import strategies as st

from pipeline.radios.questions import PATIENCE, PERIOD, Questions


def test_median_longest_and_loss() -> None:
    questions = Questions()
    for n, took in enumerate((0.010, 0.450, 0.020, None, 0.030)):
        t = n * PERIOD
        assert questions.due(t)
        questions.asked(t)
        assert not questions.due(t + 0.45)
        if took is not None:
            questions.answered(t + took)
    assert questions.tally.asked == 5
    assert questions.tally.unanswered == 1
    assert questions.tally.loss == 0.2
    assert round(questions.tally.p50 or 0.0, 9) == 0.025  # s
    assert round(questions.tally.longest or 0.0, 9) == 0.45  # s


def test_before_the_first_answer_nothing_is_known() -> None:
    tally = Questions().tally
    assert (tally.asked, tally.loss, tally.p50, tally.longest) == (0, None, None, None)


def asked(questions: Questions, t: float) -> None:
    assert questions.due(t)
    questions.asked(t)


def test_a_robot_that_answered_and_misses_two_questions_in_a_row_is_silent() -> None:
    questions = Questions()
    asked(questions, 0.0)
    questions.answered(0.01)
    for n, answers in enumerate((False, True, False, False)):  # one by one, within 0.5 s
        asked(questions, PERIOD + n * PATIENCE)
        assert not questions.silent
        if answers:
            questions.answered(PERIOD + n * PATIENCE + 0.01)
            questions.ask_soon()
    assert questions.due(PERIOD + 4 * PATIENCE)
    assert questions.silent
    questions.answered(10.0)  # late, but alive
    assert not questions.silent


def test_a_robot_that_never_answers_is_not_silent_and_a_new_link_begins_anew() -> None:
    questions = Questions()
    for n in range(5):
        asked(questions, n * PERIOD)
    assert not questions.silent
    questions.answered(4.1)
    for n in range(5, 8):
        asked(questions, n * PERIOD)
    assert questions.silent
    questions.dropped()
    assert not questions.silent


@given(st.lists(st.tuples(st.sampled_from("qadn"), st.floats(0.0, 0.7)), max_size=60))
def test_every_question_has_one_outcome(
    events: list[tuple[str, float]],
) -> None:
    questions, t, sent, answered = Questions(), 0.0, 0, 0
    out: float | None = None
    for kind, wait in events:
        t += wait
        if kind == "q" and questions.due(t):
            questions.asked(t)
            sent, out = sent + 1, t
        elif kind == "a":
            answered, out = answered + (out is not None), None
            questions.answered(t)
        elif kind == "d":
            questions.dropped()
            out = None
    tally = questions.tally
    assert tally.asked - tally.unanswered == answered
    assert sent - 1 <= tally.asked <= sent
    assert (tally.longest is None) == (answered == 0)
