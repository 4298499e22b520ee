"""Omega and Lambda of every follower in the plane of its errors, and the paths through them."""

from collections.abc import Mapping
from math import ceil
from typing import TYPE_CHECKING

import numpy as np

from control.command import RobotId
from control.gains import Certificate
from control.output import MIN_DISTANCE
from control.unicycle import UnicycleState
from pipeline.certificates import Certificates, Certified
from pipeline.report.marks import best_states
from pipeline.report.series import Floats, Series
from pipeline.report.style import GREY, color_of, new_figure, say_empty
from pipeline.setup import Setup
from pipeline.viewers.stage import name_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

CAPTION = (
    "Errors of every follower, wanted minus actual. Box: Omega (9); shaded: Lambda, starts that "
    "stay in it; dashed: the nominal path, a dot every second; thick and pale: the run."
)
_UNITS = np.array([1e3, np.degrees(1.0)])  # mm, deg
_ROOM = 1.22  # of a plot over Omega


def omega_sets(made: Certificates, setup: Setup, runs: Mapping[RobotId, Floats]) -> "Figure":
    """Draw Omega, Lambda and the paths of every follower that has a certificate.

    Args:
        made: the certificates.
        setup: formation.
        runs: (N, 2) errors of a run by follower [m, rad].

    Returns:
        One plot a follower.
    """
    drawn = [certified for certified in made.pairs if certified.certificate is not None]
    columns = min(2, len(drawn)) or 1
    rows = ceil(len(drawn) / columns) or 1
    figure, plots = new_figure(0.5 + 3.4 * rows, rows, columns)
    for axes, certified in zip(plots, drawn, strict=False):
        run = runs.get(certified.pair.follower)
        _draw(axes, certified, color_of(setup.formation.robots.index(certified.pair.follower)), run)
    for axes in plots[len(drawn) :]:
        axes.set_axis_off()
    if not drawn:
        say_empty(plots[0], "no follower has a certificate")
        return figure
    labelled = (zip(*axes.get_legend_handles_labels(), strict=True) for axes in reversed(plots))
    legend = {name: handle for pairs in labelled for handle, name in pairs}  # the first plot's win
    figure.legend(legend.values(), legend.keys(), ncols=6, loc="outside lower center")
    return figure


def run_errors(series: Series, setup: Setup) -> dict[RobotId, Floats]:
    """Errors of a run, from its start on.

    Args:
        series: of the run.
        setup: formation.

    Returns:
        (N, 2) by follower: true ones if any are known, else predicted ones [m, rad].
    """
    errors = series.true_errors if series.has_truth else series.believed_errors
    _, times = best_states(series)
    pairs = zip(setup.formation.pairs, errors, strict=True)
    return {pair.follower: error[times >= 0.0] for pair, error in pairs}


def run_starts(series: Series) -> dict[RobotId, UnicycleState]:
    """States of the robots when the mission started.

    Args:
        series: of the run.

    Returns:
        The first that is known of every robot.
    """
    states, times = best_states(series)
    starts = {}
    for index, robot in enumerate(series.robots):
        known = np.flatnonzero((times >= 0.0) & np.isfinite(states[:, index, 0]))
        if len(known):
            starts[robot] = UnicycleState(*states[known[0], index].tolist())
    return starts


def _draw(axes: "Axes", certified: Certified, color: str, run: Floats | None) -> None:
    certificate, course = certified.certificate, certified.course
    if certificate is None or course is None:
        return
    omega = certificate.omega
    (a, b), (w, h) = (_UNITS * np.array(box) for box in (omega.bounds, omega.invariant))
    axes.fill(*_box(w, h), fc=color, alpha=0.10, lw=0, label="Λ: stays in Ω", zorder=1)
    axes.plot(*_box(a, b), color=color, lw=1.4, label="Ω", zorder=2)
    axes.axhline(0.0, color=GREY, lw=0.6, zorder=1.5)
    axes.axvline(0.0, color=GREY, lw=0.6, zorder=1.5)
    if run is not None:
        axes.plot(*(_UNITS * run).T, color=color, lw=3.0, alpha=0.4, label="run", zorder=3)
    path = _UNITS[:, None] * course.error[0]
    axes.plot(*path, color="#222222", lw=1.2, ls=(0, (4, 2)), label="nominal path", zorder=4)
    every = round(1.0 / (course.times[1] - course.times[0]))
    axes.plot(*path[:, every::every], "o", color="#222222", ms=2.6, zorder=4)
    axes.plot(*path[:, :1], "o", color="white", mec="#222222", ms=6, label="start", zorder=5)
    axes.set_xlim(-_ROOM * a, _ROOM * a)
    axes.set_ylim(-_ROOM * b, _ROOM * b)
    _shade_leader(axes, 1e3 * (float(course.wanted[0, 0].min()) - MIN_DISTANCE), _ROOM * a)
    axes.set_title(name_of(certified.pair.follower), color=color, pad=18)
    axes.annotate(
        _verdicts(certificate), (0.0, 1.0), xycoords="axes fraction", xytext=(0, 6),
        textcoords="offset points", fontsize=8, color="#5a6068", in_layout=False,
    )  # fmt: skip
    axes.set_xlabel("distance error  [mm]")
    axes.set_ylabel("bearing error  [deg]")


def _box(a: float, b: float) -> tuple[list[float], list[float]]:
    return [a, -a, -a, a, a], [b, b, -b, -b, b]


def _shade_leader(axes: "Axes", near: float, edge: float) -> None:
    """Errors at which the follower would be at its leader when it is wanted nearest."""
    if near < edge:
        label = "too near the leader"
        axes.axvspan(near, edge, fc="#c9302c", alpha=0.13, lw=0, zorder=0.5, label=label)


def _verdicts(certificate: Certificate) -> str:
    """What is guaranteed, in a line."""
    parts = (
        ("exact robots", certificate.exact), ("model errors", certificate.run),
        ("all of Λ", certificate.everywhere),
    )  # fmt: skip
    return "    ".join(f"{'✓' if verdict.holds else '✗'} {what}" for what, verdict in parts)
