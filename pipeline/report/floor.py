"""The paper's figure 6: where the robots drove, with their outlines at intervals."""

from math import cos, hypot, sin
from typing import TYPE_CHECKING

import numpy as np

from control.formation import by_follower
from control.geometry import Pose2D
from control.placement import wanted_pose
from pipeline.report.marks import best_states
from pipeline.report.series import Floats, Series
from pipeline.report.style import GREY, color_of, new_figure, say_empty
from pipeline.setup import Setup
from pipeline.viewers.stage import name_of, placed

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SNAPSHOTS = 9  # at most
_INTERVALS = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 60.0)  # round ones [s]
ASIDE = 0.085  # from the leader to its time [m]


def trajectories(series: Series, setup: Setup) -> "Figure":
    """Figure 6: trajectories, outlines and links at intervals, the wanted formation.

    Args:
        series: of the run.
        setup: formation, plan and tags.

    Returns:
        The floor from above.
    """
    figure, (axes,) = new_figure(5.2)
    states, times = best_states(series)
    if not np.isfinite(states).any():
        say_empty(axes, "no robot was seen")
    else:
        _draw_plan(axes, setup, series)
        _draw_paths(axes, series)
        _draw_obstacles(axes, setup, series, _snapshots(times, states))
        for k in _snapshots(times, states):
            _draw_snapshot(axes, setup, states[k], float(times[k]))
        for place, text in _times_told(times, states):
            axes.text(*place, text, fontsize=7.5, color="#444444", ha="center", va="center")
        figure.legend(loc="outside upper center", ncols=5, fontsize=9)
        axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("x  [m]")
    axes.set_ylabel("y  [m]")
    return figure


def _draw_plan(axes: "Axes", setup: Setup, series: Series) -> None:
    if not series.started:
        return
    if np.isfinite(series.planned).any():
        line = series.planned.T
        axes.plot(*line, color=GREY, lw=1.0, ls=(0, (5, 4)), label="leader's plan", zorder=1)
    for o in setup.errand.obstacles if setup.errand else ():  # where they are at the start
        axes.fill(*_disc(o.x, o.y, o.radius), color=GREY)


def _draw_obstacles(axes: "Axes", setup: Setup, series: Series, moments: list[int]) -> None:
    """Obstacles that wear a tag: their ways, and how much room each wants at some moments."""
    for number, (robot, radius) in enumerate(setup.worn.items()):
        places = series.obstacles[:, number]
        axes.plot(*places.T, color=GREY, lw=0.7)
        for x, y in places[moments].tolist():
            axes.plot(*_disc(x, y, radius), color=GREY, lw=0.9)
        for x, y in places[moments[-1:]].tolist():
            axes.text(x, y, name_of(robot), color=GREY, ha="center", va="center")


def _disc(x: float, y: float, radius: float) -> tuple[Floats, Floats]:
    """Places on a rim [m]."""
    turn = np.linspace(0.0, 2.0 * np.pi, 73)
    return x + radius * np.cos(turn), y + radius * np.sin(turn)


def _draw_paths(axes: "Axes", series: Series) -> None:
    """True paths wide and pale, estimated ones thin."""
    for robot, robot_id in enumerate(series.robots):
        color, name = color_of(robot), name_of(robot_id)
        true, believed = series.true[:, robot], series.believed[:, robot]
        known = np.isfinite(true).any()
        if known:
            axes.plot(true[:, 0], true[:, 1], color=color, lw=2.6, alpha=0.4, label=name)
        label, width = (None, 0.7) if known else (name, 1.4)
        axes.plot(believed[:, 0], believed[:, 1], color=color, lw=width, label=label)
    axes.plot([], [], color=GREY, lw=0.9, ls=":", label="wanted places")


def _snapshots(times: Floats, states: Floats) -> list[int]:
    """Ticks at round times at which all robots are known, few enough to be told apart."""
    known = np.flatnonzero(np.isfinite(states[:, :, 0]).all(axis=1) & (times >= 0.0))
    if not len(known):
        return []
    span = times[known[-1]] - times[known[0]]
    interval = next((i for i in _INTERVALS if span / i < _SNAPSHOTS), span / _SNAPSHOTS)
    wanted = np.arange(0.0, times[known[-1]] + 1e-9, interval)
    nearest = np.searchsorted(times[known], wanted - 1e-6).clip(max=len(known) - 1)
    return sorted({int(known[k]) for k in nearest})


def _times_told(times: Floats, states: Floats) -> list[tuple[tuple[float, float], str]]:
    """Beside the leader the times of its snapshots, together where it stood."""
    told: list[tuple[tuple[float, float], str]] = []
    for k in _snapshots(times, states):
        x, y, theta = states[k, 0, :3].tolist()
        place, text = (x - ASIDE * sin(theta), y + ASIDE * cos(theta)), f"{times[k]:.3g}"
        if told and hypot(place[0] - told[-1][0][0], place[1] - told[-1][0][1]) < ASIDE:
            text = f"{told.pop()[1].removesuffix(' s')}, {text}"
        told.append((place, f"{text} s"))
    return told


def _draw_snapshot(axes: "Axes", setup: Setup, states: Floats, t: float) -> None:
    """Bodies, links from leaders to followers, and wanted places."""
    robots = setup.formation.robots
    poses = {robots[i]: Pose2D(*states[i, :3].tolist()) for i in range(len(robots))}
    outline = {tag.robot_id: tag.parts[0].polygon for tag in setup.tags.tags}
    for index, robot_id in enumerate(robots):
        if robot_id in outline:
            _draw_body(axes, outline[robot_id], poses[robot_id], color_of(index))
    for robot, pairs in by_follower(setup.formation.pairs).items():
        follower, leaders = poses[robot], [poses[pair.leader] for pair in pairs]
        for leader in leaders:
            axes.plot([leader.x, follower.x], [leader.y, follower.y], color=GREY, lw=0.6, zorder=2)
        if robot in outline:
            references = [pair.shape.at(t) for pair in pairs]
            wanted = wanted_pose(leaders, references, follower, setup.follower.camera_offset)
            line = placed(outline[robot], wanted)
            axes.fill(*line.T, fill=False, ec=color_of(robots.index(robot)), lw=0.9, ls=":")


def _draw_body(axes: "Axes", outline: Floats, pose: Pose2D, color: str) -> None:
    axes.fill(*placed(outline, pose).T, fc=color, ec=color, lw=0.8, alpha=0.55, zorder=3)
    nose = placed(np.array([(0.0, 0.0), (0.5 * np.ptp(outline[:, 0]), 0.0)]), pose)
    axes.plot(*nose.T, color="white", lw=1.2, zorder=4, solid_capstyle="butt")
