"""Reports: the paper's four figures and one page, from whole, short, blind and empty sessions."""

import re
from base64 import b64decode
from collections.abc import Iterable
from dataclasses import replace
from math import pi
from pathlib import Path

import cv2
import numpy as np
import pytest

from control.formation import Formation, Pair, Shape
from control.profile import TanhStep
from datasets.cycle import Moment
from datasets.errors import RecordingError
from datasets.recorded import SessionHeader, SessionWriter
from pipeline.report.make import make_report
from pipeline.report.marks import Marks, changes, marks_of, speed_peaks, turns
from pipeline.report.series import Collector, Series
from pipeline.scenario import load_scenario
from pipeline.setup import Setup, make_setup
from tests.datasets.recorded_moments import moments
from vision.scene import Scene

NAMES = ("fig6_trajectories", "fig7_tracking_errors", "fig8_linear_velocities",
         "fig9_angular_velocities", "latency", "omega", "camera")  # fmt: skip


@pytest.fixture(scope="module")
def setup() -> Setup:
    return make_setup(load_scenario("paper"))


@pytest.fixture(scope="module")
def run() -> list[Moment]:
    return list(moments(5.3))


def series_of(setup: Setup, run: Iterable[Moment]) -> Series:
    collector = Collector(setup)
    for moment in run:
        collector.observe(moment)
    return collector.series()


def record(path: Path, run: Iterable[Moment], name: str = "a <b> & c") -> Path:
    writer = SessionWriter(path, SessionHeader(name, '{"K": 2}', 5, (("numpy", "2"),)), True)
    for moment in run:
        writer.observe(moment)
    writer.close()
    return path


def blind(moment: Moment) -> Moment:
    """The same moment when nothing is known: no truth, no robot, no mission."""
    scene = None if moment.cycle.scene is None else Scene(moment.cycle.scene.t_capture, ())
    cycle = replace(moment.cycle, phase="idle", t_start=None, scene=scene, robots=(), pairs=(),
                    planned=None, commands=(), events=())  # fmt: skip
    return replace(moment, cycle=cycle, truth=())


def check(page: Path) -> str:
    """The page holds every PNG that lies beside it, and nothing from elsewhere."""
    text = page.read_text()
    inside = [b64decode(data) for data in re.findall(r'src="data:image/png;base64,([^"]+)"', text)]
    assert inside == [(page.parent / f"{name}.png").read_bytes() for name in NAMES]
    for png in inside:
        image = cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_COLOR)
        assert image is not None
        assert image.shape[1] >= 640
    assert "http" not in text
    assert "nan" not in re.sub(r"base64,[^\"]+", "", text)
    return text


def test_whole_run(setup: Setup, run: list[Moment], tmp_path: Path) -> None:
    session = record(tmp_path / "s.mcap", run)
    text = check(make_report(session, tmp_path / "out", setup))
    assert "a &lt;b&gt; &amp; c" in text
    for what in ("seed 5", "<td>numpy</td><td>2</td>", "&quot;K&quot;: 2", "not seen for 0.10 s"):
        assert what in text


def test_same_session_same_bytes(setup: Setup, run: list[Moment], tmp_path: Path) -> None:
    session = record(tmp_path / "s.mcap", run[:100])
    one, two = (make_report(session, tmp_path / name, setup) for name in ("one", "two"))
    assert one.read_bytes() == two.read_bytes()


def test_without_truth(setup: Setup, run: list[Moment], tmp_path: Path) -> None:
    unknown = (replace(moment, truth=()) for moment in run[:600])
    text = check(make_report(record(tmp_path / "s.mcap", unknown), tmp_path / "out", setup))
    assert "no truth" in text
    assert "recall" not in text


def test_footage_in_which_nothing_is_found(setup: Setup, run: list[Moment], tmp_path: Path) -> None:
    session = record(tmp_path / "s.mcap", map(blind, run[:200]))
    text = check(make_report(session, tmp_path / "out", setup))
    assert "0 robots found" in text
    assert "<td>R2</td><td>R1</td><td>–</td>" in text


@pytest.mark.parametrize("kind", ["nothing", "one frame", "one frame with nothing in it"])
def test_hardly_anything(setup: Setup, run: list[Moment], tmp_path: Path, kind: str) -> None:
    first = next(moment for moment in run if moment.tick.frame)
    kept = {"nothing": [], "one frame": [first]}.get(kind, [blind(first)])
    check(make_report(record(tmp_path / "s.mcap", kept), tmp_path / "out", setup))


def test_says_when_the_recording_was_cut_off(
    setup: Setup, run: list[Moment], tmp_path: Path
) -> None:
    session = record(tmp_path / "s.mcap", run[:300])
    session.write_bytes(session.read_bytes()[: session.stat().st_size // 2])
    assert "cut off" in check(make_report(session, tmp_path / "out", setup))


def test_unusable_places_are_named(setup: Setup, run: list[Moment], tmp_path: Path) -> None:
    session = record(tmp_path / "s.mcap", run[:20])
    (tmp_path / "file").touch()
    with pytest.raises(RecordingError, match=r"file: cannot be written"):
        make_report(session, tmp_path / "file", setup)
    with pytest.raises(RecordingError, match=r"missing\.mcap"):
        make_report(tmp_path / "missing.mcap", tmp_path / "out", setup)


def test_marks_come_from_the_scenario(setup: Setup) -> None:
    (turn,) = turns(setup.path, setup.duration)
    assert turn.start == pytest.approx(2.6, abs=0.01)  # s: 0.25 m of ramp, 0.8 m at 0.5 m/s
    assert turn.end == pytest.approx(2.6 + 0.8 * pi, abs=0.01)
    assert turn.text == "turn 180° left, R = 0.4 m"
    (change,) = changes(setup)
    assert change.start == 5.5
    assert change.text == "R2 0.2 → 0.15 m, R3 0.2 → 0.3 m"
    still = Shape(TanhStep.constant(0.3), TanhStep.constant(pi))
    assert changes(replace(setup, formation=Formation((Pair(1, 2, still),)))) == ()


def test_arrival_needs_everybody(setup: Setup) -> None:
    assert marks_of(setup, [3.0, 4.5], 8.0).instants[0].start == 4.5
    assert len(marks_of(setup, [3.0, None], 8.0).instants) == 1
    assert len(marks_of(setup, [0.0, 0.0], 8.0).instants) == 1


def test_a_run_cut_short_has_no_marks_behind_its_end(setup: Setup) -> None:
    marks = marks_of(setup, [0.0, 0.0], 3.0)
    assert marks.instants == ()
    assert [turn.end for turn in marks.turns] == pytest.approx([3.0], abs=0.01)
    assert marks_of(setup, [], 1.0) == Marks()


def test_series_hold_what_was_observed(setup: Setup, run: list[Moment]) -> None:
    series = series_of(setup, run)
    k = 1000
    moment, ids = run[k], series.robots
    assert series.times[k] == moment.tick.t
    assert series.ahead[k] == moment.cycle.t_effective
    for truth in moment.truth:
        state = truth.state
        row = series.true[k, ids.index(truth.robot_id)]
        assert row.tolist() == [state.x, state.y, state.theta, state.v, state.omega]
    for index, pair in enumerate(moment.cycle.pairs):
        error = pair.reference.distance - pair.relative.distance
        assert series.believed_errors[index, k, 0] == error
    # The followers obey (1 + t) exp(-t) exactly: from -150 mm and -50 mm.
    fade = (1 + series.times) * np.exp(-series.times)
    assert series.true_errors[0, 1:, 0] == pytest.approx(-0.15 * fade[1:], abs=2e-3)
    assert series.true_errors[1, 1:, 0] == pytest.approx(-0.05 * fade[1:], abs=2e-3)
    assert len(series.frames) == sum(moment.cycle.scene is not None for moment in run)
    assert series.phases == ((0.0, "running"),)


def test_outer_follower_speeds_up_inner_slows_down(setup: Setup, run: list[Moment]) -> None:
    series = series_of(setup, run)
    outer, inner = speed_peaks(series, turns(setup.path, setup.duration))
    assert (outer.robot_id, inner.robot_id) == (3, 2)
    assert outer.value > 0.6 > 0.45 > inner.value  # m/s
    assert outer.text == f"R3 up to {outer.value:.2f} m/s"


def test_mission_clock_starts_with_the_mission(setup: Setup, run: list[Moment]) -> None:
    starts = (0.5 if moment.tick.t >= 0.5 else None for moment in run)
    late = [
        replace(m, cycle=replace(m.cycle, t_start=start))
        for m, start in zip(run[:300], starts, strict=False)
    ]
    series = series_of(setup, late)
    assert series.times[0] == -0.5
    assert np.isnan(series.true_errors[:, :100]).all()
    assert np.isfinite(series.true_errors[:, 101:]).all()
