"""Carried and look-alike robots in the closed loop: rendered frames in, tracks and notes out."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from control.unicycle import UnicycleState
from datasets.cycle import Cycle, RobotState, Tick
from pipeline.filming import make_renderer
from pipeline.memory import Memory
from pipeline.scenario import load_scenario, scenario_path
from pipeline.setup import Setup, make_setup
from pipeline.step import step
from vision.frame import as_frame

PLACES = {1: (0.3, 0.3, 0.4), 2: (0.8, 0.6, 2.0), 3: (0.5, 0.9, -1.0)}
Places = dict[int, tuple[float, float, float]]


class Stage:
    """Robots that stand, are carried or covered by hand, and the steps that watch them."""

    def __init__(self, scenario: str, overrides: tuple[str, ...] = ()) -> None:
        loaded = load_scenario(scenario, overrides)
        self.setup: Setup = make_setup(loaded)
        self._renderer = make_renderer(loaded)
        self.memory, self.t, self.notes = Memory(), 0.0, []  # type: tuple[Memory, float, list[str]]

    def watch(self, places: Places, frames: int = 1) -> Cycle:
        """Some frames of robots at places."""
        states = tuple(RobotState(r, UnicycleState(*p, 0.0, 0.0)) for r, p in places.items())
        for _ in range(frames):
            self.t += 1.0 / 30.0
            image = self._renderer.render(states, self.t)
            frame = as_frame(image, self.t, round(30 * self.t))
            self.memory, cycle = step(self.setup, self.memory, Tick(self.t, frame))
            self.notes += cycle.notes
        return cycle

    def error_mm(self, robot: int, place: tuple[float, float, float]) -> float:
        """How far a robot's track is from a place."""
        state = self.memory.tracks[robot].estimate.state
        return 1e3 * float(np.hypot(state.x - place[0], state.y - place[1]))


def test_a_carried_robot_is_taken_up_within_three_frames() -> None:
    stage = Stage("paper")
    stage.watch(PLACES, 10)
    moved = {**PLACES, 2: (0.2, 0.7, -2.5)}
    stage.watch(moved, 3)
    for robot, place in moved.items():
        assert stage.error_mm(robot, place) < 5.0


def test_two_swapped_by_hand_keep_their_ids() -> None:
    stage = Stage("paper")
    stage.watch(PLACES, 10)
    moved = {1: PLACES[1], 2: PLACES[3], 3: PLACES[2]}
    stage.watch(moved, 3)
    for robot, place in moved.items():
        assert stage.error_mm(robot, place) < 5.0


def test_one_odd_frame_moves_no_track() -> None:
    stage = Stage("paper")
    stage.watch(PLACES, 10)
    stage.watch({**PLACES, 2: (0.2, 0.7, -2.5)}, 1)
    assert stage.error_mm(2, PLACES[2]) < 5.0


@pytest.fixture
def alike(tmp_path: Path) -> str:
    """The paper's scenario, with robots 2 and 3 in one colour and starts where they stand."""
    table = load_scenario("paper")
    text = f'include = ["{scenario_path("paper")}"]\nname = "alike"\n[tags]\nlook_alikes = true\n'
    for robot in table.robots:
        x, y, _ = PLACES[int(robot.id)]
        rear = "red" if robot.id == 1 else "blue"
        text += f'[[robots]]\nid = {robot.id}\ncolors = {{ rear = "{rear}" }}\n'
        text += f"start = {{ x_m = {x}, y_m = {y} }}\n"
    (tmp_path / "alike.toml").write_text(text)
    return str(tmp_path / "alike.toml")


def test_look_alikes_begin_at_their_starts_without_doubt(alike: str) -> None:
    stage = Stage(alike)
    cycle = stage.watch(PLACES, 3)
    assert cycle.phase == "running"
    assert not stage.notes
    assert stage.error_mm(3, PLACES[3]) < 5.0


def test_away_from_their_starts_they_are_doubted_and_nothing_is_driven(alike: str) -> None:
    elsewhere = {**PLACES, 2: (0.2, 0.8, 2.0), 3: (1.0, 0.2, 1.0)}
    stage = Stage(alike)
    assert stage.watch(elsewhere, 5).phase == "idle"
    assert [note.split(": ")[1][:22] for note in stage.notes] == [
        "robot 2 may be 3, whic", "robot 3 may be 2, whic"]  # fmt: skip
    driven = Stage(alike, ("safety.drive_ambiguous=true",))
    assert driven.watch(elsewhere, 5).phase == "running"
    assert len(driven.notes) == 2


def test_one_lost_is_certain_two_lost_are_not(alike: str) -> None:
    stage = Stage(alike)
    stage.watch(PLACES, 10)
    stage.watch({r: p for r, p in PLACES.items() if r != 2}, 30)
    stage.watch({**PLACES, 2: (1.0, 0.2, 0.0)}, 3)
    assert stage.error_mm(2, (1.0, 0.2, 0.0)) < 5.0
    assert not stage.notes
    stage.watch({1: PLACES[1]}, 30)
    cycle = stage.watch({**PLACES, 2: (1.0, 0.2, 0.0)}, 3)
    assert {r for r, track in stage.memory.tracks.items() if track.ambiguous} == {2, 3}
    assert len(stage.notes) == 2
    assert all(c.twist.v == 0.0 for c in cycle.commands if c.robot_id in (2, 3))
    assert replace(stage.memory.tracks[1]).ambiguous is False
