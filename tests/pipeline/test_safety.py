"""What the promises mean for driving robots: each event is caused, and true speeds are watched."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from control.command import RobotId
from datasets.cycle import Moment, RobotState
from pipeline.cameras.rendered import RenderedCamera
from pipeline.filming import make_renderer
from pipeline.live import run
from pipeline.rigs import connect
from pipeline.scenario import load_scenario
from pipeline.setup import make_setup
from tests.pipeline.runs import Keeper
from vision.frame import Frame

START, END = 1.5, 2.5  # of the disturbance [s]


class CoveredRenderer:
    """A renderer over which somebody holds a hand: one robot cannot be seen for a while."""

    def __init__(self, robot: RobotId) -> None:
        self._inner, self._robot = make_renderer(load_scenario("paper")), robot

    def render(self, states: tuple[RobotState, ...], t: float) -> NDArray[np.uint8]:
        hidden = START <= t < END
        seen = tuple(s for s in states if not (hidden and s.robot_id == self._robot))
        return self._inner.render(seen, t)


class GappyCamera:
    """A camera that delivers nothing for a while."""

    def __init__(self, inner: RenderedCamera) -> None:
        self._inner = inner

    def latest(self, now: float) -> Frame | None:
        frame = self._inner.latest(now)
        return None if START <= now < END else frame

    def close(self) -> None:
        self._inner.close()


class DroppingLink:
    """A radio whose link to one robot is down for a while: nothing arrives, and it says so."""

    min_period = 0.0

    def __init__(self, inner, robot: RobotId) -> None:  # type: ignore[no-untyped-def]
        self._inner, self._robot = inner, robot

    def send(self, commands, now):  # type: ignore[no-untyped-def]
        down = START <= now < END
        reached = tuple(c for c in commands if not (down and c.robot_id == self._robot))
        return (*self._inner.send(reached, now), *((self._robot,) if down else ()))

    def stop(self, now: float) -> None:
        self._inner.stop(now)

    def close(self) -> None:
        self._inner.close()


def disturbed(kind: str, robot: RobotId = 0) -> list[Moment]:
    """Run the paper's experiment for 5 s with one disturbance."""
    scenario = load_scenario("paper")
    setup, keeper = make_setup(scenario), Keeper()
    rig = connect(scenario, "rendered", None, 0, True)
    if kind == "covered":
        rig.source._renderer = CoveredRenderer(robot)  # type: ignore[attr-defined]
    elif kind == "gap":
        rig = replace(rig, source=GappyCamera(rig.source))  # type: ignore[arg-type]
    elif kind == "link":
        rig = replace(rig, sink=DroppingLink(rig.sink, robot))
    run(setup, replace(rig, observers=(keeper,)), setup.period, 5.0)
    return keeper.moments


def speeds(moments: list[Moment], robot: RobotId, start: float, end: float) -> NDArray[np.float64]:
    """True speeds of a robot in an interval [m/s]."""
    states = [m.truth for m in moments if start <= m.tick.t < end]
    return np.array([s.state.v for row in states for s in row if s.robot_id == robot])


def kinds(moments: list[Moment]) -> list[str]:
    """Names of what the safety rules did; the filter between bodies has tests of its own."""
    events = [event.kind for m in moments for event in m.cycle.events]
    return [kind for kind in events if kind != "kept-apart"]


def test_a_covered_follower_stands_and_is_taken_back() -> None:
    moments = disturbed("covered", 2)
    stands = START + 0.3 + 0.3  # by the rules, and until the motors have stopped
    assert np.abs(speeds(moments, 2, stands, END)).max() < 0.02
    assert speeds(moments, 1, stands, END).min() > 0.4  # nobody follows robot 2
    assert np.abs(speeds(moments, 2, END + 0.3, 5.0)).max() > 0.3
    assert kinds(moments) == ["robot-stopped", "robot-free"]
    assert all(np.abs(speeds(moments, robot, 0.0, 5.0)).max() <= 1.5 for robot in (1, 2, 3))


def test_a_covered_leader_stops_all_and_the_mission_waits() -> None:
    moments = disturbed("covered", 1)
    stands = START + 0.3 + 0.3
    for robot in (1, 2, 3):
        assert np.abs(speeds(moments, robot, stands, END)).max() < 0.02
        assert np.abs(speeds(moments, robot, END + 0.5, 5.0)).max() > 0.3
    starts = {m.cycle.t_start for m in moments if m.tick.t > END + 0.2}
    (start,) = starts
    assert start is not None
    assert 0.6 < start < 1.0  # the clock stood still while they stood
    leader = [m.cycle.planned for m in moments if m.cycle.planned is not None]
    jumps = np.diff([plan.state.x for plan in leader])
    assert np.abs(jumps).max() < 0.01  # m: the plan did not run away


def test_a_silent_camera_stops_all_until_a_second_of_good_frames() -> None:
    moments = disturbed("gap")
    for robot in (1, 2, 3):
        assert np.abs(speeds(moments, robot, START + 0.2 + 0.4, END + 1.0)).max() < 0.02
        assert np.abs(speeds(moments, robot, END + 1.5, 5.0)).max() > 0.3
    assert kinds(moments)[0] == "camera-silent"
    assert "camera-back" in kinds(moments)


def test_a_lost_link_is_commanded_to_stand_when_it_returns() -> None:
    moments = disturbed("link", 3)
    told = [c.twist for m in moments for c in m.cycle.commands
            if c.robot_id == 3 and START + 0.1 < m.tick.t < END]  # fmt: skip
    assert {(twist.v, twist.omega) for twist in told} == {(0.0, 0.0)}
    assert np.abs(speeds(moments, 3, END + 0.5, 5.0)).max() < 1.5
    assert kinds(moments) == ["robot-stopped", "robot-free"]
