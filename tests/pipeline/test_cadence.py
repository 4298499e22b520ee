"""The cadence report, from moments whose times are known."""

from dataclasses import replace

import numpy as np
import pytest

from control.command import Command
from control.unicycle import Twist
from datasets.cycle import Cycle, Moment, Orders, SafetyEvent, Tick, Timing
from pipeline.cadence import Cadence
from pipeline.links import link_advice
from pipeline.radios.report import SIMULATED, LinkCounts, RobotReport, RoundTrip
from pipeline.transitions import Transitions
from vision.frame import as_frame
from vision.light import PALETTE_LIGHT
from vision.scene import Scene

PICTURE = np.zeros((4, 6, 3), np.uint8)
PERIOD = 0.010


def moment(
    t: float, taken: float | None, late: float = 0.0, work: float = 0.001, report: bool = False
) -> Moment:
    """A cycle at t, perhaps with a frame that was taken before and arrived 4 ms later."""
    frame = scene = None
    if taken is not None:
        frame = as_frame(PICTURE, taken, 0, "c", taken + 0.004)
        scene = Scene(taken, (), (), PALETTE_LIGHT)
    cycle = Cycle(t, t, "running", 0.0, scene, (), (), None, ())
    tick = Tick(t, frame, (), Orders(report=report))
    return Moment(tick, cycle, (), Timing(0.0, work, work, late))


def measured(
    every: int, late: float = 0.0, work: float = 0.001, gaps: tuple[int, ...] = ()
) -> Cadence:
    """A hundred frames, one every so many ticks."""
    cadence = Cadence(1.0 / (4 * PERIOD), PERIOD, lambda _: None)
    for n in range(100 * every):
        shows = n % every == 0 and n // every not in gaps
        t = n * PERIOD
        cadence.observe(moment(t, t - 0.006 if shows else None, late, work))
    return cadence


def test_the_table_has_the_times_that_passed() -> None:
    rows = {name: values for name, *values in measured(4, late=0.0002).rows()}
    assert rows["between two frames"] == pytest.approx([40.0] * 3)
    assert rows["capture to arrival"] == pytest.approx([4.0] * 3)
    assert rows["capture to pose and law"] == pytest.approx([6.0] * 3)
    assert rows["frame to command, computing"] == pytest.approx([1.0] * 3)
    assert rows["loop later than its beat"] == pytest.approx([0.2] * 3)
    assert measured(4).advice() == ()


def test_what_is_wrong_is_told_with_what_helps() -> None:
    (slow,) = measured(8).advice()
    assert "delivers 12.5 of 25 frames/s" in slow
    assert "exposure" in slow
    (missing,) = measured(4, gaps=(10, 30)).advice()
    assert missing.startswith("2 of 97 times a frame was missing")
    (late,) = measured(4, late=0.006).advice()
    assert "6.0 ms late, every 10 ms" in late
    (work,) = measured(4, work=0.012).advice()
    assert "up to 12.0 ms of 10 ms" in work


def test_a_camera_that_is_looked_at_less_often_is_not_called_slow() -> None:
    cadence = Cadence(60.0, 0.060, lambda _: None)
    for n in range(100):
        cadence.observe(moment(0.060 * n, 0.060 * n - 0.006))
    assert cadence.advice() == ()


LINK = RobotReport(2, "/dev/rfcomm2", True, None, LinkCounts(sent=198, replaced=201))
SIMULATED_LINK = RobotReport(1, SIMULATED, True, None, LinkCounts(sent=399))


def driven(*reports: RobotReport) -> Cadence:
    """Four seconds of commands at 100 Hz, the first two of them without."""
    said = list[str]()
    cadence = Cadence(30.0, PERIOD, said.append, lambda: reports)
    commands = tuple(Command(robot, Twist(0.1, 0.0), 0.0, 1.0) for robot in (1, 2))
    for n in range(601):
        one = moment(n * PERIOD, None)
        cycle = replace(one.cycle, commands=commands if n > 200 else ())
        cadence.observe(replace(one, cycle=cycle))
    return cadence


def test_links_tell_what_they_carried_of_what_was_asked() -> None:
    cadence = driven(SIMULATED_LINK, LINK)
    (row,) = cadence.links()  # a simulated one that carries everything has nothing to tell
    assert row.asked_per_s == pytest.approx(100.0, rel=0.01)
    assert row.carried_per_s == pytest.approx(49.5, rel=0.01)
    (advice,) = link_advice((row,))
    assert advice.startswith("robot 2 on /dev/rfcomm2: 50 of 100 commands/s are carried")
    lines = list(cadence.lines())
    assert lines[-2] == "robot 2 on /dev/rfcomm2: 49.6 of 100.3 commands/s carried"
    assert lines[-1] == advice
    assert cadence.to_json(timed=False)["cadence"] is None
    assert cadence.to_json(timed=True)["links"][0]["overtaken"] == 201


def test_what_is_wrong_with_a_link_is_told_with_what_helps() -> None:
    counts = LinkCounts(sent=399, failures=2, lost=3, doubled=4, silences=5)
    trip = RoundTrip(asked=10, unanswered=1, p50=0.012, longest=0.5)
    bad = replace(LINK, counts=counts, garbage=6, foreign=7, round_trip=trip)
    said = [
        line.removeprefix("robot 2 on /dev/rfcomm2: ") for line in link_advice(driven(bad).links())
    ]
    assert [line.split(":")[0] for line in said] == [
        "the link failed 2 times", "10 % of its questions got no answer",
        "7 replies name another robot", "6 bytes of garbage came",
        "3 messages were lost, 4 arrived twice",
        "the robots were stopped 5 times because no command came",
    ]  # fmt: skip
    assert list(link_advice(driven(replace(LINK, counts=LinkCounts(sent=390))).links())) == []


def test_it_is_told_on_request_and_without_anything() -> None:
    said = list[str]()
    cadence = Cadence(30.0, PERIOD, said.append)
    assert (cadence.rows(), cadence.advice()) == ((), ())
    cadence.observe(moment(0.0, -0.006, report=True))
    assert [line.split(":")[0] for line in said] == [
        "capture to arrival", "capture to pose and law", "frame to command, computing",
        "loop later than its beat",
    ]  # fmt: skip


def test_transitions_are_told_with_their_reasons() -> None:
    said = list[str]()
    observer = Transitions(said.append, waits=False)
    first = moment(1.0, None)
    lost = SafetyEvent(1.5, "robot-stopped", 2, "last seen 0.31 s ago")
    near = SafetyEvent(1.5, "kept-apart", 3, "kept")
    for phase, events in (
        ("armed", ()), ("running", ()), ("holding", (near, lost)), ("holding", ()), ("running", ()),
        ("finished", ()),
    ):  # fmt: skip
        observer.observe(replace(first, cycle=replace(first.cycle, phase=phase, events=events)))
    assert said == [
        "1.00 s: running -> holding (robot 2: last seen 0.31 s ago)", "1.00 s: holding -> running",
    ]  # fmt: skip
