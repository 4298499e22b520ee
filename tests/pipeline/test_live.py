"""However a run ends, every robot is told to stop and everything is closed."""

import gc
from dataclasses import replace

import pytest

from control.command import Command, RobotId
from datasets.cycle import Moment
from datasets.errors import RecordingError
from pipeline.errors import CameraError
from pipeline.live import Rig, run
from pipeline.ports import CommandSink, EndOfStream
from pipeline.rigs import connect
from pipeline.scenario import load_scenario
from pipeline.setup import Setup, make_setup
from tests.pipeline.runs import Keeper
from vision.frame import Frame


class Listener:
    """A radio that notes what it is told and passes it on."""

    min_period = 0.0

    def __init__(self, inner: CommandSink) -> None:
        self._inner, self.told = inner, list[str]()

    def send(self, commands: tuple[Command, ...], now: float) -> tuple[RobotId, ...]:
        self.told += ["command"] * len(commands)
        return self._inner.send(commands, now)

    def stop(self, now: float) -> None:
        self.told.append("stop")
        self._inner.stop(now)

    def close(self) -> None:
        self.told.append("close")
        self._inner.close()


class Breaking(Keeper):
    """An observer or camera that fails after a while."""

    def __init__(self, rig: Rig, error: Exception) -> None:
        super().__init__()
        self._source, self._error = rig.source, error

    def observe(self, moment: Moment) -> None:
        super().observe(moment)
        if moment.tick.t > 0.5:
            raise self._error

    def latest(self, now: float) -> Frame | None:
        if now > 0.5:
            raise self._error
        return self._source.latest(now)


@pytest.fixture(scope="module")
def setup() -> Setup:
    return make_setup(load_scenario("paper"))


def new_rig() -> tuple[Rig, Listener]:
    """The rendered world with a listening radio."""
    rig = connect(load_scenario("paper"), "rendered", None, 0, True)
    radio = Listener(rig.sink)
    return replace(rig, sink=radio), radio


def check_stopped(radio: Listener, keeper: Keeper) -> None:
    assert radio.told[-2:] == ["stop", "close"]
    assert "command" in radio.told
    assert keeper.closed


def test_at_the_end_of_the_time_and_on_interruption(setup: Setup) -> None:
    for duration, interrupted, why in ((0.5, lambda: False, "time"), (None, None, "interrupted")):
        (rig, radio), keeper = new_rig(), Keeper()
        asked = interrupted or (lambda keeper=keeper: len(keeper.moments) > 50)
        assert run(setup, replace(rig, observers=(keeper,)), 0.01, duration, asked) == why
        check_stopped(radio, keeper)


def test_when_the_camera_fails_or_ends(setup: Setup) -> None:
    for error in (CameraError("unplugged"), EndOfStream("over")):
        (rig, radio), keeper = new_rig(), Keeper()
        broken = replace(rig, source=Breaking(rig, error), observers=(keeper,))
        if isinstance(error, CameraError):
            with pytest.raises(CameraError, match="unplugged"):
                run(setup, broken, 0.01)
        else:
            assert run(setup, broken, 0.01) == "frames ended"
        check_stopped(radio, keeper)


def test_when_an_observer_fails(setup: Setup) -> None:
    (rig, radio), keeper = new_rig(), Keeper()
    watched = replace(rig, observers=(Breaking(rig, RecordingError("disk full")), keeper))
    with pytest.raises(RecordingError, match="disk full"):
        run(setup, watched, 0.01)
    check_stopped(radio, keeper)


def test_when_a_command_cannot_be_computed(setup: Setup) -> None:
    (rig, radio), keeper = new_rig(), Keeper()
    small = replace(setup.camera, size_px=(64, 64))
    broken = replace(setup, seeing=replace(setup.seeing, camera=small, any_size=False))
    with pytest.raises(Exception, match="320 x 240 px"):
        run(broken, replace(rig, observers=(keeper,)), 0.01)
    assert radio.told == ["stop", "close"]
    assert keeper.closed


def test_without_a_radio_simulated_robots_stand(setup: Setup) -> None:
    rig, keeper = connect(load_scenario("paper"), "rendered", "none", 0, True), Keeper()
    run(setup, replace(rig, observers=(keeper,)), 0.01, 1.0)
    assert any(moment.cycle.commands for moment in keeper.moments)
    assert all(robot.state.v == 0.0 for moment in keeper.moments for robot in moment.truth)


def test_the_time_counts_from_the_first_tick(setup: Setup) -> None:
    (rig, _), keeper = new_rig(), Keeper()
    rig.clock.wait_until(2.0)  # what was opened first has read the clock
    assert run(setup, replace(rig, observers=(keeper,)), 0.01, 0.5) == "time"
    assert 2.4 < keeper.moments[-1].tick.t < 2.6


def test_garbage_is_not_sought_among_what_was_set_up(setup: Setup) -> None:
    class Counting(Keeper):
        def observe(self, moment: Moment) -> None:
            super().observe(moment)
            frozen.append(gc.get_freeze_count())

    frozen: list[int] = []
    before = gc.get_freeze_count()
    (rig, _) = new_rig()
    run(setup, replace(rig, observers=(Counting(),)), 0.01, 0.1)
    assert min(frozen) > before + 50_000  # objects: all modules, and what they made
    assert gc.get_freeze_count() <= before
