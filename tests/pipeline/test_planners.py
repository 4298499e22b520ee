"""Planners: one that is waited for, and one in a process of its own, which may die or be left."""

import json
import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from time import monotonic, sleep

import numpy as np
import pytest

from control.geometry import Pose2D
from control.obstacles import Obstacle
from control.replanning import Answer, Question, answered
from pipeline.planners.aside import Aside
from tests.pipeline.commands import echelon_process
from tests.pipeline.test_route import setup


@contextmanager
def planner() -> Iterator[Aside]:
    aside = Aside()
    try:
        yield aside
    finally:
        aside.close()
        aside.close()


def waited(aside: Aside) -> Answer:
    end = monotonic() + 20.0
    while (answer := aside.answer()) is None:
        assert monotonic() < end
        sleep(0.005)
    return answer


def question(y: float = 0.0) -> Question:
    errand = setup().errand
    assert errand
    return Question(replace(errand, obstacles=(Obstacle(0.8, y, 0.1),)), None)


def test_a_planner_aside_answers_as_one_that_is_waited_for() -> None:
    with planner() as aside:
        assert aside.answer() is None
        beside = question(0.03)  # one way is shorter than the other
        aside.ask(beside)
        there, here = waited(aside), answered(beside)
        assert there.plan
        assert here.plan
        np.testing.assert_allclose(there.plan.control_points, here.plan.control_points, atol=1e-3)
        impossible = replace(question().request, goal=Pose2D(0.8, 0.0, 0.0))
        aside.ask(Question(impossible, None))
        assert "too close to the obstacle" in waited(aside).reason


def test_a_planner_whose_process_has_died_says_so_and_nothing_waits() -> None:
    with planner() as aside:
        aside._process.kill()
        aside._process.join()
        aside.ask(question())
        aside.ask(question())
        assert "process has ended" in waited(aside).reason
        assert aside.answer() is None


def test_a_planner_leaves_ctrl_c_to_the_run() -> None:
    with planner() as aside:
        assert aside._process.pid
        os.kill(aside._process.pid, signal.SIGINT)
        aside.ask(question())
        assert waited(aside).plan


def test_a_planner_ends_with_its_run() -> None:
    with planner() as aside:
        process = aside._process
        aside.ask(question())
    assert not process.is_alive()


@pytest.mark.realtime
def test_a_live_run_drives_on_while_a_process_looks_for_another_way(tmp_path: Path) -> None:
    done = echelon_process(
        "live", "crossing", "--duration", 3, "--json", "--record", tmp_path / "s.mcap"
    )
    assert done.returncode == 0, done.stderr
    assert any(note.startswith("another way from") for note in json.loads(done.stdout)["notes"])
    again = echelon_process("replay", tmp_path / "s.mcap", "--compare", "--json")
    assert json.loads(again.stdout)["commands_equal"]
