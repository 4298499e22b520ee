"""What happened when: turns and changes of shape as planned, and what the robots made of it."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from math import degrees
from typing import Literal

import numpy as np

from control.command import RobotId
from control.plan import Plan, PlannedPath
from pipeline.report.series import Floats, Series
from pipeline.setup import Setup
from pipeline.viewers.stage import name_of

_STEP = 0.002  # resolution of the plan's turns [s]
_TOLD = 2  # robots named at one change of the shape


@dataclass(frozen=True, slots=True)
class Mark:
    """Something worth pointing at, on the mission's clock.

    Attributes:
        start: when it begins [s].
        end: when it ends, equal to start for an instant [s].
        text: what it is, in a few words with numbers.
        align: which side of the text is at the mark.
    """

    start: float
    end: float
    text: str
    align: Literal["left", "center", "right"] = "center"


@dataclass(frozen=True, slots=True)
class Marks:
    """What is marked in every plot over time.

    Attributes:
        turns: spans in which the leader's plan turns.
        instants: when the formation was reached, and when its shape changes.
    """

    turns: tuple[Mark, ...] = ()
    instants: tuple[Mark, ...] = ()


@dataclass(frozen=True, slots=True)
class Peak:
    """The greatest or least speed of a follower in a turn.

    Attributes:
        robot_id: the follower.
        t: when, on the mission's clock [s].
        value: the speed [m/s].
        outer: whether it drives on the outside of the turn.
        text: what it says.
    """

    robot_id: RobotId
    t: float
    value: float
    outer: bool
    text: str


def marks_of(setup: Setup, settled: Iterable[float | None], until: float) -> Marks:
    """All marks of a run.

    Args:
        setup: plan and formation.
        settled: when each follower had come to its place, None if never [s].
        until: when the run ended, mission clock [s].

    Returns:
        The marks.
    """
    instants = arrival(settled) + changes(setup)
    return Marks(
        turns(setup.path, min(setup.duration, until)),
        tuple(instant for instant in instants if instant.start <= until),
    )


def turns(path: Plan | None, duration: float) -> tuple[Mark, ...]:
    """Turns the leader has planned.

    Args:
        path: its plan.
        duration: of the mission [s].

    Returns:
        Spans in which the plan turns, with radius and angle; none unless it is made of arcs.
    """
    if not isinstance(path, PlannedPath):
        return ()
    times = np.arange(0.0, duration, _STEP).tolist()
    states = [path.at(t).state for t in times]
    found = []
    for turning, group in groupby(zip(times, states, strict=True), key=lambda at: at[1].omega != 0):
        span = list(group)
        if turning and len(span) > 1:
            (start, first), (end, last) = span[0], span[-1]
            angle, radius = degrees(last.theta - first.theta), abs(last.v / last.omega)
            side = "left" if angle > 0.0 else "right"
            found.append(Mark(start, end, f"turn {abs(angle):.0f}° {side}, R = {radius:g} m"))
    return tuple(found)


def changes(setup: Setup) -> tuple[Mark, ...]:
    """Moments at which the wanted shape changes.

    Args:
        setup: with the formation.

    Returns:
        Instants in order of time; pairs that change together share one.
    """
    told: dict[float, dict[RobotId, list[str]]] = {}
    for pair in setup.formation.pairs:
        distances = ((step, 1.0, " m") for step in pair.shape.distance.steps)
        turns = pair.shape.bearing.steps if pair.shape.bearing else ()
        bearings = ((step, degrees(1.0), "°") for step in turns)
        for step, scale, unit in (*distances, *bearings):
            if step.t <= setup.duration:
                what = f"{scale * step.before:.3g} → {scale * step.after:.3g}{unit}"
                told.setdefault(step.t, {}).setdefault(pair.follower, []).append(what)
    late = 0.7 * setup.duration  # texts of changes go right, that of the arrival left
    return tuple(
        Mark(t, t, _shortened(robots), "left" if t < late else "center")
        for t, robots in sorted(told.items())
    )


def _shortened(told: Mapping[RobotId, Sequence[str]]) -> str:
    if sum(map(len, told.values())) > _TOLD:
        return f"{len(told)} robots change places"
    return ", ".join(f"{name_of(robot)} {', '.join(texts)}" for robot, texts in told.items())


def arrival(settled: Iterable[float | None]) -> tuple[Mark, ...]:
    """When the first shape was reached.

    Args:
        settled: when each follower had come to its place, None if never [s].

    Returns:
        One instant; none if all began in their places, or one never came.
    """
    times = list(settled)
    known = [t for t in times if t is not None]
    if len(known) < len(times) or not known or max(known) <= 0.0:
        return ()
    last = max(known)
    return (Mark(last, last, f"in formation at {last:.1f} s", "right"),)


def speed_peaks(series: Series, turns: tuple[Mark, ...]) -> tuple[Peak, ...]:
    """How followers on the outside and on the inside of turns change their speed.

    Args:
        series: of the run.
        turns: planned turns.

    Returns:
        For every turn the greatest speed of the follower that is fastest, if faster than the
        leader, and the least of the one that is slowest, if slower.
    """
    states, times = best_states(series)
    found = []
    for turn in turns:
        inside = (times >= turn.start) & (times <= turn.end)
        speeds = states[inside, :, 3]
        if np.isfinite(speeds).all() and speeds.size:
            found += _extremes(series, speeds, times[inside])
    return tuple(found)


def best_states(series: Series) -> tuple[Floats, Floats]:
    """The best known states.

    Args:
        series: of the run.

    Returns:
        True states if any are known, else predicted ones, shape (N, R, 5), and their times (N,).
    """
    if series.has_truth:
        return series.true, series.times
    return series.believed, series.ahead


def _extremes(series: Series, speeds: Floats, times: Floats) -> list[Peak]:
    """The fastest of the outer and the slowest of the inner followers in one turn."""
    peaks = []
    ahead = speeds[:, 1:].mean(axis=0) - speeds[:, 0].mean()
    for sign, word in ((1.0, "up"), (-1.0, "down")):
        who = int(np.argmax(sign * ahead))
        if sign * ahead[who] > 0.0:
            own, robot_id = speeds[:, who + 1], series.robots[who + 1]
            k = int(np.argmax(sign * own))
            text = f"{name_of(robot_id)} {word} to {own[k]:.2f} m/s"
            peaks.append(Peak(robot_id, float(times[k]), float(own[k]), sign > 0.0, text))
    return peaks
